//! Files of a header and parts, each under a hash: checkpoints and guides. Such a file may come from somebody else, so its hashes say only
//! that it is whole.
//!
//! Layout of the file; all numbers are little-endian:
//!
//! | bytes  | content                                                              |
//! |--------|----------------------------------------------------------------------|
//! | 8      | magic number of its kind                                             |
//! | 8      | length of the header                                                 |
//! | 16     | XXH3-128 of the header                                               |
//! | header | JSON: version, what the kind has, and length and hash of each part   |
//! | rest   | the parts, one after the other                                       |
//!
//! The file is written whole or not at all. Hashes detect every altered byte. A file of another version is refused.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

use crate::files::write_whole;
use crate::renderer::StatePart;
use crate::{Error, Result, inputs};

/// Version of this program, which such files name.
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Number of bytes before the header: its magic, length and hash.
pub(super) const PREFIX_BYTES: u64 = 32;
/// Longest version that is repeated in a message.
const MAX_VERSION: usize = 40;
/// Bytes that are hashed at a time.
const BLOCK: usize = 1 << 20;

/// A kind of such files, with its clauses in messages.
#[derive(Debug)]
pub(super) struct Kind {
    /// First bytes of the file. They contain line breaks, which a transfer as text would change.
    pub magic: [u8; 8],
    /// Sentence about a file of another kind.
    pub refusal: &'static str,
    /// Clause about what another version would do, with the remedy; `{version}` stands for that version.
    pub of_other_version: &'static str,
    /// Remedy where another build has written the file.
    pub of_other_build: &'static str,
    /// Remedy where the file is damaged.
    pub of_damage: &'static str,
}

impl Kind {
    /// Whether the file at `path` begins as this kind does.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn is_of(&self, path: &Path) -> Result<bool> {
        let (input, _) = inputs::open(path)?;
        let mut begin = Vec::new();
        input.take(self.magic.len() as u64).read_to_end(&mut begin).map_err(Error::read(path))?;
        Ok(begin == self.magic)
    }

    pub fn damaged(&self, path: &Path) -> Error {
        Error::checkpoint(path, format!("it was cut short or altered after it was written; {}", self.of_damage))
    }

    /// Writes a file of this kind, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Write`]. An older file then stays as it was.
    pub fn write(&self, path: &Path, header: &impl Serialize, parts: &[StatePart]) -> Result<()> {
        write_whole(path, |writer| {
            let header = serde_json::to_vec(header)?;
            writer.write_all(&self.magic)?;
            writer.write_all(&(header.len() as u64).to_le_bytes())?;
            writer.write_all(&xxh3_128(&header).to_le_bytes())?;
            writer.write_all(&header)?;
            parts.iter().try_for_each(|part| writer.write_all(&part.bytes))
        })
    }
}

/// A part as the header names it.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartEntry {
    pub name: String,
    pub bytes: u64,
    /// XXH3-128 of the part's bytes, in hexadecimal.
    pub hash: String,
}

impl From<&StatePart> for PartEntry {
    fn from(part: &StatePart) -> Self {
        Self { name: part.name.clone(), bytes: part.bytes.len() as u64, hash: hash_text(xxh3_128(&part.bytes)) }
    }
}

/// A hash as the header has it.
fn hash_text(hash: u128) -> String {
    format!("{hash:032x}")
}

/// Fields that the header of every version has.
#[derive(Deserialize)]
struct AnyHeader {
    version: String,
}

/// Parts that are still in their file.
#[derive(Debug)]
pub(super) struct SavedParts {
    kind: &'static Kind,
    path: PathBuf,
    file: File,
    /// The parts in order.
    parts: Vec<PartEntry>,
    /// Position of the first part in the file.
    begin: u64,
}

impl SavedParts {
    /// File of the parts.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names and lengths in bytes of the parts.
    pub fn shape(&self) -> Vec<(String, u64)> {
        self.parts.iter().map(|part| (part.name.clone(), part.bytes)).collect()
    }

    /// The parts whose names and lengths in bytes are `wanted`.
    ///
    /// # Errors
    /// Where the file cannot be read, or was altered since it was opened.
    pub fn read(&self, wanted: impl Fn(&str, u64) -> bool) -> Result<Vec<StatePart>> {
        let (mut parts, mut at) = (Vec::new(), self.begin);
        for PartEntry { name, bytes, hash } in &self.parts {
            if wanted(name, *bytes) {
                let mut content = Vec::new();
                let mut file = &self.file;
                let read = file.seek(SeekFrom::Start(at)).and_then(|_| file.take(*bytes).read_to_end(&mut content));
                read.map_err(Error::read(&self.path))?;
                let part = StatePart { name: name.clone(), bytes: content };
                if part.bytes.len() as u64 != *bytes || hash_text(xxh3_128(&part.bytes)) != *hash {
                    return Err(self.kind.damaged(&self.path));
                }
                parts.push(part);
            }
            at += bytes;
        }
        Ok(parts)
    }
}

