//! Signals that ask a render to stop.

#[cfg(unix)]
use std::fs;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use lodestar::{Error, Result};
#[cfg(unix)]
use signal_hook::consts::SIGHUP;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::print::print_message;

/// Number that shells add to a signal's number to form an exit code.
const EXIT_CODE_BASE: i32 = 128;
/// Time after the first signal in which a second one is ignored. Some programs, such as `timeout`, send each signal twice.
const ECHO: Duration = Duration::from_millis(500);
/// Interval at which a thread looks for the first signal, to measure that time.
const WATCH: Duration = Duration::from_millis(100);

/// Catches SIGINT (Ctrl-C), SIGTERM and SIGHUP (a terminal or a connection that was closed). The first signal stops the render, which
/// still writes its files. A later SIGINT or SIGTERM ends the process at once. A connection that ends may send SIGHUP twice, so that one
/// never does.
pub struct Interrupt {
    /// Number of the last signal; 0 before the first one.
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Catches the signals from now on. Where the program still runs half a second after the first one, it says so if `is_told`.
    pub fn catch(is_told: bool) -> Result<Self> {
        let failed = |error| Error::Render(format!("signals cannot be caught: {error}"));
        let (signal, is_final) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        for number in [SIGINT, SIGTERM] {
            flag::register_conditional_shutdown(number, EXIT_CODE_BASE + number, Arc::clone(&is_final))
                .map_err(failed)?;
        }
        for number in [SIGINT, SIGTERM].into_iter().chain(hangup()) {
            flag::register_usize(number, Arc::clone(&signal), number as usize).map_err(failed)?;
        }
        let watched = Arc::clone(&signal);
        let watch = move || {
            while watched.load(Ordering::Relaxed) == 0 {
                thread::sleep(WATCH);
            }
            thread::sleep(ECHO);
            if is_told {
                print_message("stopping at the next chance; press Ctrl-C again to end at once, without a picture");
            }
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

/// SIGHUP, if it may be caught.
#[cfg(unix)]
fn hangup() -> Option<i32> {
    catches_hangups(&fs::read_to_string("/proc/self/status").unwrap_or_default()).then_some(SIGHUP)
}

/// Windows has no SIGHUP.
#[cfg(not(unix))]
fn hangup() -> Option<i32> {
    None
}

/// Whether SIGHUP may be caught, from the text of `/proc/self/status`. `nohup` starts a program with SIGHUP ignored, and the program
/// must leave it so. Where the system does not tell, SIGHUP stays as it is.
#[cfg(unix)]
fn catches_hangups(status: &str) -> bool {
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| mask >> (SIGHUP - 1) & 1 == 0)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    #[test]
    fn hangups_that_are_ignored_are_not_caught() {
        for (status, caught) in [
            ("Name:\tlodestar\nSigIgn:\t0000000000000000\nSigCgt:\t0000000000000001\n", true),
            ("SigIgn:\t0000000000001000\n", true),
            ("SigIgn:\t0000000000001001\n", false),
            ("SigIgn:\tunknown\n", false),
            ("", false),
        ] {
            assert_eq!(catches_hangups(status), caught, "{status}");
        }
    }
}
