//! Checkpoints in their files. A checkpoint may come from somebody else, so its hashes say only that it is whole. Everything in it is
//! checked before it is used, and its state is read into memory once it is known to be what the render needs.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use xxhash_rust::xxh3::Xxh3;

use crate::renderer::{RenderState, StatePart};
use crate::session::checkpoint::{
    Checkpoint, Header, MAGIC, PREFIX_BYTES, PartEntry, Record, SceneSource, VERSION, hash_text,
};
use crate::settings::Settings;
use crate::{Error, Result, inputs};

/// Least bytes of a state for each pixel: those of the film.
const FILM_BYTES: u64 = 64;
/// Longest version that is repeated in a message.
const MAX_VERSION: usize = 40;
/// Bytes that are hashed at a time.
const BLOCK: usize = 1 << 20;

/// A checkpoint whose state is still in its file.
#[derive(Debug)]
pub struct SavedCheckpoint {
    /// File and fingerprint of the scene.
    pub scene: SceneSource,
    /// The settings. They are valid.
    pub settings: Settings,
    /// Device and driver on which the render began.
    pub device: String,
    /// Length, files and steps of the render.
    pub record: Record,
    /// The state.
    pub state: SavedState,
}

/// State of a render in the file of a checkpoint.
#[derive(Debug)]
pub struct SavedState {
    /// Samples per pixel so far.
    pub samples_done: u32,
    path: PathBuf,
    file: File,
    /// The parts in order.
    parts: Vec<PartEntry>,
    /// Position of the first part in the file.
    begin: u64,
}

/// Fields that the header of every version has.
#[derive(Deserialize)]
struct AnyHeader {
    version: String,
}

impl SavedCheckpoint {
    /// Opens a checkpoint of this version, and checks everything but whether its state suits a render.
    ///
    /// # Errors
    /// [`Error::Read`], or [`Error::Checkpoint`] if the file is no checkpoint, is of another version, was cut short or was
    /// altered.
    pub fn open(path: &Path) -> Result<Self> {
        let mut reader = Reader::open(path)?;
        let header = reader.header()?;
        header.settings.validate().map_err(|error| Error::checkpoint(path, error.to_string()))?;
        check(&header).map_err(|fault| Error::checkpoint(path, format!("{fault}; go on from another copy")))?;
        let Header { scene, settings, device, record, samples_done, parts, .. } = header;
        reader.check_parts(&parts, &settings)?;
        let Reader { file, begin, .. } = reader;
        let state = SavedState { samples_done, path: path.to_path_buf(), file, parts, begin };
        Ok(Self { scene, settings, device, record, state })
    }
}

impl Checkpoint {
    /// Reads a checkpoint of this version with all of its state.
    ///
    /// # Errors
    /// Where [`SavedCheckpoint::open`] fails.
    pub fn read(path: &Path) -> Result<Self> {
        let SavedCheckpoint { scene, settings, device, record, state } = SavedCheckpoint::open(path)?;
        let state = state.read(|_, _| true)?;
        Ok(Self { scene, settings, device, record, state })
    }
}

impl SavedState {
    /// The parts whose names and lengths in bytes are `wanted`.
    ///
    /// # Errors
    /// Where the file cannot be read, or was altered since it was opened.
    pub fn read(&self, wanted: impl Fn(&str, u64) -> bool) -> Result<RenderState> {
        let (mut parts, mut at) = (Vec::new(), self.begin);
        for PartEntry { name, bytes, hash } in &self.parts {
            if wanted(name, *bytes) {
                let mut content = Vec::new();
                let mut file = &self.file;
                let read = file.seek(SeekFrom::Start(at)).and_then(|_| file.take(*bytes).read_to_end(&mut content));
                read.map_err(Error::read(&self.path))?;
                let part = StatePart { name: name.clone(), bytes: content };
                if part.bytes.len() as u64 != *bytes || hash_text(xxhash_rust::xxh3::xxh3_128(&part.bytes)) != *hash {
                    return Err(damaged(&self.path));
                }
                parts.push(part);
            }
            at += bytes;
        }
        Ok(RenderState { samples_done: self.samples_done, parts })
    }

    /// The whole state, if its parts have these names and lengths in bytes.
    ///
    /// # Errors
    /// Where the state has other parts, or where [`SavedState::read`] fails.
    pub fn read_as(&self, shape: &[(String, u64)]) -> Result<RenderState> {
        let theirs: Vec<_> = self.parts.iter().map(|part| (part.name.clone(), part.bytes)).collect();
        if theirs != shape {
            let list = |parts: &[(String, u64)]| {
                let parts = parts.iter().map(|(name, bytes)| format!("{name:?}: {bytes} bytes"));
                parts.collect::<Vec<_>>().join(", ")
            };
            let message = format!("its state has {}, but this render has {}", list(&theirs), list(shape));
            return Err(Error::checkpoint(&self.path, message));
        }
        self.read(|_, _| true)
    }
}