/// Reader of such a file.
pub(super) struct Reader<'a> {
    kind: &'static Kind,
    path: &'a Path,
    file: File,
    /// Position after what was read.
    begin: u64,
    length: u64,
}

impl<'a> Reader<'a> {
    pub fn open(path: &'a Path, kind: &'static Kind) -> Result<Self> {
        let (input, length) = inputs::open(path)?;
        Ok(Self { kind, path, file: input.into_file(), begin: 0, length })
    }

    /// Reads the header. Its memory is that of its values, whatever length the file announces.
    pub fn header<H: DeserializeOwned>(&mut self) -> Result<H> {
        let mut prefix = [0; PREFIX_BYTES as usize];
        let is_long = self.length >= PREFIX_BYTES;
        if is_long {
            self.file.read_exact(&mut prefix).map_err(Error::read(self.path))?;
        }
        if !is_long || !prefix.starts_with(&self.kind.magic) {
            return Err(Error::checkpoint(self.path, self.kind.refusal));
        }
        self.begin = PREFIX_BYTES;
        let [length, hash] = [&prefix[8..16], &prefix[16..]];
        let length = length.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte));
        let is_json = |byte: u8| byte.is_ascii_whitespace() || byte > b' ';
        if length > self.length - self.begin || self.hash(length, is_json)?.to_le_bytes() != *hash {
            return Err(self.kind.damaged(self.path));
        }
        let unreadable = |error| Error::checkpoint(self.path, format!("its header cannot be read ({error})"));
        let AnyHeader { version } = self.parsed(length)?.map_err(unreadable)?;
        if version.len() > MAX_VERSION || !version.chars().all(|letter| letter.is_ascii_graphic()) {
            return Err(Error::checkpoint(self.path, "its header cannot be read (its version is no version)"));
        }
        if version != VERSION {
            let rest = self.kind.of_other_version.replace("{version}", &version);
            let message = format!("version {version} wrote it, and version {VERSION} {rest}");
            return Err(Error::checkpoint(self.path, message));
        }
        let remedy = self.kind.of_other_build;
        let unknown = |_| {
            let message = format!("another build has written it, whose settings differ from this one's; {remedy}");
            Error::checkpoint(self.path, message)
        };
        let header = self.parsed(length)?.map_err(unknown)?;
        self.begin += length;
        Ok(header)
    }

    /// JSON of the next `length` bytes.
    fn parsed<T: DeserializeOwned>(&self, length: u64) -> Result<serde_json::Result<T>> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(self.begin)).map_err(Error::read(self.path))?;
        Ok(serde_json::from_reader(BufReader::new(file.take(length))))
    }

    /// Hash of the next `length` bytes, all of which must be `allowed`.
    fn hash(&self, length: u64, allowed: impl Fn(u8) -> bool) -> Result<u128> {
        let mut file = &self.file;
        let (mut hash, mut left) = (Xxh3::new(), length);
        let mut block = vec![0; left.min(BLOCK as u64) as usize];
        file.seek(SeekFrom::Start(self.begin)).map_err(Error::read(self.path))?;
        while left > 0 {
            let count = left.min(BLOCK as u64) as usize;
            let bytes = &mut block[..count];
            file.read_exact(bytes).map_err(|error| match error.kind() {
                ErrorKind::UnexpectedEof => self.kind.damaged(self.path),
                _ => Error::read(self.path)(error),
            })?;
            if !bytes.iter().all(|&byte| allowed(byte)) {
                return Err(self.kind.damaged(self.path));
            }
            hash.update(bytes);
            left -= count as u64;
        }
        Ok(hash.digest128())
    }

    /// Checks the names of the parts, and that they are as long as the rest of the file. Returns their length in bytes.
    pub fn check_lengths(&self, parts: &[PartEntry]) -> Result<u64> {
        let names: HashSet<_> = parts.iter().map(|part| &part.name).collect();
        if names.len() < parts.len() {
            let remedy = self.kind.of_damage;
            return Err(Error::checkpoint(self.path, format!("it has two parts of one name; {remedy}")));
        }
        let bytes = parts.iter().fold(0u64, |sum, part| sum.saturating_add(part.bytes));
        if bytes == self.length - self.begin { Ok(bytes) } else { Err(self.kind.damaged(self.path)) }
    }

    /// The parts, whose lengths are right, after a check of their hashes.
    pub fn into_parts(mut self, parts: Vec<PartEntry>) -> Result<SavedParts> {
        let begin = self.begin;
        for part in &parts {
            if hash_text(self.hash(part.bytes, |_| true)?) != part.hash {
                return Err(self.kind.damaged(self.path));
            }
            self.begin += part.bytes;
        }
        Ok(SavedParts { kind: self.kind, path: self.path.to_path_buf(), file: self.file, parts, begin })
    }
}
