//! Server of the page: one thread that waits for everybody at once, and a few workers.

use std::convert::Infallible;
use std::future::{Future, poll_fn};
use std::io;
use std::net::{SocketAddr, ToSocketAddrs};
use std::pin::pin;
use std::sync::Arc;
use std::task::Poll;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::watch;
use tokio::task::yield_now;
use tokio::time::{Instant, Sleep, sleep};

use crate::view::board::Board;
use crate::view::guard::{Guard, Token};
use crate::view::guests::{Guests, Visit};
use crate::view::limits::{
    ACCEPT_PAUSE, FAREWELL, FAREWELL_INTERVAL, HEADER_BYTES, HEADERS, Limits, NICENESS, PATIENCE, REQUEST_TIME,
};
use crate::view::routes::Desk;
use crate::view::stream::Patient;
use crate::{Error, Result};

/// A running server.
pub(super) struct Server {
    board: Arc<Board>,
    desk: Arc<Desk>,
    ended: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

/// How long a server waits for somebody who takes no data, and how far it steps back behind the render.
#[derive(Debug, Clone, Copy)]
struct Pace {
    patience: Duration,
    /// Priority of its thread, as of `nice`.
    niceness: i32,
}

impl Server {
    /// Serves `board` at `address`.
    pub fn start(address: &str, board: Arc<Board>) -> Result<Self> {
        Self::at_pace(address, board, Pace { patience: PATIENCE, niceness: NICENESS })
    }

    fn at_pace(address: &str, board: Arc<Board>, pace: Pace) -> Result<Self> {
        let failed = |error: io::Error| {
            Error::Settings(format!("no page can be served at {address}: {error}; give another address or port"))
        };
        let token = Token::find()?;
        let runtime = Builder::new_current_thread().enable_io().enable_time().build().map_err(failed)?;
        let (listener, address_used) = listen(address, &runtime).map_err(failed)?;
        let limits = Limits::of_process();
        let desk = Arc::new(Desk::new(Arc::clone(&board), Guard::new(address_used, token), limits)?);
        let (ended, end) = watch::channel(false);
        let served = Arc::clone(&desk);
        let serve = move || {
            give_way(pace.niceness);
            runtime.block_on(serve(listener, served, Guests::new(limits), pace.patience, end));
            // A worker may still be busy. Nobody waits for it.
            Runtime::shutdown_background(runtime);
        };
        let thread = thread::Builder::new().name("view".into()).spawn(serve).map_err(failed)?;
        Ok(Self { board, desk, ended, thread: Some(thread) })
    }

    /// Address of the page with the token.
    pub fn url(&self) -> String {
        self.desk.url()
    }
}

impl Drop for Server {
    /// Sends the last state to every page before the server ends, because the program may end right after it.
    fn drop(&mut self) {
        self.board.close();
        self.ended.send_replace(true);
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been printed already.
            let _ = thread.join();
        }
    }
}

/// Socket at `address`.
fn listen(address: &str, runtime: &Runtime) -> io::Result<(TcpListener, SocketAddr)> {
    let addresses: Vec<SocketAddr> = address.to_socket_addrs()?.collect();
    let listener = std::net::TcpListener::bind(&addresses[..])?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    let _context = runtime.enter();
    Ok((TcpListener::from_std(listener)?, address))
}

/// Lowers the priority of this thread, so that a flood of requests takes little time from the render. Only Linux has priorities of
/// threads.
#[cfg(target_os = "linux")]
fn give_way(niceness: i32) {
    // Where it is forbidden, the thread keeps its priority. Under `nice`, it may be lower already.
    let present = rustix::process::getpriority_process(None).unwrap_or(0);
    let _ = rustix::process::setpriority_process(None, present.max(niceness));
}

/// Keeps the priority of this thread.
#[cfg(not(target_os = "linux"))]
fn give_way(_: i32) {}

/// Lets everybody in until the end, and gives holders of the token time to receive the last state.
async fn serve(
    listener: TcpListener,
    desk: Arc<Desk>,
    guests: Arc<Guests>,
    patience: Duration,
    end: watch::Receiver<bool>,
) {
    let told = Arc::clone(&desk);
    tokio::spawn(async move { told.listeners.tell().await });
    let mut ending = end.clone();
    let mut is_over = pin!(ending.wait_for(|ended| *ended));
    loop {
        let next = poll_fn(|context| match is_over.as_mut().poll(context) {
            Poll::Ready(_) => Poll::Ready(None),
            Poll::Pending => listener.poll_accept(context).map(Some),
        });
        match next.await {
            None => break,
            Some(Ok((stream, address))) => {
                // Events are small, and shall not wait for more.
                let _ = stream.set_nodelay(true);
                let patient = Patient::new(stream, move || sleep(patience));
                guests.enter(address.ip(), |visit| {
                    tokio::spawn(attend(patient, visit, Arc::clone(&desk), end.clone())).abort_handle()
                });
                // Whoever has made room gives the file back before the next one is accepted.
                yield_now().await;
            }
            Some(Err(error)) if error.kind() == io::ErrorKind::ConnectionAborted => {}
            // The process or the system has too many open files, or too little memory for one more.
            Some(Err(_)) => {
                guests.send_one_away();
                sleep(ACCEPT_PAUSE).await;
            }
        }
    }
    drop(listener);
    guests.send_strangers_away();
    let last = Instant::now() + FAREWELL;
    while guests.holders() > 0 && Instant::now() < last {
        sleep(FAREWELL_INTERVAL).await;
    }
}

