//! `lodestar compare`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::image::exr;
use lodestar::image::metrics::{self, Metrics};
use lodestar::{Error, Result};

use super::print::{print_json, print_line};

/// Measures the error of an EXR picture against a reference.
#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    /// The picture.
    #[arg(value_name = "A.exr")]
    image: PathBuf,
    /// The reference, of the same size.
    #[arg(value_name = "B.exr")]
    reference: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Prints the error metrics of the picture.
pub fn run(args: &CompareArgs) -> Result<ExitCode> {
    let image = exr::read_rgb(&args.image)?;
    let reference = exr::read_rgb(&args.reference)?;
    let metrics = metrics::compare(&image, &reference).map_err(|error| {
        Error::Settings(format!("{} against {}: {error}", args.image.display(), args.reference.display()))
    })?;
    if args.json {
        print_json(&metrics)?
    } else {
        print_line(&table(&metrics))?
    }
    Ok(ExitCode::SUCCESS)
}

fn table(metrics: &Metrics) -> String {
    let rows = [
        ("mae_ldr", metrics.mae_ldr, "mean absolute difference under the paper's tone curve"),
        ("mae", metrics.mae, "mean absolute difference"),
        ("mse", metrics.mse, "mean squared difference"),
        ("relmse", metrics.relmse, "relative mean squared difference"),
        ("relmse_trim", metrics.relmse_trim, "relative mean squared difference without the worst 0.1 % of the pixels"),
        ("mean_ratio", metrics.mean_ratio, "mean of A over mean of B"),
    ];
    rows.map(|(name, value, what)| format!("{name:<12} {value:>12.6e}  {what}")).join("\n")
}
