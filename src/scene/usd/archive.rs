//! Archives of the format USDZ: ZIP files whose entries are stored, not compressed.

use std::collections::HashMap;
use std::ops::Range;

/// Most entries of an archive.
const MOST_ENTRIES: usize = 1 << 16;

/// Archive in memory.
pub(super) struct Archive {
    bytes: Vec<u8>,
    entries: HashMap<String, Range<usize>>,
    /// Names in the order of the archive.
    names: Vec<String>,
}

impl Archive {
    /// Reads the directory of an archive. The error says what is wrong.
    pub fn new(bytes: Vec<u8>) -> Result<Self, String> {
        let damaged = || "it is no USDZ archive, or it is cut short".to_owned();
        let end = directory_end(&bytes).ok_or_else(damaged)?;
        let count = usize::from(short(&bytes, end + 10).ok_or_else(damaged)?);
        let mut at = long(&bytes, end + 16).ok_or_else(damaged)?;
        if count > MOST_ENTRIES {
            return Err(format!("it has more than {MOST_ENTRIES} files"));
        }
        let mut ranges = Vec::new();
        let mut archive = Self { entries: HashMap::new(), names: Vec::new(), bytes };
        for _ in 0..count {
            let bytes = &archive.bytes;
            if bytes.get(at..at + 4) != Some(b"PK\x01\x02") {
                return Err(damaged());
            }
            let field = |offset: usize| short(bytes, at + offset).map(usize::from).ok_or_else(damaged);
            let (method, size) = (field(10)?, long(bytes, at + 24).ok_or_else(damaged)?);
            let (name_length, skipped) = (field(28)?, field(30)? + field(32)?);
            let local = long(bytes, at + 42).ok_or_else(damaged)?;
            let name = bytes.get(at + 46..at + 46 + name_length).ok_or_else(damaged)?;
            let name = String::from_utf8_lossy(name).into_owned();
            if method != 0 {
                return Err("a file in it is compressed, which USDZ does not allow; write it with `usdzip`".to_owned());
            }
            let inner = |offset: usize| short(bytes, local + offset).map(usize::from).ok_or_else(damaged);
            let start = local + 30 + inner(26)? + inner(28)?;
            let range = start..start + size;
            if range.end > bytes.len() {
                return Err(damaged());
            }
            at += 46 + name_length + skipped;
            ranges.push(range.clone());
            if archive.entries.insert(name.clone(), range).is_none() {
                archive.names.push(name);
            }
        }
        // What is read of an archive is never more than the archive.
        ranges.retain(|range| !range.is_empty());
        ranges.sort_by_key(|range| range.start);
        if ranges.windows(2).any(|pair| pair[1].start < pair[0].end) {
            return Err("two files in it share bytes; write it with `usdzip`".to_owned());
        }
        Ok(archive)
    }

    /// Content of a file in the archive.
    pub fn get(&self, name: &str) -> Option<&[u8]> {
        self.bytes.get(self.entries.get(name)?.clone())
    }

    /// Name of the first layer, which is the archive's scene.
    pub fn first_layer(&self) -> Option<&str> {
        let is_layer = |name: &&String| {
            let name = name.to_ascii_lowercase();
            [".usd", ".usda", ".usdc"].iter().any(|extension| name.ends_with(extension))
        };
        self.names.iter().find(is_layer).map(String::as_str)
    }
}

/// Place of the record at the end of the directory.
fn directory_end(bytes: &[u8]) -> Option<usize> {
    const LENGTH: usize = 22;
    const LONGEST_COMMENT: usize = 0xffff;
    let last = bytes.len().checked_sub(LENGTH)?;
    (last.saturating_sub(LONGEST_COMMENT)..=last).rev().find(|&at| bytes[at..].starts_with(b"PK\x05\x06"))
}

fn short(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn long(bytes: &[u8], at: usize) -> Option<usize> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize)
}
