//! Checkpoints with right hashes: whatever they hold, they are read or refused in one sentence.
//!
//! An input is the JSON of a header, a zero byte, and the bytes of the parts. The target sets the lengths and hashes that would
//! otherwise keep the input from getting past them, unless the header says `"keep"` in place of a part's hash.
#![no_main]

use std::fs;

use libfuzzer_sys::fuzz_target;
use lodestar::session::checkpoint::{Checkpoint, MAGIC};
use serde_json::{Value, json};
use xxhash_rust::xxh3::xxh3_128;

/// Sets hashes, and the version of this program.
fn repaired(header: &[u8], mut parts: &[u8]) -> Vec<u8> {
    let Ok(mut value) = serde_json::from_slice::<Value>(header) else { return header.to_vec() };
    if value.get("version").is_some() {
        value["version"] = json!(env!("CARGO_PKG_VERSION"));
    }
    for part in value.get_mut("parts").and_then(Value::as_array_mut).into_iter().flatten() {
        let bytes = part.get("bytes").and_then(Value::as_u64).unwrap_or(0).min(parts.len() as u64) as usize;
        let (own, rest) = parts.split_at(bytes);
        parts = rest;
        if part.get("hash").is_some_and(|hash| hash != "keep") {
            part["hash"] = json!(format!("{:032x}", xxh3_128(own)));
        }
    }
    serde_json::to_vec(&value).unwrap_or_default()
}

fuzz_target!(|input: &[u8]| {
    let end = input.iter().position(|&byte| byte == 0).unwrap_or(input.len());
    let (header, parts) = input.split_at(end);
    let parts = parts.get(1..).unwrap_or_default();
    let header = repaired(header, parts);
    let length = (header.len() as u64).to_le_bytes();
    let file = tempfile::NamedTempFile::new_in("/dev/shm").or_else(|_| tempfile::NamedTempFile::new()).expect("a file");
    let bytes = [&MAGIC[..], &length, &xxh3_128(&header).to_le_bytes(), &header, parts].concat();
    fs::write(file.path(), bytes).expect("written");
    match Checkpoint::read(file.path()) {
        Ok(checkpoint) => {
            // What was read is written and read again.
            checkpoint.write(file.path()).expect("written");
            assert_eq!(Checkpoint::read(file.path()).expect("read again"), checkpoint);
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
    }
});
