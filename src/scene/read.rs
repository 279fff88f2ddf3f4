//! Reader of scenes of any format. The extension of the file tells the format.

use std::path::Path;

use super::load_options::LoadOptions;
use super::mitsuba::description::Description;
use super::mitsuba::load::{self as xml, Watch};
use super::whole::Scene;
use crate::{Error, Result};

/// Reads the scene at `path` without reporting progress; see [`load_with_progress`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    load_with_progress(path, options, &|_| {})
}

/// Reads the scene at `path` with everything it includes. A file without a known extension is read as Mitsuba's XML.
/// `progress` is called after every mesh file, from several threads.
///
/// All faults of the scene are collected, so that one error lists them ([`Error::Several`]).
pub fn load_with_progress(path: &Path, options: &LoadOptions, progress: &Watch) -> Result<Scene> {
    let Some(describe) = describer(path) else { return xml::read(path, options, progress) };
    if let Some((name, _)) = options.defines.first() {
        let message = format!("-D {name}: only Mitsuba's XML has values that -D replaces; leave it out");
        return Err(Error::scene(path, None, message));
    }
    describe(path)?.into_scene(options, progress)
}

/// Reader that describes a scene in Mitsuba's terms.
pub(super) type Describe = fn(&Path) -> Result<Description>;

/// Reader of the format that the extension of `path` tells; `None` for Mitsuba's XML.
pub(super) fn describer(path: &Path) -> Option<Describe> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("gltf" | "glb") => Some(super::gltf::read),
        Some("pbrt") => Some(super::pbrt::read),
        _ => None,
    }
}
