//! Strangers who want to hang or end the program: each of their ways alone, all of them at once beside a render, and seeded noise.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use support::requests::{LENGTHS, Requests};

use crate::browser::PATIENCE;
use crate::program::{Program, endless, layers, render, size};

/// Most memory in MiB that strangers may take in all: connections of 32 KiB each, and what the allocator keeps.
const MOST_MEMORY: f64 = 16.0;
/// Most bytes that one connection may send before it is cut off: the server's buffer, and those of the system on both sides.
const MOST_SENT: usize = 16 << 20;
/// Longest time for an answer to a holder of the token, and for the end of the program. Other tests keep the cores busy.
const PROMPT: Duration = Duration::from_secs(15);
/// Time after which the server drops whoever is slow, and some more.
const DROPPED: Duration = Duration::from_secs(25);
/// Connections of one attack. This process may have 1,024 files, and tests run side by side.
const CONNECTIONS: usize = 150;

fn connect(program: &Program) -> TcpStream {
    let stream = TcpStream::connect(program.address().0).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_write_timeout(Some(PATIENCE)).unwrap();
    stream
}

/// Connections that have sent some bytes. The server may have closed them.
fn send_on_many(program: &Program, bytes: &str) -> Vec<TcpStream> {
    let one = |_| {
        let mut stream = connect(program);
        // A closed connection fails here or later.
        let _ = stream.write_all(bytes.as_bytes());
        stream
    };
    (0..CONNECTIONS).map(one).collect()
}

/// Everything that a connection receives until it ends. A reset is an end.
fn read_all(stream: &mut TcpStream) -> Vec<u8> {
    let mut answer = Vec::new();
    let mut bytes = [0; 4096];
    loop {
        match stream.read(&mut bytes) {
            Ok(0) => return answer,
            Ok(count) => answer.extend(&bytes[..count]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                panic!("the connection does not end: {}", String::from_utf8_lossy(&answer))
            }
            Err(_) => return answer,
        }
    }
}

/// Checks that whoever has the token is answered: page, events and picture.
#[track_caller]
fn assert_the_owner_is_served(program: &Program) {
    let begin = Instant::now();
    assert_eq!(program.ask_as_page("GET /").0, 200);
    assert!(program.state()["phase"].is_string());
    let status = program.ask_as_page("GET /layer?name=radiance").0;
    assert!(status == 200 || status == 204, "{status}");
    assert!(begin.elapsed() < PROMPT, "{:?}", begin.elapsed());
}

/// Ends the program by a signal and checks that it does not wait.
#[track_caller]
fn assert_ends_promptly(program: &mut Program, signal: &str) {
    let begin = Instant::now();
    program.signal(signal);
    program.wait();
    assert!(begin.elapsed() < PROMPT, "{:?}", begin.elapsed());
}

/// No announced length makes the server allocate, wait or count. One of 10^11 once ended the program.
#[test]
fn lengths_of_every_size_are_refused() {
    let mut program = Program::start_view();
    let (address, token) = program.address();
    let before = program.memory("VmHWM");
    for host in [address, "evil.example"] {
        for token in [String::new(), format!("X-Lodestar-Token: {token}\r\n")] {
            for length in LENGTHS {
                for request in ["GET /", "POST /stop"] {
                    let mut stream = connect(&program);
                    let head = format!(
                        "{request} HTTP/1.1\r\nHost: {host}\r\n{token}Content-Length: {length}\r\nConnection: close\r\n\r\n"
                    );
                    stream.write_all(head.as_bytes()).unwrap();
                    let answer = String::from_utf8_lossy(&read_all(&mut stream)).into_owned();
                    let is_none = matches!(length.trim(), "0");
                    assert!(answer.starts_with("HTTP/1.1 4") || is_none, "{request} {length}: {answer}");
                }
            }
            for _ in 0..65 {
                let mut stream = connect(&program);
                let head =
                    format!("GET / HTTP/1.1\r\nHost: {host}\r\n{token}Content-Length: 18446744073709551615\r\n\r\n");
                stream.write_all(head.as_bytes()).unwrap();
                read_all(&mut stream);
            }
        }
    }
    assert_the_owner_is_served(&program);
    let more = program.memory("VmHWM") - before;
    assert!(more < MOST_MEMORY, "{more} MiB");
    assert_ends_promptly(&mut program, "TERM");
}

