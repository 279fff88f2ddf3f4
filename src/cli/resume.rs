//! `lodestar resume`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::Result;
use lodestar::session::{CHECKPOINT_EVERY, Options, Start};

use super::console::Console;
use super::duration::seconds;
use super::render_args::{DeviceArgs, LengthArgs, OutputArgs};
use super::viewer_args::ViewerArgs;

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
    #[arg(long, default_value_t = CHECKPOINT_EVERY, value_parser = seconds)]
    checkpoint_every: f64,
    #[command(flatten)]
    files: OutputArgs,
    #[command(flatten)]
    viewers: ViewerArgs,
    #[command(flatten)]
    length: LengthArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Options that `args` stand for, without the files of the picture.
pub fn options(args: ResumeArgs) -> Options {
    args.device.add_to(args.length.add_to(Options::new())).checkpoint_every(args.checkpoint_every)
}

/// Goes on with the render.
pub fn run(args: ResumeArgs) -> Result<ExitCode> {
    let console = Console::new(&args.files);
    let viewers = args.viewers.options(args.files.denoiser());
    let start = Start::Resume { checkpoint: args.file, moved_scene: args.scene };
    let options = args.device.add_to(args.length.add_to(Options::new()));
    let options = options.files(args.files.into()).checkpoint_every(args.checkpoint_every);
    super::render::render(start, &options, &console, &viewers)
}
