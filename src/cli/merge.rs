//! `lodestar merge`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lodestar::film::merge::{PartialPicture, merge};
use lodestar::film::{self, Precision};
use lodestar::session::saved_guide::{self, SavedGuide};
use lodestar::settings::options::form::merged_path;
use lodestar::{Result, files};

use super::print::{print_message, report};
use super::progress::Loading;

/// Merges pictures of one scene with disjoint samples, or guides that have learned from disjoint samples.
///
/// Every pixel is averaged by its sample counts. Parts may differ in --sample-offset, --seed, length and device. All else must be alike,
/// and no two parts may have a sample in common. Variances, features and counts are merged too, so the result can be merged again. Guides
/// (files of --guide-out) are averaged by what each has learned, and may differ in camera, too.
#[derive(Debug, clap::Args)]
pub struct MergeArgs {
    /// The pictures or the guides, two or more.
    #[arg(value_name = "A.exr", required = true, num_args = 2..)]
    parts: Vec<PathBuf>,
    /// File to write: .exr merges pictures, .guide merges guides.
    #[arg(short, long, value_name = "C.exr", value_parser = merged_path)]
    output: PathBuf,
}

/// Merges the pictures or the guides.
pub fn run(args: &MergeArgs) -> Result<ExitCode> {
    let MergeArgs { parts, output } = args;
    files::check_writable(output)?;
    if files::has_extension(output, "guide") {
        merge_guides(parts, output)?
    } else {
        merge_pictures(parts, output)?
    }
    print_message(&format!("wrote {}", output.display()));
    Ok(ExitCode::SUCCESS)
}

fn merge_pictures(parts: &[PathBuf], output: &Path) -> Result<()> {
    let working = Loading::new(false);
    let read = |path: &PathBuf| {
        working.show(&format!("reading {}", path.display()));
        let (picture, attributes) = film::read_picture(path)?;
        Ok(PartialPicture { path: path.clone(), picture, attributes })
    };
    let parts: Vec<_> = parts.iter().map(read).collect::<Result<_>>()?;
    working.show("averaging the pictures");
    let (picture, attributes) = merge(&parts)?;
    let is_whole = |part: &&PartialPicture| part.picture.sums.is_empty();
    if let Some(part) = parts.iter().find(is_whole).filter(|_| !parts.iter().all(|part| is_whole(&part))) {
        let message = "it carries no sums, so the last bits depend on how the samples are divided; render it with --sample-offset (0 for the first part)";
        working.interleave(|| report("warning", &format!("{}: {message}", part.path.display())));
    }
    let mut tell = |share| working.show_writing(output, share);
    film::write_picture_with(output, &picture, &attributes, Precision::Float, None, &mut tell)
}

fn merge_guides(parts: &[PathBuf], output: &Path) -> Result<()> {
    let guides = parts.iter().map(|path| SavedGuide::read(path)).collect::<Result<_>>()?;
    saved_guide::merge(guides, parts)?.write(output)
}
