//! `lodestar render`: renders a scene, shows progress and writes the files.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use lodestar::gpu::Context;
use lodestar::renderer::learned_guide::LearnedGuide;
use lodestar::scene::format_names;
use lodestar::session::{Event, Options, SceneInput, Session, Start, Watch};
use lodestar::view::{ViewOptions, Viewers};
use lodestar::{Error, Result};

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
    #[arg(value_name = "SCENE", help = format!("The scene: {}", format_names()))]
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
    given.choose_all(Options::new())
}

/// Refuses options of one picture, `of_one`, and several processes, where the option `asked` makes several pictures.
pub fn check_several(given: &Given<OfRender>, asked: &str, of_one: &[&str], remedy: &str) -> Result<()> {
    if let Some(option) = of_one.iter().find(|option| given.has(option)) {
        let message = format!("{asked} makes several pictures, and --{option} is for one: leave it out, or {remedy}");
        return Err(Error::Settings(message));
    }
    if ranks::are_several() {
        let message =
            format!("{asked} renders one picture after another, which several processes cannot do together; {remedy}");
        return Err(Error::Settings(message));
    }
    Ok(())
}

/// What one render leaves to the next one.
#[derive(Default)]
pub struct Kept {
    /// What the guide has learned. The next render begins with it.
    pub guide: Option<LearnedGuide>,
    /// The device, which stays open.
    pub context: Option<Arc<Context>>,
}

/// Renders from the beginning or from a checkpoint, and shows the progress and the end.
pub fn render(start: Start<'_>, options: &Options, console: &Console, viewers: &ViewOptions) -> Result<ExitCode> {
    let exchange = ranks::exchange()?;
    let options = &with(options.clone(), exchange.clone(), Options::exchange);
    if exchange.is_some_and(|exchange| exchange.rank() > 0) {
        return serve(start, options);
    }
    let interrupt = Interrupt::catch(console.is_talking());
    ended(interrupt.and_then(|interrupt| render_watched(start, options, console, viewers, &interrupt, None)), console)
}

/// Renders one of several pictures as [`render`] does, with the signals of all of them and what the picture before has left in `kept`.
pub fn render_one(
    start: Start<'_>,
    options: &Options,
    console: &Console,
    interrupt: &Interrupt,
    kept: Option<&mut Kept>,
) -> Result<ExitCode> {
    ended(render_watched(start, options, console, &ViewOptions::default(), interrupt, kept), console)
}

/// Shows the end of a render. A log in JSON has its error.
fn ended(rendered: Result<ExitCode>, console: &Console) -> Result<ExitCode> {
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

fn render_watched(
    start: Start<'_>,
    options: &Options,
    console: &Console,
    viewers: &ViewOptions,
    interrupt: &Interrupt,
    kept: Option<&mut Kept>,
) -> Result<ExitCode> {
    let viewers = Viewers::start(viewers)?;
    viewers.url().iter().for_each(|url| console.tell_address(url));
    let show = |event: Event<'_>| {
        console.show(event);
        viewers.show(event);
    };
    let watch = Watch { stop: &|| interrupt.is_raised() || viewers.is_stopped(), events: &show };
    let mut session = Session::start(start, options, &watch)?;
    if let Some(guide) = kept.as_ref().and_then(|kept| kept.guide.as_ref()) {
        session.begin_with_guide(guide)?;
    }
    let finished = session.run_watched(&watch, |session| viewers.after_step(session, &watch));
    viewers.finish(&session, &watch);
    let printed = session.profile().map_or(Ok(()), |profile| print_line(profile.table().trim_end()));
    finished.and(printed)?;
    if let Some(kept) = kept {
        *kept = Kept { guide: session.learned_guide().ok(), context: Some(Arc::clone(session.context())) };
    }
    Ok(interrupt.exit_code())
}