/// Checks values that the settings' own rules do not cover. The error is a clause.
fn check(header: &Header) -> Result<(), &'static str> {
    let Header { scene, settings, device, record, samples_done, .. } = header;
    let is_text = |text: &String| !text.chars().any(char::is_control);
    let is_time = |seconds: f64| seconds >= 0.0;
    let offset = settings.sample_offset.unwrap_or(0);
    match () {
        () if !is_text(device) || !is_text(&scene.hash) || !record.kernels.iter().all(is_text) => {
            Err("it names its device, scene or kernels by control characters")
        }
        () if !is_time(record.history.seconds) || !record.length.seconds.is_none_or(is_time) => {
            Err("it has a negative time")
        }
        () if offset.checked_add(*samples_done).is_none() || !record.guide_samples.is_sound() => {
            Err("it has sample numbers that no render takes")
        }
        () => Ok(()),
    }
}

/// Reader of a checkpoint file.
struct Reader<'a> {
    path: &'a Path,
    file: File,
    /// Position after what was read.
    begin: u64,
    length: u64,
}

impl<'a> Reader<'a> {
    fn open(path: &'a Path) -> Result<Self> {
        let (input, length) = inputs::open(path)?;
        Ok(Self { path, file: input.into_file(), begin: 0, length })
    }

    /// Reads the header. Its memory is that of its values, whatever length the file announces.
    fn header(&mut self) -> Result<Header> {
        let mut prefix = [0; PREFIX_BYTES as usize];
        let is_long = self.length >= PREFIX_BYTES;
        if is_long {
            self.file.read_exact(&mut prefix).map_err(Error::read(self.path))?;
        }
        if !is_long || !prefix.starts_with(&MAGIC) {
            return Err(Error::checkpoint(self.path, "it is no checkpoint; give one that lodestar has written"));
        }
        self.begin = PREFIX_BYTES;
        let [length, hash] = [&prefix[8..16], &prefix[16..]];
        let length = length.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte));
        let is_json = |byte: u8| byte.is_ascii_whitespace() || byte > b' ';
        if length > self.length - self.begin || self.hash(length, is_json)?.to_le_bytes() != *hash {
            return Err(damaged(self.path));
        }
        let unreadable = |error| Error::checkpoint(self.path, format!("its header cannot be read ({error})"));
        let AnyHeader { version } = self.parsed(length)?.map_err(unreadable)?;
        if version.len() > MAX_VERSION || !version.chars().all(|letter| letter.is_ascii_graphic()) {
            return Err(Error::checkpoint(self.path, "its header cannot be read (its version is no version)"));
        }
        if version != VERSION {
            let message = format!(
                "version {version} wrote it, and version {VERSION} may render other bits; resume it with version {version}"
            );
            return Err(Error::checkpoint(self.path, message));
        }
        let unknown = |_| {
            let message = "another build has written it, whose settings differ from this one's; go on with that build";
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
                ErrorKind::UnexpectedEof => damaged(self.path),
                _ => Error::read(self.path)(error),
            })?;
            if !bytes.iter().all(|&byte| allowed(byte)) {
                return Err(damaged(self.path));
            }
            hash.update(bytes);
            left -= count as u64;
        }
        Ok(hash.digest128())
    }

    /// Checks lengths and hashes of the parts. They are as long as the rest of the file, and hold a film of the settings' size.
    fn check_parts(&mut self, parts: &[PartEntry], settings: &Settings) -> Result<()> {
        let names: HashSet<_> = parts.iter().map(|part| &part.name).collect();
        if names.len() < parts.len() {
            return Err(Error::checkpoint(self.path, "it has two parts of one name; go on from another copy"));
        }
        let bytes = parts.iter().fold(0u64, |sum, part| sum.saturating_add(part.bytes));
        if bytes != self.length - self.begin {
            return Err(damaged(self.path));
        }
        let window = settings.window();
        if u64::from(window.width) * u64::from(window.height) > bytes / FILM_BYTES {
            let (width, height) = (window.width, window.height);
            let message =
                format!("it lacks {FILM_BYTES} bytes per pixel for {width} x {height} pixels; go on from another copy");
            return Err(Error::checkpoint(self.path, message));
        }
        let begin = self.begin;
        for part in parts {
            if hash_text(self.hash(part.bytes, |_| true)?) != part.hash {
                return Err(damaged(self.path));
            }
            self.begin += part.bytes;
        }
        self.begin = begin;
        Ok(())
    }
}

fn damaged(path: &Path) -> Error {
    Error::checkpoint(path, "it was cut short or altered after it was written; go on from another copy")
}