/// Content that is announced and never comes hangs nothing.
#[test]
fn nobody_waits_for_announced_content() {
    let mut program = Program::start_view();
    let host = program.address().0.to_owned();
    for request in ["POST /stop", "GET /events", "GET /"] {
        for more in
            ["Content-Length: 2000", "Transfer-Encoding: chunked", "Content-Length: 2000\r\nExpect: 100-continue"]
        {
            let connections = send_on_many(&program, &format!("{request} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n\r\n"));
            assert_the_owner_is_served(&program);
            drop(connections);
        }
    }
    let _waiting =
        send_on_many(&program, &format!("POST /stop HTTP/1.1\r\nHost: {host}\r\nContent-Length: 2000\r\n\r\n"));
    assert_ends_promptly(&mut program, "TERM");
}

/// A header line without an end, and header lines without an end, are cut off.
#[test]
fn headers_without_end_are_cut_off() {
    let program = Program::start_view();
    let before = program.memory("VmHWM");
    for (begin, part) in
        [("", "a"), ("GET /", "a"), ("GET / HTTP/1.1\r\nX: ", "a"), ("GET / HTTP/1.1\r\n", "X-Header: 1\r\n")]
    {
        let attacks: Vec<_> = (0..8).map(|_| connect(&program)).collect();
        thread::scope(|scope| {
            for mut stream in attacks {
                scope.spawn(move || {
                    let block = part.repeat((64 << 10) / part.len());
                    let mut sent = 0;
                    let mut all_sent = stream.write_all(begin.as_bytes());
                    while all_sent.is_ok() {
                        sent += block.len();
                        assert!(sent < MOST_SENT, "{begin:?}: the server still reads");
                        all_sent = stream.write_all(block.as_bytes());
                    }
                });
            }
        });
    }
    assert_the_owner_is_served(&program);
    let more = program.memory("VmHWM") - before;
    assert!(more < MOST_MEMORY, "{more} MiB");
}

/// Connections that send nothing use up neither the files of the process nor the server.
#[test]
fn idle_connections_leave_files_and_the_page() {
    let mut program = Program::start_view_with_files(64);
    let idle = send_on_many(&program, "");
    assert_the_owner_is_served(&program);
    let half = send_on_many(&program, "GET / HTTP/1.1\r\n");
    assert_the_owner_is_served(&program);
    assert_ends_promptly(&mut program, "TERM");
    drop((idle, half));
}

/// The server goes on after the system has refused it connections, because the process has too many open files.
#[test]
fn too_many_open_files_end_no_server() {
    let mut program = Program::start_view();
    assert_the_owner_is_served(&program);
    program.limit_files_to_those_open_and(4);
    let idle = send_on_many(&program, "");
    assert_the_owner_is_served(&program);
    drop(idle);
    assert_the_owner_is_served(&program);
    assert_ends_promptly(&mut program, "TERM");
}