/// Answers the requests of one connection. At the end, the answer under way is the last one.
async fn attend<W>(stream: Patient<TcpStream, W>, visit: Visit, desk: Arc<Desk>, mut end: watch::Receiver<bool>)
where
    W: Fn() -> Sleep + Unpin,
{
    let visit = Arc::new(visit);
    let service = service_fn(|request: Request<Incoming>| {
        let (desk, visit) = (Arc::clone(&desk), Arc::clone(&visit));
        async move { Ok::<_, Infallible>(desk.answer(request, &visit).await) }
    });
    let mut builder = http1::Builder::new();
    builder.timer(TokioTimer::new()).header_read_timeout(REQUEST_TIME).max_headers(HEADERS).max_buf_size(HEADER_BYTES);
    let mut connection = pin!(builder.serve_connection(TokioIo::new(stream), service));
    let mut is_over = pin!(end.wait_for(|ended| *ended));
    let mut is_ending = false;
    let served = poll_fn(|context| {
        if !is_ending && is_over.as_mut().poll(context).is_ready() {
            is_ending = true;
            connection.as_mut().graceful_shutdown();
        }
        connection.as_mut().poll(context)
    });
    // Whoever sends no HTTP, leaves or takes too long is no error of ours.
    let _ = served.await;
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::net::TcpStream;

    use super::*;
    use crate::image::layers::{Layers, Samples};
    use crate::view::board::Phase;
    use crate::view::shot::{Content, Shot};

    /// Server of a new board, with its address and its token. It has the priority of the tests, which run on all cores beside it, and
    /// drops nobody who takes no data.
    fn server() -> (Arc<Board>, Server, String, String) {
        let board = Arc::new(Board::default());
        let pace = Pace { patience: Duration::from_secs(86_400), niceness: 0 };
        let server = Server::at_pace("127.0.0.1:0", Arc::clone(&board), pace).unwrap();
        let url = server.url();
        let (host, token) = url.trim_start_matches("http://").split_once("/#").unwrap();
        (board, server, host.to_owned(), token.to_owned())
    }

    /// Connection that has sent a request with the token.
    fn ask(host: &str, token: &str, request: &str) -> TcpStream {
        let mut page = TcpStream::connect(host).unwrap();
        page.set_read_timeout(Some(Duration::from_secs(600))).unwrap();
        write!(page, "{request} HTTP/1.1\r\nHost: {host}\r\nX-Lodestar-Token: {token}\r\n\r\n").unwrap();
        page
    }

    /// Bytes of an answer until it contains a word.
    fn read_until(page: &mut TcpStream, word: &str) -> String {
        let mut text = String::new();
        while !text.contains(word) {
            let mut bytes = [0; 4096];
            let count = page.read(&mut bytes).unwrap();
            assert!(count > 0, "the connection has ended: {text}");
            text += &String::from_utf8_lossy(&bytes[..count]);
        }
        text
    }

    /// A page has the last state before the server ends, also where the state changes at the last moment.
    #[test]
    fn the_last_state_reaches_pages() {
        for _ in 0..5 {
            let (board, server, host, token) = server();
            let mut page = ask(&host, &token, "GET /events");
            let text = read_until(&mut page, "data: ");
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

    /// A page that takes no data delays the end by the farewell only. Without the farewell's limit, the end would take a day here.
    #[test]
    fn the_end_waits_for_nobody_longer_than_the_farewell() {
        let (board, server, host, token) = server();
        let mut hung = ask(&host, &token, "GET /events");
        read_until(&mut hung, "data: ");
        board.change(|pinned| pinned.state.message = "long ".repeat(2 << 20));
        let begin = std::time::Instant::now();
        let (ended, end) = std::sync::mpsc::channel();
        thread::spawn(move || {
            drop(server);
            ended.send(())
        });
        end.recv_timeout(Duration::from_secs(600)).expect("the server has ended");
        assert!(begin.elapsed() > FAREWELL / 2, "the page was waited for");
        drop(hung);
    }

    /// A panic while an answer is made ends that answer only.
    #[test]
    fn a_panic_ends_one_answer() {
        let (board, _server, host, token) = server();
        let channel = |name: &str, pixels| (name.to_owned(), Samples::Floats(vec![0.0; pixels]));
        let channels = vec![channel("R", 4), channel("G", 1), channel("B", 4)];
        let layers = Layers { width: 2, height: 2, offset: [0, 0], full_size: [2, 2], channels };
        board.change(|pinned| pinned.shot = Some(Arc::new(Shot::new(1, 1, 1.0, Content::Read(layers)))));
        for _ in 0..4 {
            read_until(&mut ask(&host, &token, "GET /layer?name=radiance"), "500 Internal Server Error");
        }
        read_until(&mut ask(&host, &token, "POST /stop"), "204 No Content");
        assert!(board.is_stopped());
        assert_eq!(board.answering.load(std::sync::atomic::Ordering::Relaxed), 0);
    }
}
