//! Console of a render: shows loading, progress, warnings and the end on standard error, as text or as JSON.

use std::path::Path;
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

use lodestar::film::noise::NoiseReport;
use lodestar::session::{Ending, Event, Progress};
use lodestar::{Result, files};

use super::given::{Given, Subset};
use super::log::Log;
use super::print::{print_message, report};
use super::progress::{Loading, Meter, line, noise_words};
use super::render_args::LogFormat;

/// Shows the events of one render.
pub struct Console(Form);

/// Form in which events are shown. Both are behind a lock because events come from several threads.
enum Form {
    Text { is_quiet: bool, has_names: bool, stage: Mutex<Stage> },
    Json(Mutex<Log>),
}

/// The part of a render that is being shown.
enum Stage {
    Preparing(Loading),
    Rendering(Meter),
    /// The files are being written.
    Ending(Loading),
}

impl Console {
    /// A console of the form that arguments ask for. It has shown nothing yet. `has_names` says whether the picture's files were named.
    pub fn new<S: Subset>(given: &Given<S>, has_names: bool) -> Self {
        let is_quiet = given.has("quiet");
        Self(match given.word("log").unwrap_or(LogFormat::Text) {
            LogFormat::Json => Form::Json(Mutex::new(Log::new(is_quiet))),
            LogFormat::Text => {
                Form::Text { is_quiet, has_names, stage: Mutex::new(Stage::Preparing(Loading::new(is_quiet))) }
            }
        })
    }

    /// Whether the console shows text, and not warnings only.
    pub fn is_talking(&self) -> bool {
        matches!(self.0, Form::Text { is_quiet: false, .. })
    }

    /// Shows an event.
    pub fn show(&self, event: Event<'_>) {
        match &self.0 {
            Form::Json(log) => log.lock().unwrap_or_else(PoisonError::into_inner).write(event),
            Form::Text { is_quiet, has_names, stage } => {
                let mut stage = stage.lock().unwrap_or_else(PoisonError::into_inner);
                stage.show(event, *is_quiet, *has_names);
            }
        }
    }

    /// Shows the address of the page, also if the console is quiet.
    pub fn tell_address(&self, url: &str) {
        match &self.0 {
            Form::Json(log) => log.lock().unwrap_or_else(PoisonError::into_inner).tell_address(url),
            Form::Text { stage, .. } => {
                let stage = stage.lock().unwrap_or_else(PoisonError::into_inner);
                stage.interleave(|| print_message(&format!("watch the render at {url}")));
            }
        }
    }

    /// Writes the last line of a JSON log, which has the error of a failure. Returns whether there is such a log.
    pub fn tell_end(&self, rendered: &Result<ExitCode>) -> bool {
        let Form::Json(log) = &self.0 else { return false };
        log.lock().unwrap_or_else(PoisonError::into_inner).end(rendered.as_ref().err());
        true
    }
}

impl Stage {
    fn show(&mut self, event: Event<'_>, is_quiet: bool, has_names: bool) {
        match (event, &mut *self) {
            (Event::Preparing(preparation), Self::Preparing(loading)) => loading.show(&preparation.to_string()),
            (Event::Ready, _) => *self = Self::Rendering(Meter::new(is_quiet)),
            (Event::Step(progress) | Event::InStep(progress), Self::Rendering(meter)) => {
                meter.update(progress.fraction, line(progress));
            }
            (Event::Rendered, _) => {
                let ending = Loading::new(is_quiet);
                ending.show("reading the picture back from the device");
                *self = Self::Ending(ending);
            }
            (Event::Finishing(work), Self::Ending(ending)) => ending.show(work),
            (Event::Writing(path, share), Self::Ending(ending)) => ending.show_writing(path, share),
            (Event::Warning(message), stage) => stage.interleave(|| report("warning", message)),
            (Event::Validation(message), stage) => stage.interleave(|| report("validation", message)),
            (Event::Note(message), stage) if !is_quiet => stage.interleave(|| print_message(message)),
            // The picture so far is written without a word.
            (Event::Written(path), Self::Ending(ending)) if !is_quiet => {
                ending.interleave(|| print_message(&written(path, has_names)));
            }
            (Event::Ended(ending, progress), stage) if !is_quiet => {
                let sentence = end_sentence(ending, progress);
                sentence.iter().for_each(|text| stage.interleave(|| print_message(text)));
            }
            _ => {}
        }
    }

    /// Calls `print` while the bar is hidden.
    fn interleave(&self, print: impl FnOnce()) {
        match self {
            Self::Preparing(loading) | Self::Ending(loading) => loading.interleave(print),
            Self::Rendering(meter) => meter.interleave(print),
        }
    }
}

/// Line about a file of the picture. A caller who has named no file learns how to.
fn written(path: &Path, has_names: bool) -> String {
    match has_names || !files::is_picture(path) {
        true => format!("wrote {}", path.display()),
        false => format!("wrote {}; -o NAME.png writes a picture for any viewer", path.display()),
    }
}

/// Sentence about an end that the caller has not asked for.
fn end_sentence(ending: Ending, progress: &Progress) -> Option<String> {
    let Progress { samples, length, .. } = *progress;
    let of = length.spp.map_or_else(String::new, |spp| format!(" of {spp}"));
    match (ending, progress.noise) {
        (Ending::Stopped, _) => Some(format!("stopped after {samples}{of} samples per pixel")),
        (Ending::Samples | Ending::Time, Some(noise @ NoiseReport { target, .. })) => {
            Some(format!("--noise {target} was not reached: {}", noise_words(&noise)))
        }
        _ => None,
    }
}
