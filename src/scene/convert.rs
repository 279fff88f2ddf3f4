//! Conversion of scenes of any format to Mitsuba's XML.

use std::path::Path;

use super::load_options::LoadOptions;
use super::mitsuba::convert::{Target, write_description, write_xml};
use super::mitsuba::description::{Description, ROOT};
use super::mitsuba::dictionary::Dictionary;
use super::read;
use super::whole::Scene;
use crate::{Error, Result};

/// Report of a conversion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Converted {
    /// Number of files beside the scene, in the folder that has its name.
    pub file_count: usize,
    /// Faults of the scene that do not keep it from being rendered.
    pub warnings: Vec<String>,
}

/// Writes the scene at `input` to `output`, a Mitsuba file of version 3.0.0 that renders the same picture. `defines` replace the
/// `<default>`s of their names. Includes are spliced in, names with a `$` are replaced by their values, and parameters are in
/// snake_case. Every file that the scene names is copied to the folder beside `output` that has its name without `.xml`.
/// Meshes and images that lie in no file of their own become files there. A scene without a camera gets the one that was fitted
/// to it. Older files are replaced only if `overwrite` is set.
///
/// # Errors
/// Where the scene cannot be rendered, a file exists, or a file cannot be written.
pub fn convert(input: &Path, defines: &[(String, String)], output: &Path, overwrite: bool) -> Result<Converted> {
    let is_input = |path| input.canonicalize().is_ok_and(|input| input == path);
    if output.canonicalize().is_ok_and(is_input) {
        return Err(Error::Settings(format!("{}: a scene cannot replace itself; name another file", output.display())));
    }
    let options = LoadOptions { defines: defines.to_vec(), ..LoadOptions::default() };
    let scene = read::load(input, &options)?;
    let target = Target { output, overwrite, fitted: &scene };
    let file_count = match read::describer(input) {
        Some(describe) => write_description(describe(input)?, &target)?,
        None => write_xml(input, defines, &target)?,
    };
    Ok(Converted { file_count, warnings: scene.warnings })
}

/// Writes a scene that a dictionary describes, as [`convert`] writes a file. Its meshes become binary PLY files.
///
/// # Errors
/// Where the scene cannot be rendered, a file exists, or a file cannot be written.
pub fn convert_dictionary(scene: &Dictionary, output: &Path, overwrite: bool) -> Result<Converted> {
    let read = Scene::from_dictionary(scene)?;
    let description = Description { path: ROOT.into(), scene: scene.clone(), ..Description::default() };
    let file_count = write_description(description, &Target { output, overwrite, fitted: &read })?;
    Ok(Converted { file_count, warnings: read.warnings })
}
