//! `lodestar merge`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::film;
use lodestar::film::merge::{PartialPicture, merge};
use lodestar::settings::options::form::exr_path;
use lodestar::{Result, files};

use super::print::{print_message, report};

/// Averages pictures of one scene with disjoint samples, every pixel by its sample counts.
///
/// Parts may differ in --sample-offset, --seed, length and device. All else must be alike, and no two parts may have a sample
/// in common. Variances, features and counts are merged too, so the result can be merged again.
#[derive(Debug, clap::Args)]
pub struct MergeArgs {
    /// The pictures, two or more.
    #[arg(value_name = "A.exr", required = true, num_args = 2..)]
    parts: Vec<PathBuf>,
    /// File to write.
    #[arg(short, long, value_name = "C.exr", value_parser = exr_path)]
    output: PathBuf,
}

/// Merges the pictures.
pub fn run(args: &MergeArgs) -> Result<ExitCode> {
    files::check_writable(&args.output)?;
    let read = |path: &PathBuf| {
        let (picture, attributes) = film::read_picture(path)?;
        Ok(PartialPicture { path: path.clone(), picture, attributes })
    };
    let parts: Vec<_> = args.parts.iter().map(read).collect::<Result<_>>()?;
    let (picture, attributes) = merge(&parts)?;
    let is_whole = |part: &&PartialPicture| part.picture.sums.is_empty();
    if let Some(part) = parts.iter().find(is_whole).filter(|_| !parts.iter().all(|part| is_whole(&part))) {
        let message = "it carries no sums, so the last bits depend on how the samples are divided; render it with --sample-offset (0 for the first part)";
        report("warning", &format!("{}: {message}", part.path.display()));
    }
    film::write_picture(&args.output, &picture, &attributes)?;
    print_message(&format!("wrote {}", args.output.display()));
    Ok(ExitCode::SUCCESS)
}
