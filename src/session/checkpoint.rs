//! Checkpoint files: everything that is needed to go on with a render as if it had never stopped.
//!
//! Layout of the file; all numbers are little-endian:
//!
//! | bytes  | content                                                                                       |
//! |--------|-----------------------------------------------------------------------------------------------|
//! | 8      | [`MAGIC`]                                                                                     |
//! | 8      | length of the header                                                                          |
//! | 16     | XXH3-128 of the header                                                                        |
//! | header | JSON: version, scene, settings, device, record, and length and hash of each part           |
//! | rest   | the parts, one after the other                                                                |
//!
//! The file is written whole or not at all. Hashes detect every altered byte. A file of another version is refused, because
//! another version may render other bits.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use crate::files::write_whole;
use crate::film::ranges::SampleRanges;
use crate::renderer::{RenderState, StatePart};
use crate::scene::LoadOptions;
use crate::session::files::PictureFiles;
use crate::session::history::History;
use crate::session::length::Length;
use crate::settings::Settings;
use crate::{Error, Result, inputs};

/// First bytes of a checkpoint. They contain line breaks, which a transfer as text would change.
pub const MAGIC: [u8; 8] = *b"LDSTR\r\n\x1a";
/// Number of bytes before the header: its magic, length and hash.
const PREFIX_BYTES: u64 = 32;
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// State of a render that can be resumed.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// File and fingerprint of the scene.
    pub scene: SceneSource,
    /// The settings.
    pub settings: Settings,
    /// Device and driver on which the render began. The arithmetic of another device may differ in the last bit.
    pub device: String,
    /// Length, files and steps of the render.
    pub record: Record,
    /// Device memory that holds the film and the guide.
    pub state: RenderState,
}

/// Everything that a session remembers of a render, apart from the device's memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Limits of the render.
    pub length: Length,
    /// Files of the picture.
    pub outputs: PictureFiles,
    /// Files that stand in for built-in kernels, with their hashes.
    pub kernels: Vec<String>,
    /// The steps so far.
    pub history: History,
    /// Samples of earlier renders that the guide has learned from.
    pub guide_samples: SampleRanges,
}

/// The file of a scene and the scene's fingerprint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSource {
    /// Absolute path of the file.
    pub path: String,
    /// Choices with which it is read. Paths in them are absolute.
    pub options: LoadOptions,
    /// Fingerprint of the scene, from [`crate::scene::fingerprint()`].
    pub hash: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    version: String,
    scene: SceneSource,
    settings: Settings,
    device: String,
    record: Record,
    samples_done: u32,
    parts: Vec<PartEntry>,
}

/// Fields that the header of every version has.
#[derive(Deserialize)]
struct AnyHeader {
    version: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PartEntry {
    name: String,
    bytes: u64,
    /// XXH3-128 of the part's bytes, in hexadecimal.
    hash: String,
}

impl Checkpoint {
    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// [`Error::Write`]. An older file then stays as it was.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_whole(path, |writer| self.write_to(writer))
    }

    fn write_to(&self, writer: &mut BufWriter<File>) -> io::Result<()> {
        let header = serde_json::to_vec(&self.header())?;
        writer.write_all(&MAGIC)?;
        writer.write_all(&(header.len() as u64).to_le_bytes())?;
        writer.write_all(&xxh3_128(&header).to_le_bytes())?;
        writer.write_all(&header)?;
        self.state.parts.iter().try_for_each(|part| writer.write_all(&part.bytes))
    }

    fn header(&self) -> Header {
        let entry = |part: &StatePart| PartEntry {
            name: part.name.clone(),
            bytes: part.bytes.len() as u64,
            hash: hash_text(&part.bytes),
        };
        Header {
            version: VERSION.into(),
            scene: self.scene.clone(),
            settings: self.settings.clone(),
            device: self.device.clone(),
            record: self.record.clone(),
            samples_done: self.state.samples_done,
            parts: self.state.parts.iter().map(entry).collect(),
        }
    }

    /// Reads a checkpoint of this version.
    ///
    /// # Errors
    /// [`Error::Read`], or [`Error::Checkpoint`] if the file is no checkpoint, is of another version, was cut short or was
    /// altered.
    pub fn read(path: &Path) -> Result<Self> {
        let mut reader = Reader::open(path)?;
        let Header { scene, settings, device, record, samples_done, parts, .. } = reader.header()?;
        settings.validate().map_err(|error| Error::checkpoint(path, error.to_string()))?;
        reader.check_length(&parts)?;
        let parts = parts.into_iter().map(|entry| reader.part(entry)).collect::<Result<_>>()?;
        Ok(Self { scene, settings, device, record, state: RenderState { samples_done, parts } })
    }
}

/// Reader of a checkpoint file, which knows how many bytes are left.
struct Reader<'a> {
    path: &'a Path,
    file: BufReader<File>,
    bytes_left: u64,
}

impl<'a> Reader<'a> {
    fn open(path: &'a Path) -> Result<Self> {
        let (file, bytes_left) = inputs::open(path)?;
        Ok(Self { path, file: BufReader::new(file), bytes_left })
    }

