//! Files that a scene names: found beside the scene's main file, read within limits.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use super::tokens::Place;
use crate::{Error, Result};

/// Largest file in bytes, after decompression, too.
const MAX_BYTES: u64 = 4 << 30;

/// First bytes of a file that is compressed by gzip.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Files of one scene, and how much of them has been read.
pub(super) struct Files {
    folder: PathBuf,
    bytes_left: u64,
}

impl Files {
    /// Files of the scene whose main file is at `main`.
    pub fn new(main: &Path) -> Self {
        Self { folder: main.parent().unwrap_or(Path::new("")).to_path_buf(), bytes_left: 4 * MAX_BYTES }
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
        Ok(String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned()))
    }

    /// Content of a file, decompressed where it is compressed by gzip.
    pub fn bytes(&mut self, path: &Path) -> Result<Vec<u8>> {
        let metadata = path.metadata().map_err(Error::read(path))?;
        if !metadata.is_file() {
            return Err(Error::scene(path, None, "it is not a file"));
        }
        let limit = MAX_BYTES.min(self.bytes_left);
        let mut file = File::open(path).map_err(Error::read(path))?;
        let mut bytes = Vec::new();
        let read = |file: &mut dyn Read, bytes: &mut Vec<u8>| -> Result<()> {
            file.take(limit + 1).read_to_end(bytes).map_err(Error::read(path))?;
            match bytes.len() as u64 > limit {
                true => Err(Error::scene(
                    path,
                    None,
                    format!("with it the scene's files have more bytes than the limit of {limit}"),
                )),
                false => Ok(()),
            }
        };
        read(&mut file, &mut bytes)?;
        if bytes.starts_with(&GZIP) {
            let mut content = Vec::new();
            read(&mut MultiGzDecoder::new(&bytes[..]), &mut content)?;
            bytes = content;
        }
        if bytes.starts_with(b"version https://git-lfs") {
            return Err(Error::scene(
                path,
                None,
                "it is a git-lfs pointer, not the file; fetch it with `git lfs pull`",
            ));
        }
        self.bytes_left -= bytes.len() as u64;
        Ok(bytes)
    }
}

/// Beginning of a file, decompressed where it is compressed by gzip, and whether it is.
pub(super) fn beginning(path: &Path, length: u64) -> Result<(Vec<u8>, bool)> {
    let metadata = path.metadata().map_err(Error::read(path))?;
    if !metadata.is_file() {
        return Err(Error::scene(path, None, "it is not a file"));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(Error::read(path))?;
    file.take(length).read_to_end(&mut bytes).map_err(Error::read(path))?;
    if !bytes.starts_with(&GZIP) {
        return Ok((bytes, false));
    }
    let mut content = Vec::new();
    let file = File::open(path).map_err(Error::read(path))?;
    MultiGzDecoder::new(file).take(length).read_to_end(&mut content).map_err(Error::read(path))?;
    Ok((content, true))
}
