//! Server of the page. Every request is answered by a thread of its own, so that a page that hangs delays nobody.

use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use crate::image::exr;
use crate::image::layers::{Layers, Samples};
use crate::view::board::{Board, Phase};
use crate::view::guard::Guard;
use crate::view::routes::{Desk, refuse_for_now};
use crate::view::shot::{Content, Shot};
use crate::{Error, Result};

/// Time after which a page that takes no data is dropped.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time that pages have at the end to receive the last state.
const FAREWELL: Duration = Duration::from_secs(2);
/// Interval at which the server looks whether they have it.
const FAREWELL_INTERVAL: Duration = Duration::from_millis(10);
/// Most requests at one time. Further ones are refused.
const MOST_REQUESTS: usize = 64;

/// A running server.
pub(super) struct Server {
    board: Arc<Board>,
    desk: Arc<Desk>,
    http: Arc<tiny_http::Server>,
    thread: Option<JoinHandle<()>>,
}

/// Checks that `text` is an address with a port.
///
/// # Errors
/// A clause that says how to write one.
pub fn check_address(text: &str) -> Result<String, String> {
    let port = text.rsplit_once(':').filter(|(host, _)| !host.is_empty()).map(|(_, port)| port.parse::<u16>());
    match port {
        Some(Ok(_)) => Ok(text.to_owned()),
        _ => Err("write it as ADDRESS:PORT, such as 127.0.0.1:8000; port 0 is a free port".into()),
    }
}

impl Server {
    /// Serves `board` at `address`.
    pub fn start(address: &str, board: Arc<Board>) -> Result<Self> {
        let failed = |error: &dyn std::fmt::Display| {
            Error::Settings(format!("no page can be served at {address}: {error}; give another address or port"))
        };
        let (listener, address_used) = listen(address).map_err(|error| failed(&error))?;
        let desk = Arc::new(Desk { board: Arc::clone(&board), guard: Guard::new(address_used)? });
        let http = Arc::new(tiny_http::Server::from_listener(listener, None).map_err(|error| failed(&error))?);
        let (of_thread, served) = (Arc::clone(&http), Arc::clone(&desk));
        let serve = move || serve(&of_thread, &served);
        let thread = thread::Builder::new().name("view".into()).spawn(serve).map_err(|error| failed(&error))?;
        Ok(Self { board, desk, http, thread: Some(thread) })
    }

    /// Address of the page with the token.
    pub fn url(&self) -> String {
        self.desk.guard.url()
    }
}

impl Drop for Server {
    /// Sends the last state to every page before the server ends, because the program may end right after it.
    fn drop(&mut self) {
        self.board.close();
        let end = Instant::now() + FAREWELL;
        while self.board.listening.load(Ordering::Relaxed) > 0 && Instant::now() < end {
            thread::sleep(FAREWELL_INTERVAL);
        }
        self.http.unblock();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been printed already.
            let _ = thread.join();
        }
    }
}

/// Socket at `address`. Whoever connects inherits its limits of time.
fn listen(address: &str) -> std::io::Result<(TcpListener, SocketAddr)> {
    let addresses: Vec<SocketAddr> = address.to_socket_addrs()?.collect();
    let listener = TcpListener::bind(&addresses[..])?;
    let socket = socket2::SockRef::from(&listener);
    socket.set_write_timeout(Some(PATIENCE))?;
    let address = listener.local_addr()?;
    Ok((listener, address))
}