/// However many strangers ask, the owner's page is served and ends the render.
#[test]
fn strangers_lock_nobody_out() {
    let mut program = Program::start(&endless());
    let host = program.address().0.to_owned();
    let mut strangers = send_on_many(&program, &format!("GET /events HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    for request in ["GET /page.js", "GET /layer?name=denoised"] {
        strangers.extend(send_on_many(&program, &format!("{request} HTTP/1.1\r\nHost: {host}\r\n\r\n")));
        assert_the_owner_is_served(&program);
    }
    // Only a render that has a sample has a picture.
    program.wait_for(|state| state["samples"].as_u64() > Some(0));
    let begin = Instant::now();
    assert_eq!(program.ask_as_page("POST /stop").0, 204);
    assert_eq!(program.wait(), Some(0));
    assert!(begin.elapsed() < PROMPT, "{:?}", begin.elapsed());
    assert!(size(&program.path("a.exr")) > 1000);
}

/// A wall of tabs, all from one address, has its events and its pictures.
#[test]
fn a_wall_of_tabs_is_served() {
    let program = Program::start_view();
    let mut tabs: Vec<_> = (0..CONNECTIONS).map(|_| program.listen()).collect();
    let _strangers = send_on_many(&program, "");
    for tab in &mut tabs {
        let mut bytes = [0; 16];
        tab.read_exact(&mut bytes).unwrap();
        assert_eq!(&bytes, b"HTTP/1.1 200 OK\r");
    }
    thread::scope(|scope| {
        for _ in 0..30 {
            scope.spawn(|| assert_eq!(program.ask_as_page("GET /layer?name=radiance").0, 200));
        }
    });
}

/// Whoever sends a byte a second, or reads nothing, is dropped after a while.
#[test]
fn whoever_is_slow_is_dropped() {
    let program = Program::start_view();
    let host = program.address().0.to_owned();
    let begin = Instant::now();
    thread::scope(|scope| {
        for first in ["", "GET / HTTP/1.1\r\nHost:", "POST /stop HTTP/1.1\r\nContent-Length: 5\r\n"] {
            let mut stream = connect(&program);
            scope.spawn(move || {
                let mut written = stream.write_all(first.as_bytes());
                while written.is_ok() {
                    assert!(begin.elapsed() < DROPPED, "{first:?} is still listened to");
                    thread::sleep(Duration::from_secs(1));
                    written = stream.write_all(b"a");
                }
            });
        }
        // Requests for far more than the system's buffers hold, of which no answer is read.
        let pipelined = format!("GET /page.js HTTP/1.1\r\nHost: {host}\r\n\r\n").repeat(2000);
        let mut stream = connect(&program);
        scope.spawn(move || {
            let _ = stream.write_all(pipelined.as_bytes());
            thread::sleep(Duration::from_secs(11));
            assert!(read_all(&mut stream).len() < 4 << 20);
        });
    });
    assert_the_owner_is_served(&program);
}

/// Requests of a seeded generator neither end the program nor fill its memory, and tell nothing.
#[test]
fn noise_does_no_harm() {
    let cases = if support::tier::is_full() { 200_000 } else { 4000 };
    let mut program = Program::start_view();
    assert_the_owner_is_served(&program);
    let (host, before) = (program.address().0.to_owned(), program.memory("VmHWM"));
    thread::scope(|scope| {
        for seed in 0..8 {
            let (program, host) = (&program, &host);
            scope.spawn(move || {
                let mut requests = Requests::new(seed, host);
                (0..cases / 8).for_each(|case| exchange(program, &requests.next_bytes(), (seed, case)));
            });
        }
    });
    assert!(program.is_running());
    assert_the_owner_is_served(&program);
    let more = program.memory("VmHWM") - before;
    assert!(more < MOST_MEMORY, "{more} MiB");
    assert_ends_promptly(&mut program, "INT");
    assert!(!program.messages().contains("panicked"), "an answer has panicked");
}

/// Sends bytes of a stranger and checks the answers.
fn exchange(program: &Program, bytes: &[u8], case: (u64, usize)) {
    let mut stream = connect(program);
    // The server may close the connection before all is sent.
    let _ = stream.write_all(bytes);
    let _ = stream.shutdown(Shutdown::Write);
    let answer = read_all(&mut stream);
    let text = String::from_utf8_lossy(&answer);
    let starts_well = answer.is_empty() || ["HTTP/1.1 ", "HTTP/1.0 "].iter().any(|start| text.starts_with(start));
    assert!(starts_well, "{case:?}: {text}");
    for secret in ["event-stream", "octet-stream", "x-frame", "application/json", "shown.exr", " 500 "] {
        assert!(!text.contains(secret), "{case:?}: {text}");
    }
}

/// A render under all attacks at once has its bits, its memory, and its end.
#[test]
fn a_render_under_attack_keeps_bits_memory_and_end() {
    let mut plain = Program::start_silent(&render(&["--spp", "64"]));
    assert_eq!(plain.wait(), Some(0));
    let mut program = Program::start(&render(&["--spp", "64", "--view"]));
    let (is_over, begin) = (AtomicBool::new(false), Instant::now());
    let host = program.address().0.to_owned();
    let ended = thread::scope(|scope| {
        let attacks = [
            String::new(),
            format!("POST /stop HTTP/1.1\r\nHost: {host}\r\nContent-Length: 2000\r\n\r\n"),
            format!("GET / HTTP/1.1\r\nHost: {host}\r\nContent-Length: 99999999999\r\n\r\n"),
            format!("GET /events HTTP/1.1\r\nHost: {host}\r\n\r\n"),
            format!("GET / HTTP/1.1\r\nX: {}", "a".repeat(100 << 10)),
            format!("GET /picture.js HTTP/1.1\r\nHost: {host}\r\n\r\n").repeat(100),
        ];
        for attack in attacks {
            let (host, is_over) = (&host, &is_over);
            scope.spawn(move || {
                let mut open = Vec::new();
                while !is_over.load(Ordering::Relaxed) && begin.elapsed() < 2 * PATIENCE {
                    if let Ok(mut stream) = TcpStream::connect(host) {
                        let _ = stream.write_all(attack.as_bytes());
                        open.push(stream);
                    }
                    if open.len() > 60 {
                        open.remove(0);
                    }
                    thread::sleep(Duration::from_millis(10));
                }
            });
        }
        let ended = program.wait();
        is_over.store(true, Ordering::Relaxed);
        ended
    });
    assert_eq!(ended, Some(0));
    assert_eq!(layers(&plain.path("a.exr")), layers(&program.path("a.exr")));
}
