//! `lodestar resume`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::Result;
use lodestar::session::{Options, Start};

use super::console::Console;
use super::given::{Given, OfResume};

/// Continues a render from its checkpoint, to the same bits as without the interruption.
///
/// Scene, settings, length and files stay as they were, unless an option changes them. --spp counts all samples per pixel,
/// --time counts from now. The checkpoint is still written.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct ResumeArgs {
    /// The checkpoint.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Path of the scene, if it was moved.
    #[arg(long, value_name = "SCENE", help_heading = "Scene")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    given: Given<OfResume>,
}

/// Options that `args` stand for, without the files of the picture.
pub fn options(args: &ResumeArgs) -> Options {
    args.given.add_to(Options::new())
}

/// Goes on with the render.
pub fn run(args: ResumeArgs) -> Result<ExitCode> {
    let (console, viewers) = (Console::new(&args.given, true), args.given.viewers());
    let options = options(&args).files(args.given.files());
    let start = Start::Resume { checkpoint: args.file, moved_scene: args.scene };
    super::render::render(start, &options, &console, &viewers)
}
