//! Limits of the page's server. No stranger decides how much memory, how many files or how much time it takes.
//!
//! A *holder* is whoever has shown the token. A *stranger* is everybody else, and every connection before its first request.

use std::time::Duration;

/// Most bytes of a request's line and headers. A browser sends less than 2 KiB, and the cookies of all other servers of this host,
/// because cookies do not know ports.
pub const HEADER_BYTES: usize = 16 << 10;
/// Most headers of a request. A browser sends about twenty.
pub const HEADERS: usize = 64;
/// Time for a request from its first wait to its last header. A connection that is kept between two requests ends after it, too.
pub const REQUEST_TIME: Duration = Duration::from_secs(10);
/// Time after which somebody who takes no data is dropped.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// Most requests of a stranger on one connection. The page has eight files.
pub const STRANGER_REQUESTS: usize = 16;
/// Largest part of an answer that is handed over at a time. An answer counts as sent when its last part is handed over.
pub const PART_BYTES: usize = 64 << 10;

/// Threads that make layers, cells and pixels.
pub const WORKERS: usize = 2;
/// Most memory of answers with layers, cells or pixels at one time, made or being sent, in MiB. A layer of 8 million pixels has 48 MiB.
/// A larger answer than this is made alone.
pub const ANSWERS_MIB: u32 = 576;
/// Most memory of answers with the denoised layer at one time, in MiB. One thread denoises.
pub const DENOISED_ANSWERS_MIB: u32 = 192;
/// Time that a holder waits for others' answers.
pub const QUEUE_TIME: Duration = Duration::from_secs(30);

/// Time that a holder waits for the picture of a camera that was moved. A dispatch under way ends first.
pub const MOVE_TIME: Duration = Duration::from_secs(20);

/// Time that pages have at the end to receive the last state.
pub const FAREWELL: Duration = Duration::from_secs(2);
/// Interval at which the server looks whether they have it.
pub const FAREWELL_INTERVAL: Duration = Duration::from_millis(10);
/// Time without accepting after the system has refused a connection, as it does where the process has too many files.
pub const ACCEPT_PAUSE: Duration = Duration::from_millis(10);
/// Shortest time between two events.
pub const EVENT_INTERVAL: Duration = Duration::from_millis(150);
/// Time after which an event is sent although nothing has changed. It finds pages that have left.
pub const HEARTBEAT: Duration = Duration::from_secs(5);
/// Priority of the server's thread, as of `nice`. A flood of requests then takes little from a render that uses every core.
pub const NICENESS: i32 = 10;

/// Numbers of connections.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Connections of strangers in all. A further one takes the place of one that has been silent for longest.
    pub strangers: usize,
    /// Connections of strangers from one address. Behind a tunnel, all of them have one.
    pub strangers_of_address: usize,
    /// Connections of holders that are kept between two requests.
    pub holders: usize,
    /// Pages that receive events.
    pub listeners: usize,
}

/// Limits where the process may open many files. A wall of a hundred tabs fits in; strangers hold 4 MiB at most.
const MOST: Limits = Limits { strangers: 128, strangers_of_address: 64, holders: 512, listeners: 256 };
/// Share of the process's files that each kind of connection may take, as a divisor. The render needs files, too.
const SHARE_OF_STRANGERS: u64 = 8;
const SHARE_OF_HOLDERS: u64 = 4;

/// Files that this process may open; `None` where there is no limit.
#[cfg(unix)]
fn most_files() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::Nofile).current
}

/// Windows has no limit.
#[cfg(not(unix))]
fn most_files() -> Option<u64> {
    None
}

impl Limits {
    /// Limits of this process, which may have few open files (`ulimit -n`).
    pub fn of_process() -> Self {
        Self::with_files(most_files())
    }

    /// Limits of a process that may open so many files; `None` where there is no limit.
    fn with_files(files: Option<u64>) -> Self {
        let share = |most: usize, divisor: u64| match files {
            Some(files) => most.min(usize::try_from(files / divisor).unwrap_or(most)).max(2),
            None => most,
        };
        let (strangers, holders) = (share(MOST.strangers, SHARE_OF_STRANGERS), share(MOST.holders, SHARE_OF_HOLDERS));
        Self {
            strangers,
            strangers_of_address: MOST.strangers_of_address.min(strangers),
            holders,
            listeners: MOST.listeners.min(holders / 2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_leave_files_to_the_render() {
        assert_eq!(Limits::with_files(None), MOST);
        assert_eq!(Limits::with_files(Some(1 << 20)), MOST);
        for files in [0, 8, 64, 256, 1024] {
            let limits = Limits::with_files(Some(files));
            assert!(limits.strangers_of_address >= 2 && limits.holders >= 2 && limits.listeners >= 1, "{limits:?}");
            assert!(files < 64 || limits.strangers + limits.holders <= files as usize / 2, "{limits:?}");
        }
    }
}
