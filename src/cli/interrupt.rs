//! Signals that ask a render to stop.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use lodestar::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// What shells add to a signal's number to make an exit code of it.
const EXIT_CODE_BASE: i32 = 128;
/// How soon after the first a signal still means the same: `timeout`, for one, sends each twice.
const ECHO: Duration = Duration::from_millis(500);
/// How often the first signal is looked for, to measure that time.
const WATCH: Duration = Duration::from_millis(100);

/// Notes SIGINT (Ctrl-C) and SIGTERM. The first stops the render, which still writes its files; a later one ends the process
/// at once.
pub struct Interrupt {
    /// Number of the last signal, 0 before.
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Catches the signals from now on.
    pub fn catch() -> Result<Self> {
        let failed = |error| Error::Render(format!("signals cannot be caught: {error}"));
        let (signal, is_final) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        for number in [SIGINT, SIGTERM] {
            flag::register_conditional_shutdown(number, EXIT_CODE_BASE + number, Arc::clone(&is_final))
                .and_then(|_| flag::register_usize(number, Arc::clone(&signal), number as usize))
                .map_err(failed)?;
        }
        let watched = Arc::clone(&signal);
        let watch = move || {
            while watched.load(Ordering::Relaxed) == 0 {
                thread::sleep(WATCH);
            }
            thread::sleep(ECHO);
            is_final.store(true, Ordering::Relaxed);
        };
        thread::Builder::new().name("interrupt".into()).spawn(watch).map_err(failed)?;
        Ok(Self { signal })
    }

    /// Whether a signal has come.
    pub fn is_raised(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }

    /// Success, or 128 and the signal's number, as a shell expects it.
    pub fn exit_code(&self) -> ExitCode {
        match self.signal.load(Ordering::Relaxed) {
            0 => ExitCode::SUCCESS,
            number => ExitCode::from((EXIT_CODE_BASE as usize + number) as u8),
        }
    }
}
