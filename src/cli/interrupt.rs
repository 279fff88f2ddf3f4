//! Signals that ask a render to stop.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use lodestar::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// What shells add to a signal's number to make an exit code of it.
const EXIT_CODE_BASE: i32 = 128;

/// Notes SIGINT (Ctrl-C) and SIGTERM. The first stops the render, which still writes its files; the second ends the process
/// at once.
pub struct Interrupt {
    /// Number of the first signal, 0 before.
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Catches the signals from now on.
    pub fn catch() -> Result<Self> {
        let (signal, is_second) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        for number in [SIGINT, SIGTERM] {
            // In this order: a signal finds `is_second` set only if another came before.
            flag::register_conditional_shutdown(number, EXIT_CODE_BASE + number, Arc::clone(&is_second))
                .and_then(|_| flag::register(number, Arc::clone(&is_second)))
                .and_then(|_| flag::register_usize(number, Arc::clone(&signal), number as usize))
                .map_err(|error| Error::Render(format!("signals cannot be caught: {error}")))?;
        }
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
