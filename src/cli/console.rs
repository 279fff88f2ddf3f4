//! Console of a render: shows loading, progress and warnings.

use std::sync::{Mutex, PoisonError};

use lodestar::session::Event;

use super::print::report;
use super::progress::{Loading, Meter, line};

/// Shows the events of one render on standard error.
pub struct Console {
    quiet: bool,
    /// Stage of the render, behind a lock because events come from several threads.
    stage: Mutex<Stage>,
}

/// The part of a render that is being shown.
enum Stage {
    Preparing(Loading),
    Rendering(Meter),
    Done,
}

impl Console {
    /// A console that shows nothing yet.
    pub fn new(quiet: bool) -> Self {
        Self { quiet, stage: Mutex::new(Stage::Preparing(Loading::new(quiet))) }
    }

    /// Shows an event.
    pub fn show(&self, event: Event<'_>) {
        let mut stage = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        match (event, &mut *stage) {
            (Event::Preparing(preparation), Stage::Preparing(loading)) => loading.show(&preparation.to_string()),
            (Event::Ready, _) => *stage = Stage::Rendering(Meter::new(self.quiet)),
            (Event::Step(progress), Stage::Rendering(meter)) => meter.update(progress.fraction, line(progress)),
            (Event::Rendered, _) => *stage = Stage::Done,
            (Event::Warning(message), stage) => stage.interleave("warning", message),
            (Event::Validation(message), stage) => stage.interleave("validation", message),
            (Event::Preparing(_) | Event::Step(_), _) => {}
        }
    }
}

impl Stage {
    /// Prints a line while the bar is hidden.
    fn interleave(&self, kind: &str, message: &str) {
        let print = || report(kind, message);
        match self {
            Self::Preparing(loading) => loading.interleave(print),
            Self::Rendering(meter) => meter.interleave(print),
            Self::Done => print(),
        }
    }
}
