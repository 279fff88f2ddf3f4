//! Sending shots to a display server. A server that is missing, slow or dead never stops the render.

use std::io::{self, Write};
use std::mem::replace;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::view::shot::Shot;
use crate::view::tev::{Rows, create_image, update_image};
use crate::{Error, Result};

/// Time after which a server that does not answer or takes no data is given up.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time that the last shot has at the end, also where a server takes it byte by byte.
const FAREWELL: Duration = Duration::from_secs(10);
/// Time between two attempts to reach a server, and between two shots.
const INTERVAL: Duration = Duration::from_secs(1);
/// Most addresses of one name that are tried.
const MOST_ADDRESSES: usize = 4;
/// Approximate number of values in one packet. A server that hangs holds one packet and two shots in memory.
const PACKET_VALUES: usize = 1 << 18;
/// Name of the image.
const NAME: &str = "lodestar";

/// Sender of shots to one server.
pub(super) struct Display {
    /// Shots for the thread; `None` after the last one.
    shots: Mutex<Option<SyncSender<Arc<Shot>>>>,
    state: Arc<Sending>,
    thread: JoinHandle<()>,
}

/// State of the thread that sends.
struct Sending {
    is_busy: AtomicBool,
    /// Time before which nothing is sent.
    next: Mutex<Instant>,
    warning: Mutex<Warning>,
}

/// The first failure, which is told once.
enum Warning {
    None,
    Untold(String),
    Told,
}

impl Display {
    /// Sends shots to the server at `address` from a thread of its own.
    pub fn start(address: &str) -> Result<Self> {
        let (shots, received) = sync_channel(1);
        let (is_busy, next) = (AtomicBool::new(false), Mutex::new(Instant::now()));
        let state = Arc::new(Sending { is_busy, next, warning: Mutex::new(Warning::None) });
        let (sending, address) = (Arc::clone(&state), address.to_owned());
        let send = move || send_all(&address, &received, &sending);
        let thread = thread::Builder::new().name("display server".into()).spawn(send);
        let thread = thread.map_err(|error| Error::Render(format!("no thread for the display server: {error}")))?;
        Ok(Self { shots: Mutex::new(Some(shots)), state, thread })
    }

    /// Whether the sender would take another shot.
    pub fn is_ready(&self) -> bool {
        let next = *self.state.next.lock().unwrap_or_else(PoisonError::into_inner);
        !self.state.is_busy.load(Ordering::Relaxed) && Instant::now() >= next
    }

    /// Sends a shot, unless the sender is busy.
    pub fn send(&self, shot: Arc<Shot>) {
        if let Some(shots) = &*self.shots.lock().unwrap_or_else(PoisonError::into_inner) {
            let _ = shots.try_send(shot);
        }
    }

    /// Sentence about the first failure, if there is one that nobody has been told.
    pub fn warning(&self) -> Option<String> {
        let mut warning = self.state.warning.lock().unwrap_or_else(PoisonError::into_inner);
        if !matches!(*warning, Warning::Untold(_)) {
            return None;
        }
        match replace(&mut *warning, Warning::Told) {
            Warning::Untold(sentence) => Some(sentence),
            Warning::None | Warning::Told => None,
        }
    }

    /// Waits until the last shot is sent, at most for a few seconds.
    pub fn finish(&self) {
        drop(self.shots.lock().unwrap_or_else(PoisonError::into_inner).take());
        let end = Instant::now() + FAREWELL;
        while !self.thread.is_finished() && Instant::now() < end {
            thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Sending {
    fn warn(&self, address: &str, what: &str, error: &io::Error) {
        let mut warning = self.warning.lock().unwrap_or_else(PoisonError::into_inner);
        if matches!(*warning, Warning::None) {
            let sentence = format!(
                "the display server at {address} {what}: {error}; the render goes on and tries again with each picture"
            );
            *warning = Warning::Untold(sentence);
        }
    }
}

/// Sends every shot that comes, and connects again after a failure.
fn send_all(address: &str, shots: &Receiver<Arc<Shot>>, sending: &Sending) {
    let mut connection = None;
    for shot in shots {
        sending.is_busy.store(true, Ordering::Relaxed);
        if connection.is_none() {
            match connect(address, &shot) {
                Ok(stream) => connection = Some(stream),
                Err(error) => sending.warn(address, "cannot be reached", &error),
            }
        }
        if let Some(stream) = &mut connection
            && let Err(error) = send(stream, &shot)
        {
            sending.warn(address, "takes no pictures", &error);
            connection = None;
        }
        *sending.next.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now() + INTERVAL;
        sending.is_busy.store(false, Ordering::Relaxed);
    }
}

/// Reaches the server and makes the image there.
fn connect(address: &str, shot: &Shot) -> io::Result<TcpStream> {
    let mut failure = io::Error::from(io::ErrorKind::NotFound);
    let mut reached = None;
    for address in address.to_socket_addrs()?.take(MOST_ADDRESSES) {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(stream) => {
                reached = Some(stream);
                break;
            }
            Err(error) => failure = error,
        }
    }
    let mut stream = reached.ok_or(failure)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let [width, height] = shot.size();
    let channels: Vec<String> = shot.layers().iter().flat_map(|layer| channels(shot, layer)).collect();
    stream.write_all(&create_image(NAME, width, height, &channels))?;
    Ok(stream)
}

/// Names of a layer's channels: those of the radiance are bare.
fn channels(shot: &Shot, layer: &str) -> Vec<String> {
    let names = shot.part(layer, 0..0).map(|plane| plane.channels).unwrap_or_default();
    let with_layer = |name: String| if layer == "radiance" { name } else { format!("{layer}.{name}") };
    names.into_iter().map(with_layer).collect()
}

fn send(stream: &mut TcpStream, shot: &Shot) -> io::Result<()> {
    let [width, height] = shot.size();
    for layer in shot.layers() {
        let channels = channels(shot, &layer);
        let rows_per_packet = (PACKET_VALUES / (width as usize * channels.len().max(1)).max(1)).max(1) as u32;
        for first in (0..height).step_by(rows_per_packet as usize) {
            let count = rows_per_packet.min(height - first);
            let pixels = (first * width) as usize..((first + count) * width) as usize;
            let Some(plane) = shot.part(&layer, pixels) else { continue };
            let rows = Rows { first, count, width, values: &plane.values };
            stream.write_all(&update_image(NAME, &channels, &rows))?;
        }
    }
    Ok(())
}
