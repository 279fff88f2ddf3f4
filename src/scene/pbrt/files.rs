//! Files that a scene names: found beside the scene's main file, read within limits.

use std::collections::HashSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use super::tokens::Place;
use crate::scene::{inflate, text};
use crate::{Error, Result, inputs};

/// Largest file in bytes.
const MAX_BYTES: u64 = 4 << 30;
/// Most bytes of all files, after decompression, too.
const MOST_BYTES: u64 = 16 << 30;
/// Most bytes of files that have been read before: a file that includes another many times would make any number of few.
const MOST_REPEATED_BYTES: u64 = 256 << 20;

/// Most numbers of the dense grids that are made of files, in 2 GB of memory.
const MOST_GRID_NUMBERS: u64 = 1 << 29;

/// First bytes of a file that is compressed by gzip.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Files of one scene, and how much of them has been read.
pub(super) struct Files {
    folder: PathBuf,
    bytes_left: u64,
    repeated_left: u64,
    grid_numbers_left: u64,
    /// Files that have been read.
    known: HashSet<PathBuf>,
}

impl Files {
    /// Files of the scene whose main file is at `main`.
    pub fn new(main: &Path) -> Self {
        let folder = main.parent().unwrap_or(Path::new("")).to_path_buf();
        Self {
            folder,
            bytes_left: MOST_BYTES,
            repeated_left: MOST_REPEATED_BYTES,
            grid_numbers_left: MOST_GRID_NUMBERS,
            known: HashSet::new(),
        }
    }

    /// Path of the file that the scene calls `name`. As in pbrt, names are relative to the folder of the main file.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Path of a file that must exist. `what` says what the file is.
    pub fn existing(&self, name: &str, what: &str, place: &Place) -> Result<PathBuf> {
        let path = self.path(name);
        match path.is_file() {
            true => Ok(path),
            false => Err(place.error(format!("the {what} `{name}` does not exist"))),
        }
    }

    /// Text of a file, which may be compressed by gzip. Bytes that are no UTF-8, as in old comments, are replaced.
    pub fn text(&mut self, path: &Path) -> Result<String> {
        let bytes = self.bytes(path)?;
        Ok(text::decode(bytes).map_or_else(|(bytes, _)| String::from_utf8_lossy(&bytes).into_owned(), |text| text.text))
    }

    /// Content of a file, decompressed where it is compressed by gzip.
    pub fn bytes(&mut self, path: &Path) -> Result<Vec<u8>> {
        let fault = |message: String| Error::scene(path, None, message);
        let mut bytes = inputs::read(path, MAX_BYTES)?;
        if bytes.starts_with(&GZIP) {
            let limit = inflate::most_bytes(bytes.len() as u64).min(MOST_BYTES);
            let mut content = Vec::new();
            MultiGzDecoder::new(&bytes[..]).take(limit + 1).read_to_end(&mut content).map_err(Error::read(path))?;
            if content.len() as u64 > limit {
                return Err(fault(inflate::TOO_LONG.to_owned()));
            }
            bytes = content;
        }
        let length = bytes.len() as u64;
        self.bytes_left = (self.bytes_left.checked_sub(length))
            .ok_or_else(|| fault(format!("with it the scene's files have more than {MOST_BYTES} bytes")))?;
        if !self.known.insert(path.canonicalize().map_err(Error::read(path))?) {
            self.repeated_left = self.repeated_left.checked_sub(length).ok_or_else(|| {
                let message = format!("files that are read again and again have more than {MOST_REPEATED_BYTES} bytes");
                fault(format!("{message}; use ObjectBegin and ObjectInstance for what repeats"))
            })?;
        }
        Ok(bytes)
    }

    /// Counts the numbers of a dense grid that a file becomes.
    pub fn count_grid(&mut self, numbers: usize, place: &Place) -> Result<()> {
        self.grid_numbers_left = self.grid_numbers_left.checked_sub(numbers as u64).ok_or_else(|| {
            place.error(format!(
                "with this medium the grids have more than {MOST_GRID_NUMBERS} numbers; name fewer media"
            ))
        })?;
        Ok(())
    }
}

/// Beginning of a file, decompressed where it is compressed by gzip, and whether it is.
pub(super) fn beginning(path: &Path, length: u64) -> Result<(Vec<u8>, bool)> {
    let begin = |reader: &mut dyn Read| -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        reader.take(length).read_to_end(&mut bytes).map_err(Error::read(path))?;
        Ok(bytes)
    };
    let bytes = begin(&mut inputs::open(path)?.0)?;
    match bytes.starts_with(&GZIP) {
        true => Ok((begin(&mut MultiGzDecoder::new(inputs::open(path)?.0))?, true)),
        false => Ok((bytes, false)),
    }
}
