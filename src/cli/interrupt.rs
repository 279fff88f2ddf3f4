//! Signals that ask a render to stop.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use lodestar::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Number that shells add to a signal's number to form an exit code.
const EXIT_CODE_BASE: i32 = 128;
/// Time after the first signal in which a second one is ignored. Some programs, such as `timeout`, send each signal twice.
const ECHO: Duration = Duration::from_millis(500);
/// Interval at which a thread looks for the first signal, to measure that time.
const WATCH: Duration = Duration::from_millis(100);

/// Catches SIGINT (Ctrl-C) and SIGTERM. The first signal stops the render, which still writes its files. A later signal ends the
/// process at once.
pub struct Interrupt {
    /// Number of the last signal; 0 before the first one.
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

    /// Exit code: success, or 128 plus the signal's number.
    pub fn exit_code(&self) -> ExitCode {
        match self.signal.load(Ordering::Relaxed) {
            0 => ExitCode::SUCCESS,
            number => ExitCode::from((EXIT_CODE_BASE as usize + number) as u8),
        }
    }
}
