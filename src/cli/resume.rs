//! `lodestar resume`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::Result;
use lodestar::session::checkpoint::Checkpoint;

use super::render;
use super::render_args::{CHECKPOINT_EVERY, DeviceArgs, LengthArgs, OutputArgs, seconds};
use super::task::{CheckpointFile, JobRecord, Length, Start, Task};

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
    let mut checkpoint: Checkpoint<JobRecord> = Checkpoint::read(&args.file)?;
    let record = &mut checkpoint.job;
    if args.length.spp.is_some() || args.length.time.is_some() {
        let seconds = args.length.time.map(|seconds| record.history.seconds + seconds);
        record.length = Length { spp: args.length.spp, seconds };
    }
    let task = Task {
        scene: args.scene.unwrap_or_else(|| checkpoint.scene.path.clone().into()),
        define: checkpoint.scene.defines.clone(),
        files: args.files,
        device: args.device,
        checkpoint: Some(CheckpointFile::new(args.file.clone(), args.checkpoint_every)),
    };
    render::render(&task, Start::Resumed(&args.file, Box::new(checkpoint)))
}
