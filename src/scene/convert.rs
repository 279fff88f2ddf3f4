//! Conversion of scenes of any format to Mitsuba's XML.

use std::path::Path;

use super::description::Description;
use super::load_options::LoadOptions;
use super::mitsuba::convert::{Target, write};
use super::mitsuba::dictionary::Dictionary;
use super::mitsuba::entries;
use super::plugins::load::build;
use super::read;
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
    write_description(read::describe(input, defines)?, output, overwrite)
}

/// Writes a scene that a dictionary describes, as [`convert`] writes a file. Its meshes become binary PLY files.
///
/// # Errors
/// Where the scene cannot be rendered, a file exists, or a file cannot be written.
pub fn convert_dictionary(scene: &Dictionary, output: &Path, overwrite: bool) -> Result<Converted> {
    write_description(entries::read(scene)?, output, overwrite)
}

fn write_description(mut description: Description, output: &Path, overwrite: bool) -> Result<Converted> {
    let scene = build(&mut description, &LoadOptions::default(), &|_| {}, None)?;
    let file_count = write(&description, &Target { output, overwrite, fitted: &scene })?;
    Ok(Converted { file_count, warnings: scene.warnings })
}
