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
    let forecast = RefCell::new(Forecast::default());
    let show = |status: &Status| {
        let (word, left) = forecast.borrow_mut().left(status, begin.elapsed().as_secs_f64());
        let text = format!("{}, {word} {} left", status.doing, duration(left));
        meter.borrow_mut().update(status.done / status.total.max(1.0e-6), text);
    };
    let is_whole = plan.run(&context, &Watch { stop: &|| interrupt.is_raised(), show: &show })?;
    meter.borrow_mut().finish();
    if is_whole && !args.quiet {
        print_line(&format!("written to {}", args.out.display()))?;
    }
    Ok(interrupt.exit_code())
}

/// Forecast of the time that is left. Loading and building kernels take time beside rendering; how much is known after the first scene.
#[derive(Debug, Default)]
struct Forecast {
    /// Number of scenes that are finished.
    finished: usize,
    /// Seconds that these scenes took beside rendering.
    beside: f64,
}

impl Forecast {
    /// Seconds that are left, and the word before them.
    fn left(&mut self, status: &Status, elapsed: f64) -> (&'static str, f64) {
        let beside = (elapsed - status.done).max(0.0);
        if status.finished > self.finished {
            *self = Self { finished: status.finished, beside };
        }
        let rendering = (status.total - status.done).max(0.0);
        if self.finished == 0 {
            return ("at least", rendering);
        }
        let of_scene = self.beside / self.finished as f64;
        let of_this = (of_scene - (beside - self.beside)).max(0.0);
        let others = status.scenes.saturating_sub(self.finished + 1) as f64;
        ("about", rendering + of_this + others * of_scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_grows_with_what_is_no_rendering() {
        let status = |done, finished| Status { doing: String::new(), done, total: 100.0, finished, scenes: 5 };
        let mut forecast = Forecast::default();
        assert_eq!(forecast.left(&status(0.0, 0), 3.0), ("at least", 100.0));
        assert_eq!(forecast.left(&status(15.0, 0), 30.0), ("at least", 85.0));
        // The first scene took 12 s beside rendering, so each of the others will.
        assert_eq!(forecast.left(&status(20.0, 1), 32.0), ("about", 128.0));
        assert_eq!(forecast.left(&status(20.0, 1), 37.0), ("about", 123.0), "5 of the 12 s of this scene are over");
        assert_eq!(forecast.left(&status(30.0, 1), 72.0), ("about", 106.0), "this scene takes longer");
        assert_eq!(forecast.left(&status(100.0, 4), 300.0), ("about", 50.0));
        assert_eq!(forecast.left(&status(101.0, 4), 400.0), ("about", 0.0));
    }
}
