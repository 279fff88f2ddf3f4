//! `lodestar view`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use lodestar::files::{has_extension, is_picture};
use lodestar::image::color;
use lodestar::session::{Event, Options, Watch};
use lodestar::settings::options::LOCAL;
use lodestar::settings::options::form::{self, page_address};
use lodestar::view::{FileView, MovingOptions, MovingView};
use lodestar::{Error, Result};

use super::given::{Given, OfView};
use super::interrupt::Interrupt;
use super::print::{print_message, report};
use super::render_args::with;

/// Interval at which the file is looked at.
const INTERVAL: Duration = Duration::from_millis(200);
/// Samples per pixel of a camera at rest, where `--spp` gives no other number.
const SAMPLES: u32 = 256;

/// Shows a picture, or a scene whose camera moves, in a browser.
///
/// The page of an EXR picture shows every layer, with exposure, tone curves and false colors, and the values of its pixels. When
/// the file changes, the page shows it anew. A .png or .jpg picture has 8 bits per channel, which are made linear.
///
/// The page of a scene renders it. Its camera moves by mouse, touch or keyboard, and what the guide has learned stays. The page gives the
/// camera as XML and renders the picture that is seen into a file. Pictures have 256 samples per pixel where --spp gives no other number.
///
/// Nobody sees anything without the token at the end of the printed address. Ctrl-C ends the program.
#[derive(Debug, clap::Args)]
pub struct ViewArgs {
    /// The picture, or the scene.
    #[arg(value_name = "PICTURE.exr|SCENE")]
    subject: PathBuf,
    /// Address of the page; without a port it has a free one.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = LOCAL, value_parser = page_address)]
    address: String,
    /// Options of the scene's pictures.
    #[command(flatten)]
    given: Given<OfView>,
}

/// Serves the picture or the scene until a signal comes.
pub fn run(args: ViewArgs) -> Result<ExitCode> {
    let interrupt = Interrupt::catch(false)?;
    match is_picture(&args.subject) {
        true => show_picture(&args, &interrupt),
        false => move_through(args, &interrupt),
    }
}

fn show_picture(args: &ViewArgs, interrupt: &Interrupt) -> Result<ExitCode> {
    if let Some(name) = args.given.first() {
        return Err(Error::Settings(format!("--{name} is for scenes, and {} is a picture", args.subject.display())));
    }
    if !has_extension(&args.subject, "exr") {
        let (_, note) = color::read(&args.subject)?;
        note.iter().for_each(|note| report("note", note));
    }
    let mut view = FileView::start(&args.subject, &args.address)?;
    print_message(&format!("look at the picture at {}", view.url()));
    while !interrupt.is_raised() {
        thread::sleep(INTERVAL);
        view.refresh();
    }
    Ok(ExitCode::SUCCESS)
}

fn move_through(args: ViewArgs, interrupt: &Interrupt) -> Result<ExitCode> {
    let ViewArgs { subject, address, given } = args;
    // What cannot be a scene is refused before there is a page.
    std::fs::metadata(&subject).map_err(Error::read(&subject))?;
    let picture = given.values("output", form::output_path).pop();
    if let Some(picture) = picture.as_ref().filter(|picture| picture.extension().is_none_or(|found| found != "exr")) {
        return Err(Error::Settings(format!("{}: the page writes EXR files; give a name in .exr", picture.display())));
    }
    let (load, denoiser) = (given.load(), given.denoiser());
    // Many files of others ask for a single sample.
    let samples = if given.has("spp") { None } else { Some(SAMPLES) };
    let session = with(given.choose_all(Options::new()), samples, Options::samples);
    let view = MovingView::start(&address)?;
    print_message(&format!("look at the scene at {}", view.url()));
    let show = |event: Event<'_>| match event {
        Event::Warning(message) => report("warning", message),
        Event::Note(message) => print_message(message),
        Event::Written(path) => print_message(&format!("written: {}", path.display())),
        _ => {}
    };
    let watch = Watch { stop: &|| interrupt.is_raised(), events: &show };
    view.run(&subject, &MovingOptions { load, session, denoiser, picture }, &watch)?;
    Ok(ExitCode::SUCCESS)
}