fn serve(http: &tiny_http::Server, desk: &Arc<Desk>) {
    let running = Arc::new(AtomicUsize::new(0));
    for request in http.incoming_requests() {
        if running.load(Ordering::Relaxed) >= MOST_REQUESTS {
            refuse_for_now(request);
            continue;
        }
        running.fetch_add(1, Ordering::Relaxed);
        let (desk, counted) = (Arc::clone(desk), Arc::clone(&running));
        let answer = move || {
            desk.answer(request);
            counted.fetch_sub(1, Ordering::Relaxed);
        };
        if thread::Builder::new().name("view request".into()).spawn(answer).is_err() {
            running.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

/// A page that shows a picture file. The picture is read again when the file changes.
pub struct FileView {
    server: Server,
    path: PathBuf,
    changed: Option<SystemTime>,
    shots: u64,
}

impl FileView {
    /// Serves the picture in the file `path` at `address`.
    ///
    /// # Errors
    /// Where the file is no EXR picture, or the address cannot be used.
    pub fn start(path: &Path, address: &str) -> Result<Self> {
        let layers = read(path)?;
        let server = Server::start(address, Arc::new(Board::default()))?;
        let mut view = Self { server, path: path.to_path_buf(), changed: changed(path), shots: 0 };
        view.show(layers);
        Ok(view)
    }

    /// Address of the page.
    pub fn url(&self) -> String {
        self.server.url()
    }

    /// Reads the picture again if its file has changed. A file that cannot be read is tried again when it changes.
    pub fn refresh(&mut self) {
        let now = changed(&self.path);
        if now.is_some() && now != self.changed {
            self.changed = now;
            if let Ok(layers) = read(&self.path) {
                self.show(layers);
            }
        }
    }

    fn show(&mut self, layers: Layers) {
        self.shots += 1;
        let attributes = exr::read_attributes(&self.path).unwrap_or_default();
        let text = |name: &str| attributes.iter().find(|(found, _)| found == name).map(|(_, value)| value.clone());
        let samples = text("spp").and_then(|spp| spp.parse().ok()).unwrap_or(0);
        let seconds = text("seconds").and_then(|seconds| seconds.parse().ok()).unwrap_or(0.0);
        let shot = Shot::new(self.shots, samples, seconds, Content::Read(layers));
        self.server.board.change(|pinned| {
            let state = &mut pinned.state;
            (state.phase, state.shot) = (Phase::File, self.shots);
            (state.samples, state.seconds, state.fraction) = (samples, seconds, 1.0);
            state.scene = self.path.display().to_string();
            state.device = text("device").unwrap_or_default();
            state.sampler = text("sampler").unwrap_or_default();
            state.no_guide =
                Some("A file has no guide. Watch the render with --view to see what the guide learns.".into());
            pinned.shot = Some(Arc::new(shot));
        });
    }
}

/// Layers of a picture that lodestar has written, or the color of another one.
fn read(path: &Path) -> Result<Layers> {
    exr::read_layers(path).map(|(layers, _)| layers).or_else(|_| {
        let image = exr::read_rgb(path)?;
        let (width, height) = (image.width, image.height);
        let channel = |c: usize| Samples::Floats(image.pixels.iter().map(|pixel| pixel[c]).collect());
        let channels = ["R", "G", "B"].into_iter().enumerate().map(|(c, name)| (name.to_owned(), channel(c)));
        Ok(Layers { width, height, offset: [0, 0], full_size: [width, height], channels: channels.collect() })
    })
}

fn changed(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|metadata| metadata.modified()).ok()
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::net::TcpStream;

    use super::*;

    /// A write to a page that takes no data fails after the limit, because a connection has the limit of its listener.
    #[test]
    fn connections_inherit_the_limit_of_time() {
        let (listener, address) = listen("127.0.0.1:0").unwrap();
        let _page = TcpStream::connect(address).unwrap();
        let (connection, _) = listener.accept().unwrap();
        assert_eq!(connection.write_timeout().unwrap(), Some(PATIENCE));
    }

    /// A page has the last state before the server ends, also where the state changes at the last moment.
    #[test]
    fn the_last_state_reaches_pages() {
        for _ in 0..5 {
            let board = Arc::new(Board::default());
            let server = Server::start("127.0.0.1:0", Arc::clone(&board)).unwrap();
            let url = server.url();
            let host = url.trim_start_matches("http://").split('/').next().unwrap();
            let mut page = TcpStream::connect(host).unwrap();
            write!(page, "GET /events HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
            let mut text = String::new();
            while !text.contains("data: ") {
                let mut bytes = [0; 4096];
                let count = page.read(&mut bytes).unwrap();
                text += std::str::from_utf8(&bytes[..count]).unwrap();
            }
            assert!(!text.contains("\"ended\""), "{text}");

            board.change(|pinned| pinned.state.phase = Phase::Ended);
            drop(server);
            page.set_nonblocking(true).unwrap();
            let mut rest = String::new();
            // The connection is closed, or there is nothing more to be read yet.
            let _ = page.read_to_string(&mut rest);
            assert!(rest.contains("\"ended\""), "{rest}");
        }
    }

    #[test]
    fn addresses_have_a_host_and_a_port() {
        for good in ["127.0.0.1:0", "localhost:8000", "[::1]:8000", "rack7:65535"] {
            assert_eq!(check_address(good).as_deref(), Ok(good));
        }
        for bad in ["", "8000", ":8000", "scene.xml", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1"] {
            assert!(check_address(bad).is_err(), "{bad}");
        }
    }
}
