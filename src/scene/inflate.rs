//! Limit on what compressed files become, because few bytes can stand for any number.

/// Most times that compressed content is as long as its file. Meshes and text become ten times as long; zeros a thousand times.
const MOST_TIMES: u64 = 100;
/// Length in bytes up to which content is not compared with its file.
const ALWAYS: u64 = 64 << 20;

/// Message of content that is longer.
pub(super) const TOO_LONG: &str =
    "its content is more than 100 times as long as the compressed file; unpack the file, and name that";

/// Most bytes that the content of a compressed file may have.
pub(super) fn most_bytes(file_bytes: u64) -> u64 {
    file_bytes.saturating_mul(MOST_TIMES).max(ALWAYS)
}
