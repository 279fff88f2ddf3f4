//! Requests of strangers and of holders of the token to the page's server, from the first byte to the end of the connection.
//!
//! The first byte of an input chooses who asks. The text `HOST` stands for the server's address and `TOKEN` for its token, because both
//! differ from run to run. Nothing may panic, and strangers may learn nothing.
#![no_main]

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::OnceLock;
use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use lodestar::image::{Image, exr};
use lodestar::view::FileView;

/// Most bytes of an answer that are looked at.
const MOST: usize = 1 << 20;
/// Type of an answer that is a stream of events.
const EVENTS: &[u8] = b"event-stream";

/// The server, its address and its token.
fn server() -> &'static (FileView, String, String) {
    static SERVER: OnceLock<(FileView, String, String)> = OnceLock::new();
    SERVER.get_or_init(|| {
        let path = std::env::temp_dir().join(format!("lodestar-fuzz-{}.exr", std::process::id()));
        let image = Image { width: 8, height: 8, pixels: vec![[0.5; 3]; 64] };
        std::fs::write(&path, exr::encode_rgb(&path, &image).expect("a picture")).expect("a file");
        let view = FileView::start(&path, "127.0.0.1:0").expect("a server");
        let url = view.url();
        let (host, token) = url.strip_prefix("http://").and_then(|rest| rest.split_once("/#")).expect("an address");
        let (host, token) = (host.to_owned(), token.to_owned());
        (view, host, token)
    })
}

/// `bytes` with `new` in place of every `old`.
fn replaced(bytes: &[u8], old: &[u8], new: &[u8]) -> Vec<u8> {
    let mut result = Vec::with_capacity(bytes.len());
    let mut rest = bytes;
    while let Some(&first) = rest.first() {
        let found = rest.starts_with(old);
        if found { result.extend(new) } else { result.push(first) }
        rest = &rest[if found { old.len() } else { 1 }..];
    }
    result
}

fuzz_target!(|data: &[u8]| {
    let Some((who, bytes)) = data.split_first() else { return };
    let (_, host, token) = server();
    let is_holder = who % 4 == 0;
    let mut bytes = replaced(bytes, b"HOST", host.as_bytes());
    if is_holder {
        bytes = replaced(&bytes, b"TOKEN", token.as_bytes());
    }
    let mut stream = TcpStream::connect(host).expect("the server");
    stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a limit");
    // The server may close the connection before all is sent.
    let _ = stream.write_all(&bytes);
    let _ = stream.shutdown(Shutdown::Write);
    let mut answer = Vec::new();
    let mut part = [0; 1 << 14];
    while let Ok(count) = stream.read(&mut part) {
        answer.extend(&part[..count]);
        // Events do not end, so their head is enough.
        let has_events = answer.windows(EVENTS.len()).any(|window| window == EVENTS);
        if count == 0 || answer.len() >= MOST || has_events {
            break;
        }
    }
    let text = String::from_utf8_lossy(&answer);
    assert!(!text.contains(" 500 Internal"), "{text}");
    let secrets = ["event-stream", "octet-stream", "x-frame", "application/json"];
    assert!(is_holder || secrets.iter().all(|secret| !text.contains(secret)), "{text}");
});
