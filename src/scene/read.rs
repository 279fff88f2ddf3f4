//! Readers of scenes: one for each format. The extension of the file tells the format.

use std::path::Path;

use super::description::Description;
use super::foreign;
use super::formats::FORMATS;
use super::gltf;
use super::load_options::LoadOptions;
use super::mitsuba::dictionary::Dictionary;
use super::mitsuba::{entries, xml};
use super::pbrt;
use super::plugins::kept_meshes::KeptMeshes;
use super::plugins::load::{Watch, build};
use super::usd;
use super::whole::Scene;
use crate::{Error, Result, inputs};

/// Reader of a file. What it does with definitions is the format's.
type Reader = fn(&Path, &[(String, String)]) -> Result<Description>;

/// Readers of the [`FORMATS`], in their order.
const READERS: [Reader; FORMATS.len()] = [xml::read, gltf::read, usd::read, pbrt::read];

/// Reads the scene at `path` without reporting progress; see [`load_with_progress`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    load_with_progress(path, options, &|_| {})
}

/// Reads the scene at `path` with everything it includes. A file without a known extension is read as Mitsuba's XML.
/// `progress` is called after every mesh file, from several threads.
///
/// All faults of the scene are collected, so that one error lists them ([`Error::Several`]).
pub fn load_with_progress(path: &Path, options: &LoadOptions, progress: &Watch) -> Result<Scene> {
    build(&mut describe(path, &options.defines)?, options, progress, None)
}

/// Reads the scene at `path` like [`load_with_progress`]. Meshes whose files have not changed are taken from those that were `kept`.
pub(crate) fn load_keeping(path: &Path, options: &LoadOptions, progress: &Watch, kept: &KeptMeshes) -> Result<Scene> {
    build(&mut describe(path, &options.defines)?, options, progress, Some(kept))
}

/// Description of the scene at `path`. `defines` replace the `<default>`s of XML, and choose the moment and the variant of a model.
pub(super) fn describe(path: &Path, defines: &[(String, String)]) -> Result<Description> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let extension = extension.to_str().unwrap_or_default();
    if let Some(format) = FORMATS.iter().position(|(_, extensions)| extensions.contains(&extension)) {
        return READERS[format](path, defines);
    }
    if let Some(refusal) = foreign::refusal(extension) {
        // A file that is missing is not one of a wrong format.
        inputs::open(path)?;
        return Err(Error::scene(path, None, refusal));
    }
    READERS[0](path, defines)
}

impl Scene {
    /// Reads a scene from a dictionary of the type `scene`. Files that it names are relative to the current folder. A shape of the
    /// type `mesh` has the arrays `vertices` and `faces`, and may have `normals`, `uvs` and `colors`, all in rows.
    ///
    /// # Errors
    /// Where an entry asks for something unsupported, or a file cannot be read. Messages name entries such as `scene.box.bsdf`.
    pub fn from_dictionary(dictionary: &Dictionary) -> Result<Self> {
        let scene = build(&mut entries::read(dictionary)?, &LoadOptions::default(), &|_| {}, None)?;
        Ok(Self { name: entries::ROOT.into(), ..scene })
    }
}
