//! `lodestar render`: renders a scene, shows progress and writes the files.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::Result;
use lodestar::session::{Event, Options, SceneInput, Session, Start, Watch};
use lodestar::view::{ViewOptions, Viewers};

use super::console::Console;
use super::given::{Given, OfRender};
use super::interrupt::Interrupt;
use super::print::print_line;
use super::ranks;
use super::render_args::with;

/// Renders a scene.
///
/// The render ends at the first of --spp, --time and --noise that is reached. Ctrl-C ends it too. Each way, the picture so far is
/// written.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct RenderArgs {
    /// The scene: Mitsuba's XML of any version, glTF 2.0 (.gltf, .glb), or pbrt-v4 (.pbrt)
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    #[command(flatten)]
    pub given: Given<OfRender>,
}

/// Renders the scene that `args` name.
pub fn run(args: RenderArgs) -> Result<ExitCode> {
    let RenderArgs { scene, given } = args;
    let (console, viewers, files) = (Console::new(&given, given.has("output")), given.viewers(), given.files());
    let start = Start::Anew(SceneInput::File { path: scene, options: given.load() });
    render(start, &options(given).files(files), &console, &viewers)
}

/// Options that arguments stand for, without the scene and the files of the picture.
pub fn options(given: Given<OfRender>) -> Options {
    let options = given.add_to(Options::new());
    given.choose(options)
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
    let _interrupt = Interrupt::catch(false)?;
    let served = Session::serve(start, options, &Watch::silent());
    Ok(if served.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn render_watched(start: Start<'_>, options: &Options, console: &Console, viewers: &ViewOptions) -> Result<ExitCode> {
    let interrupt = Interrupt::catch(console.is_talking())?;
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
