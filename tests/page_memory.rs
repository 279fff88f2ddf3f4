//! Memory that strangers make the page's server take, allocation by allocation.
//!
//! A failed allocation ends a Rust program, so no test can let allocations fail and go on. This test counts them instead: none is
//! larger than the bound below, whatever strangers send, and all together stay below another one. A machine that cannot give that
//! much memory cannot render.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

use lodestar::image::{Image, exr};
use lodestar::view::FileView;
use support::requests::{LENGTHS, Requests};

/// Largest allocation in bytes that a stranger causes: four times the limit of a request's headers.
const LARGEST: usize = 64 << 10;
/// Most bytes that all connections of strangers have at one time: 128 connections of 48 KiB.
const MOST: usize = 6 << 20;

/// Allocator that counts what threads other than the test's own allocate.
struct Counting;

/// Largest allocation since the last look, bytes in use, and the most of them.
static LARGEST_SEEN: AtomicUsize = AtomicUsize::new(0);
static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST_IN_USE: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Whether this thread belongs to the test, which is not counted.
    static IS_OF_TEST: Cell<bool> = const { Cell::new(false) };
}

fn count(taken: usize, given_back: usize) {
    if IS_OF_TEST.try_with(Cell::get).unwrap_or(true) {
        return;
    }
    LARGEST_SEEN.fetch_max(taken, Relaxed);
    // Memory that one thread takes and another gives back can make the difference negative for a while.
    let before = IN_USE.fetch_add(taken.wrapping_sub(given_back), Relaxed);
    let now = before.wrapping_add(taken).wrapping_sub(given_back);
    if now <= isize::MAX as usize {
        MOST_IN_USE.fetch_max(now, Relaxed);
    }
}

// SAFETY: every call goes on to the system's allocator with the caller's own arguments.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(0, layout.size());
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size, layout.size());
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Sends bytes on a new connection, and reads the answer where `is_whole`. Returns the connection.
fn send(host: &str, bytes: &[u8], is_whole: bool) -> TcpStream {
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    // The server may close the connection before all is sent.
    let _ = stream.write_all(bytes);
    if is_whole {
        let _ = stream.shutdown(Shutdown::Write);
        let mut bytes = [0; 4096];
        while stream.read(&mut bytes).is_ok_and(|count| count > 0) {}
    }
    stream
}

#[test]
fn strangers_cause_small_allocations_only() {
    IS_OF_TEST.set(true);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shown.exr");
    let image = Image { width: 256, height: 256, pixels: vec![[0.5; 3]; 256 * 256] };
    std::fs::write(&path, exr::encode_rgb(&path, &image).unwrap()).unwrap();
    let view = FileView::start(&path, "127.0.0.1:0").unwrap();
    let url = view.url();
    let (host, token) = url.strip_prefix("http://").unwrap().split_once("/#").unwrap();
    // The first connection makes tables that stay.
    send(host, b"GET / HTTP/1.0\r\n\r\n", true);
    [&LARGEST_SEEN, &MOST_IN_USE, &IN_USE].iter().for_each(|counter| counter.store(0, Relaxed));

    let cases = if support::tier::is_full() { 100_000 } else { 3000 };
    let mut requests = Requests::new(7, host);
    (0..cases).for_each(|_| drop(send(host, &requests.next_bytes(), true)));
    for length in LENGTHS {
        send(host, format!("POST /stop HTTP/1.1\r\nHost: {host}\r\nContent-Length: {length}\r\n\r\n").as_bytes(), true);
    }
    let long = [b"GET / HTTP/1.1\r\nX: ".to_vec(), vec![b'a'; 4 << 20]].concat();
    send(host, &long, true);
    // More connections than there may be, each with a request that is as large as it may be and has no end.
    let open: Vec<TcpStream> = (0..300).map(|_| send(host, &long[..15 << 10], false)).collect();
    send(host, b"GET / HTTP/1.0\r\n\r\n", true);
    drop(open);
    let (largest, most) = (LARGEST_SEEN.load(Relaxed), MOST_IN_USE.load(Relaxed));
    println!("{cases} cases: the largest allocation has {largest} bytes, all together {most}");
    assert!(largest > 1024 && most > 100 << 10, "nothing was counted");
    assert!(largest <= LARGEST, "an allocation of {largest} bytes");
    assert!(most <= MOST, "{most} bytes at one time");

    // The bound is one that is missed: whoever has the token gets layers of any size.
    let layer =
        format!("GET /layer HTTP/1.1\r\nHost: {host}\r\nX-Lodestar-Token: {token}\r\nConnection: close\r\n\r\n");
    let mut stream = send(host, layer.as_bytes(), false);
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    assert!(answer.len() > 256 * 256 * 6 && LARGEST_SEEN.load(Relaxed) > LARGEST, "{} bytes", answer.len());
}
