//! Reader of scenes of any format. The extension of the file tells the format.

use std::path::Path;

use super::description::Description;
use super::foreign;
use super::load_options::LoadOptions;
use super::mitsuba::dictionary::Dictionary;
use super::mitsuba::{entries, xml};
use super::plugins::load::{Watch, build};
use super::whole::Scene;
use crate::{Error, Result, inputs};

/// Reads the scene at `path` without reporting progress; see [`load_with_progress`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    load_with_progress(path, options, &|_| {})
}

/// Reads the scene at `path` with everything it includes. A file without a known extension is read as Mitsuba's XML.
/// `progress` is called after every mesh file, from several threads.
///
/// All faults of the scene are collected, so that one error lists them ([`Error::Several`]).
pub fn load_with_progress(path: &Path, options: &LoadOptions, progress: &Watch) -> Result<Scene> {
    build(&mut describe(path, &options.defines)?, options, progress)
}

/// Description of the scene at `path`. `defines` replace the `<default>`s of XML, and choose the moment and the variant of a model.
pub(super) fn describe(path: &Path, defines: &[(String, String)]) -> Result<Description> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("gltf" | "glb") => super::gltf::read(path, defines),
        Some("usd" | "usda" | "usdc" | "usdz") => super::usd::read(path, defines),
        Some("pbrt") => match defines.first() {
            None => super::pbrt::read(path),
            Some((name, _)) => {
                let message = format!("-D {name}: pbrt's scenes have no values that -D replaces; leave it out");
                Err(Error::scene(path, None, message))
            }
        },
        extension => {
            if let Some(refusal) = extension.and_then(foreign::refusal) {
                // A file that is missing is not one of a wrong format.
                inputs::open(path)?;
                return Err(Error::scene(path, None, refusal));
            }
            xml::read(path, defines)
        }
    }
}

impl Scene {
    /// Reads a scene from a dictionary of the type `scene`. Files that it names are relative to the current folder. A shape of the
    /// type `mesh` has the arrays `vertices` and `faces`, and may have `normals`, `uvs` and `colors`, all in rows.
    ///
    /// # Errors
    /// Where an entry asks for something unsupported, or a file cannot be read. Messages name entries such as `scene.box.bsdf`.
    pub fn from_dictionary(dictionary: &Dictionary) -> Result<Self> {
        let scene = build(&mut entries::read(dictionary)?, &LoadOptions::default(), &|_| {})?;
        Ok(Self { name: entries::ROOT.into(), ..scene })
    }
}
