//! `lodestar denoise`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::denoise::pictures::DenoisedFile;
use lodestar::denoise::{DenoiseOptions, Denoiser, DeviceKind};
use lodestar::image::ToneCurve;
use lodestar::settings::options::form::{finite, output_path};
use lodestar::{Result, files};

use super::print::{print_message, report};
use super::progress::Loading;

/// Denoises an EXR picture by Intel's Open Image Denoise 2.x.
///
/// An .exr file gets all channels of the picture, unchanged, and the layer denoised. Other files show the denoised layer. The
/// layers albedo and normal guide the denoiser where the picture has them. A denoised picture is biased. The library is not part
/// of Lodestar: `./setup.sh --oidn` unpacks the official build.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct DenoiseArgs {
    /// The picture.
    #[arg(value_name = "IN.exr")]
    picture: PathBuf,
    /// File to write: .exr, .png, .jpg, .tif or .hdr; may be given several times.
    #[arg(short, long, value_name = "FILE", required = true, value_parser = output_path)]
    output: Vec<PathBuf>,
    #[arg(long, value_enum)]
    tone: Option<ToneCurve>,
    #[arg(long, value_parser = finite)]
    exposure: Option<f32>,
    #[arg(long)]
    oidn: Option<PathBuf>,
    #[arg(long, value_enum, default_value_t = DeviceKind::Cpu)]
    oidn_device: DeviceKind,
    /// Print nothing but warnings.
    #[arg(short, long)]
    quiet: bool,
}

/// Denoises the picture.
pub fn run(args: DenoiseArgs) -> Result<ExitCode> {
    args.output.iter().try_for_each(|path| files::check_writable(path))?;
    let denoiser = Denoiser::open(&DenoiseOptions { folder: args.oidn, device: args.oidn_device })?;
    let working = Loading::new(args.quiet);
    working.show(&format!("denoising {}", args.picture.display()));
    let file = DenoisedFile::new(&denoiser, &args.picture)?;
    working.interleave(|| file.notes.iter().for_each(|note| report("warning", note)));
    let (tone, exposure) = (args.tone.unwrap_or_default(), args.exposure.unwrap_or_default());
    let write = |path: &PathBuf| file.write(path, tone, exposure, &mut |share| working.show_writing(path, share));
    args.output.iter().try_for_each(write)?;
    drop(working);
    if !args.quiet {
        let denoised = file.denoised();
        print_message(&format!("denoised by {} on {}, from {}", denoised.by, denoised.on, denoised.from));
    }
    Ok(ExitCode::SUCCESS)
}
