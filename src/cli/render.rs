//! `lodestar render`: renders a scene, shows progress and writes the files.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::Result;
use lodestar::session::{Event, Options, SceneInput, Session, Start, Watch};
use lodestar::view::{ViewOptions, Viewers};

use super::console::Console;
use super::interrupt::Interrupt;
use super::print::print_line;
use super::ranks;
use super::render_args::{RenderArgs, with};

/// Renders the scene that `args` name.
pub fn run(args: RenderArgs) -> Result<ExitCode> {
    let console = Console::new(&args.files);
    let viewers = args.viewers.options(args.files.denoiser());
    let start = Start::Anew(SceneInput::File { path: args.scene, options: args.load.options() });
    let options = args.device.add_to(args.length.add_to(args.choices.options()));
    let options = with(options, args.guide_from, Options::guide_from);
    let options = with_checkpoint(options, args.checkpoint, args.checkpoint_every).files(args.files.into());
    render(start, &options, &console, &viewers)
}

/// Options that `args` stand for, without the scene and the files of the picture.
pub fn options(args: RenderArgs) -> Options {
    let options = args.device.add_to(args.length.add_to(args.choices.options()));
    let options = with(options, args.guide_from, Options::guide_from);
    with_checkpoint(options, args.checkpoint, args.checkpoint_every)
}

fn with_checkpoint(options: Options, checkpoint: Option<PathBuf>, every: f64) -> Options {
    with(options, checkpoint, Options::checkpoint).checkpoint_every(every)
}

/// Renders from the beginning or from a checkpoint, and shows the progress and the end.
pub fn render(start: Start<'_>, options: &Options, console: &Console, viewers: &ViewOptions) -> Result<ExitCode> {
    let exchange = ranks::exchange()?;
    let options = &with(options.clone(), exchange.clone(), Options::exchange);
    if exchange.is_some_and(|exchange| exchange.rank() > 0) {
        return serve(start, options);
    }
    let rendered = render_watched(start, options, console, viewers);
    let is_told = console.tell_end(&rendered);
    if is_told && rendered.is_err() { Ok(ExitCode::FAILURE) } else { rendered }
}

/// Renders on another rank than the first one, which shows the progress and all errors.
fn serve(start: Start<'_>, options: &Options) -> Result<ExitCode> {
    // The first rank decides what a signal does.
    let _interrupt = Interrupt::catch()?;
    let served = Session::serve(start, options, &Watch::silent());
    Ok(if served.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn render_watched(start: Start<'_>, options: &Options, console: &Console, viewers: &ViewOptions) -> Result<ExitCode> {
    let interrupt = Interrupt::catch()?;
    let viewers = Viewers::start(viewers)?;
    viewers.url().iter().for_each(|url| console.tell_address(url));
    let show = |event: Event<'_>| {
        console.show(event);
        viewers.show(event);
    };
    let watch = Watch { stop: &|| interrupt.is_raised() || viewers.is_stopped(), events: &show };
    let mut session = Session::start(start, options, &watch)?;
    let finished = session.run_watched(&watch, |session| viewers.after_step(session, &watch));
    viewers.finish(&session, &watch);
    let printed = session.profile().map_or(Ok(()), |profile| print_line(profile.table().trim_end()));
    finished.and(printed)?;
    Ok(interrupt.exit_code())
}
