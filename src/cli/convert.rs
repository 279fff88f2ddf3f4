//! `lodestar convert`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::Result;
use lodestar::scene::{Converted, convert, scene_file};
use lodestar::settings::options::form::define;

use super::print::{print_message, report};

/// Writes a scene as a Mitsuba file of version 3.0.0 that renders the same picture.
///
/// The files that the scene names are copied to a folder beside the new file. The folder has the new file's name without
/// .xml. Includes are spliced in, and defaults take the place of their names.
#[derive(Debug, clap::Args)]
pub struct ConvertArgs {
    /// The scene, or a folder with a scene.xml.
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// File to write.
    #[arg(value_name = "OUT.xml")]
    output: PathBuf,
    /// Value that replaces the scene's default of that name.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    define: Vec<(String, String)>,
    /// Replace files that exist already.
    #[arg(long)]
    overwrite: bool,
}

/// Reads the scene, writes it, and reports its warnings.
pub fn run(args: &ConvertArgs) -> Result<ExitCode> {
    let converted = convert(&scene_file(&args.input)?, &args.define, &args.output, args.overwrite)?;
    let Converted { file_count, warnings } = converted;
    warnings.iter().for_each(|warning| report("warning", warning));
    let files = match file_count {
        0 => String::new(),
        1 => " and 1 file beside it".to_owned(),
        count => format!(" and {count} files beside it"),
    };
    print_message(&format!("wrote {}{files}", args.output.display()));
    Ok(ExitCode::SUCCESS)
}
