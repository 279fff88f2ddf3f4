//! `lodestar reproduce`.

use std::cell::RefCell;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use lodestar::Result;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::reproduce::{Plan, Status, Target, Watch};
use lodestar::settings::options::form::positive;
use lodestar::settings::options::seconds;

use super::interrupt::Interrupt;
use super::print::print_line;
use super::progress::{Meter, duration};
use super::render_args::device_name;

/// Measures the figures of the paper's tables on this device.
///
/// Every method renders every scene for the same time, in turn. With 40 seconds per picture, as in the paper, the whole set takes
/// hours. Measurements that are already in the output folder are not repeated: after Ctrl-C, run the same command again.
#[derive(Debug, clap::Args)]
pub struct ReproduceArgs {
    /// Table or figure to reproduce.
    #[arg(value_enum)]
    target: Target,
    /// Folder with the paper's scenes: NAME/scene.xml.
    #[arg(long, value_name = "DIR")]
    scenes: PathBuf,
    /// Folder with the references of these scenes: NAME.mean.exr.
    #[arg(long, value_name = "DIR")]
    references: PathBuf,
    /// Seconds of rendering for each picture.
    #[arg(long, value_name = "SECONDS", default_value_t = 40.0, value_parser = seconds)]
    seconds: f64,
    /// Size of the pictures relative to the references [default: so that a plain path tracer reaches 1000 samples per pixel].
    #[arg(long, value_name = "F", value_parser = positive)]
    scale: Option<f32>,
    /// Render this scene only; may be given several times.
    #[arg(long, value_name = "SCENE")]
    only: Vec<String>,
    /// Folder for tables, pictures and measurements.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[arg(long, env = "LODESTAR_DEVICE")]
    device: Option<String>,
    #[arg(short, long)]
    quiet: bool,
}

/// Measures the table or figure that `args` ask for.
pub fn run(args: &ReproduceArgs) -> Result<ExitCode> {
    let interrupt = Interrupt::catch(false)?;
    let plan = Plan {
        target: args.target,
        scenes: args.scenes.clone(),
        references: args.references.clone(),
        seconds: args.seconds,
        scale: args.scale,
        only: args.only.clone(),
        out: args.out.clone(),
    };
    let device = device_name(args.device.clone());
    let context = Context::new(&ContextOptions { device, validate: false })?;
    let (begin, meter) = (Instant::now(), RefCell::new(Meter::new(args.quiet)));
    let show = |status: &Status| {
        let left = seconds_left(status, args.seconds, begin.elapsed().as_secs_f64());
        let text = format!("{}, about {} left", status.doing, duration(left));
        meter.borrow_mut().update(status.done / status.total.max(1.0e-6), text);
    };
    let is_whole = plan.run(&context, &Watch { stop: &|| interrupt.is_raised(), show: &show })?;
    meter.borrow_mut().finish();
    if is_whole && !args.quiet {
        print_line(&format!("written to {}", args.out.display()))?;
    }
    Ok(interrupt.exit_code())
}

/// Seconds that are left: those of rendering, and for each picture as many besides as each picture so far took for all else.
fn seconds_left(status: &Status, seconds_of_picture: f64, elapsed: f64) -> f64 {
    let begun = (status.done / seconds_of_picture).floor() + 1.0;
    let beside = (elapsed - status.done).max(0.0) / begun;
    let left = (status.total - status.done).max(0.0);
    left * (1.0 + beside / seconds_of_picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_grows_with_what_is_no_rendering() {
        let status = |done| Status { doing: String::new(), done, total: 100.0 };
        assert_eq!(seconds_left(&status(0.0), 10.0, 0.0), 100.0);
        // Three pictures were begun, and 3 s went to each of them besides.
        assert_eq!(seconds_left(&status(20.0), 10.0, 29.0), 104.0);
        assert_eq!(seconds_left(&status(101.0), 10.0, 300.0), 0.0);
        // The first picture has just begun, after 3 s of loading.
        assert!(seconds_left(&status(0.02), 1.0, 3.0) < 400.0);
    }
}
