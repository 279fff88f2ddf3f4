//! Sending shots to a display server. A server that is missing, slow or dead never stops the render.

use std::io::{self, Write};
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
/// Time between two attempts to reach a server, and between two shots.
const INTERVAL: Duration = Duration::from_secs(1);
/// Approximate number of values in one packet.
const PACKET_VALUES: usize = 1 << 18;
/// Name of the image.
const NAME: &str = "lodestar";

/// Sender of shots to one server.
pub(super) struct Display {
    shots: SyncSender<Arc<Shot>>,
    state: Arc<Busy>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

/// Whether the sender is busy, and when it sent last.
struct Busy {
    is_sending: AtomicBool,
    next: Mutex<Instant>,
}

impl Display {
    /// Sends shots to the server at `address` from a thread of its own.
    pub fn start(address: &str) -> Result<Self> {
        let (shots, received) = sync_channel(1);
        let state = Arc::new(Busy { is_sending: AtomicBool::new(false), next: Mutex::new(Instant::now()) });
        let (busy, address) = (Arc::clone(&state), address.to_owned());
        let send = move || send_all(&address, &received, &busy);
        let thread = thread::Builder::new().name("display server".into()).spawn(send);
        let thread = thread.map_err(|error| Error::Render(format!("no thread for the display server: {error}")))?;
        Ok(Self { shots, state, thread: Mutex::new(Some(thread)) })
    }

    /// Whether the sender would take another shot.
    pub fn is_ready(&self) -> bool {
        let next = *self.state.next.lock().unwrap_or_else(PoisonError::into_inner);
        !self.state.is_sending.load(Ordering::Relaxed) && Instant::now() >= next
    }

    /// Sends a shot, unless the sender is busy.
    pub fn send(&self, shot: Arc<Shot>) {
        let _ = self.shots.try_send(shot);
    }

    /// Waits until the last shot is sent, at most for a few seconds.
    pub fn finish(self) {
        let Self { shots, thread, .. } = self;
        drop(shots);
        let thread = thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        let end = Instant::now() + 2 * PATIENCE;
        while let Some(thread) = &thread
            && !thread.is_finished()
            && Instant::now() < end
        {
            thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Sends every shot that comes, and connects again after a failure.
fn send_all(address: &str, shots: &Receiver<Arc<Shot>>, busy: &Busy) {
    let mut connection = None;
    for shot in shots {
        busy.is_sending.store(true, Ordering::Relaxed);
        if connection.is_none() {
            connection = connect(address, &shot).ok();
        }
        if let Some(stream) = &mut connection
            && send(stream, &shot).is_err()
        {
            connection = None;
        }
        *busy.next.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now() + INTERVAL;
        busy.is_sending.store(false, Ordering::Relaxed);
    }
}

/// Reaches the server and makes the image there.
fn connect(address: &str, shot: &Shot) -> io::Result<TcpStream> {
    let address = address.to_socket_addrs()?.next().ok_or(io::ErrorKind::NotFound)?;
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE)?;
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