    fn header(&mut self) -> Result<Header> {
        let prefix = self.take(PREFIX_BYTES.min(self.bytes_left))?;
        if prefix.len() as u64 != PREFIX_BYTES || !prefix.starts_with(&MAGIC) {
            return Err(Error::checkpoint(self.path, "it is no checkpoint; give one that lodestar has written"));
        }
        let [length, hash] = [&prefix[8..16], &prefix[16..]];
        let length = length.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte));
        let header = self.take(length)?;
        if xxh3_128(&header).to_le_bytes() != *hash {
            return Err(self.damaged());
        }
        let unreadable = |error| Error::checkpoint(self.path, format!("its header cannot be read ({error})"));
        let AnyHeader { version } = serde_json::from_slice(&header).map_err(unreadable)?;
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
        serde_json::from_slice(&header).map_err(unknown)
    }

    fn check_length(&self, parts: &[PartEntry]) -> Result<()> {
        let bytes = parts.iter().fold(0u64, |sum, part| sum.saturating_add(part.bytes));
        if bytes == self.bytes_left { Ok(()) } else { Err(self.damaged()) }
    }

    fn part(&mut self, entry: PartEntry) -> Result<StatePart> {
        let bytes = self.take(entry.bytes)?;
        if hash_text(&bytes) == entry.hash { Ok(StatePart { name: entry.name, bytes }) } else { Err(self.damaged()) }
    }

    /// The next `count` bytes. Memory is allocated only if the file has that many bytes left.
    fn take(&mut self, count: u64) -> Result<Vec<u8>> {
        self.bytes_left = self.bytes_left.checked_sub(count).ok_or_else(|| self.damaged())?;
        let mut bytes = vec![0; count as usize];
        self.file.read_exact(&mut bytes).map_err(Error::read(self.path))?;
        Ok(bytes)
    }

    fn damaged(&self) -> Error {
        Error::checkpoint(self.path, "it was cut short or altered after it was written; go on from another copy")
    }
}

fn hash_text(bytes: &[u8]) -> String {
    format!("{:032x}", xxh3_128(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    use crate::scene::load;

    fn example() -> Checkpoint {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/furnace/scene.xml");
        let scene = load(&path, &LoadOptions::default()).expect("a scene");
        let defines = vec![("albedo".into(), "0.5".into())];
        let options = LoadOptions { defines, ..LoadOptions::default() };
        let part = |name: &str, bytes: &[u8]| StatePart { name: name.into(), bytes: bytes.to_vec() };
        let length = Length { spp: None, seconds: Some(1.0 / 3.0) };
        let history = History { seconds: 5e-324, paths: u64::MAX, ..History::default() };
        Checkpoint {
            scene: SceneSource { path: "/scenes/küche.xml".into(), options, hash: "00ff".into() },
            settings: Settings::for_scene(&scene),
            device: "a device".into(),
            record: Record {
                length,
                outputs: PictureFiles::none(),
                kernels: vec!["a".into()],
                history,
                guide_samples: "7:0..64".parse().unwrap(),
            },
            state: RenderState {
                samples_done: 7,
                parts: vec![part("a", &[1, 2, 3, 4]), part("b", &[]), part("c", &[5])],
            },
        }
    }

    fn written() -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ckpt");
        example().write(&path).unwrap();
        (folder, path)
    }

    #[test]
    fn what_is_written_comes_back() {
        let (_folder, path) = written();
        assert_eq!(Checkpoint::read(&path).unwrap(), example());
    }

    /// Writes `bytes` to the file, checks that reading them fails in one sentence that names the file, and returns the sentence.
    fn refused(path: &Path, bytes: &[u8]) -> String {
        fs::write(path, bytes).unwrap();
        let error = Checkpoint::read(path).unwrap_err();
        assert!(matches!(error, Error::Checkpoint { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains("a.ckpt: ") && !text.contains('\n'), "{text}");
        text
    }

    #[test]
    fn no_cut_goes_unnoticed() {
        let (_folder, path) = written();
        let whole = fs::read(&path).unwrap();
        for length in 0..whole.len() {
            refused(&path, &whole[..length]);
        }
        refused(&path, &[&whole[..], &[0]].concat());
    }

    #[test]
    fn no_altered_byte_goes_unnoticed() {
        let (_folder, path) = written();
        let whole = fs::read(&path).unwrap();
        for position in 0..whole.len() {
            for mask in [1, 0x80] {
                let mut bytes = whole.clone();
                bytes[position] ^= mask;
                refused(&path, &bytes);
            }
        }
    }

    #[test]
    fn settings_of_another_build_are_refused_in_one_sentence() {
        let (_folder, path) = written();
        let header = format!(r#"{{"version":"{VERSION}","settings":{{"candidates":2}}}}"#);
        let mut bytes = MAGIC.to_vec();
        bytes.extend((header.len() as u64).to_le_bytes());
        bytes.extend(xxh3_128(header.as_bytes()).to_le_bytes());
        bytes.extend(header.as_bytes());
        let text = refused(&path, &bytes);
        assert!(text.contains("another build has written it") && !text.contains("column"), "{text}");
    }

    #[test]
    fn another_version_is_named_whatever_its_header_holds() {
        let (_folder, path) = written();
        let header = br#"{"version":"9.8.7","anything":[]}"#;
        let mut bytes = MAGIC.to_vec();
        bytes.extend((header.len() as u64).to_le_bytes());
        bytes.extend(xxh3_128(header).to_le_bytes());
        bytes.extend(header);
        let text = refused(&path, &bytes);
        assert!(text.contains("version 9.8.7") && text.contains(VERSION), "{text}");
    }

    #[test]
    fn what_is_no_checkpoint_is_told_so() {
        let (_folder, path) = written();
        assert!(refused(&path, b"<scene version=\"3.0.0\"></scene>        ").contains("no checkpoint"));
        let folder = Checkpoint::read(path.parent().unwrap()).unwrap_err().to_string();
        assert!(folder.contains("not a regular file"), "{folder}");
        assert!(matches!(Checkpoint::read(Path::new("/missing")), Err(Error::Read { .. })));
    }
}
