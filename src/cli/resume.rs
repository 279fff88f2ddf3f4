//! `lodestar resume`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::Result;
use lodestar::session::{CHECKPOINT_EVERY, Options, Start};

use super::render;
use super::render_args::{DeviceArgs, LengthArgs, OutputArgs, seconds};

/// Goes on with a render from its checkpoint, to the same bits as if it had never stopped.
///
/// What is not said here is as it was: the scene, its settings, the length and the files. With --spp or --time it ends after
/// so many samples per pixel in all, or so many seconds from now. The checkpoint is kept up.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct ResumeArgs {
    /// The checkpoint.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Where the scene lies now, if it was moved.
    #[arg(long, value_name = "SCENE.xml", help_heading = "Scene")]
    scene: Option<PathBuf>,
    /// Write the checkpoint every so many seconds, and when the render ends.
    #[arg(long, value_name = "SECONDS", default_value_t = CHECKPOINT_EVERY, value_parser = seconds, help_heading = "Output")]
    checkpoint_every: f64,
    #[command(flatten)]
    files: OutputArgs,
    #[command(flatten)]
    length: LengthArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Goes on with the render.
pub fn run(args: ResumeArgs) -> Result<ExitCode> {
    let is_quiet = args.files.quiet;
    let start = Start::Resume { checkpoint: args.file, moved_scene: args.scene };
    let options = args.device.add_to(args.length.add_to(Options::new()));
    let options = options.files(args.files.into()).checkpoint_every(args.checkpoint_every);
    render::render(start, &options, is_quiet)
}
