//! Checkpoint files: everything that is needed to go on with a render as if it had never stopped.
//!
//! The file has a header and parts (`sealed.rs`): the header names version, scene, settings, device and record, and the parts are the
//! state. A file of another version is refused, because another version may render other bits. `saved.rs` reads the file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::film::ranges::SampleRanges;
use crate::renderer::RenderState;
use crate::scene::LoadOptions;
use crate::session::files::PictureFiles;
use crate::session::history::History;
use crate::session::length::Length;
use crate::session::sealed::{Kind, PartEntry, VERSION};
use crate::settings::Settings;

/// First bytes of a checkpoint.
pub const MAGIC: [u8; 8] = *b"LDSTR\r\n\x1a";

/// Files of checkpoints.
pub(super) const CHECKPOINT: Kind = Kind {
    magic: MAGIC,
    refusal: "it is no checkpoint; give one that lodestar has written",
    of_other_version: "may render other bits; resume it with version {version}",
    of_other_build: "go on with that build",
    of_damage: "go on from another copy",
};

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
    /// Fingerprint of the scene without its camera and film, from [`crate::scene::fingerprint::fingerprints()`].
    pub world_hash: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Header {
    pub version: String,
    pub scene: SceneSource,
    pub settings: Settings,
    pub device: String,
    pub record: Record,
    pub samples_done: u32,
    pub parts: Vec<PartEntry>,
}

impl Checkpoint {
    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// [`Error::Write`]. An older file then stays as it was.
    pub fn write(&self, path: &Path) -> Result<()> {
        CHECKPOINT.write(path, &self.header(), &self.state.parts)
    }

    fn header(&self) -> Header {
        Header {
            version: VERSION.into(),
            scene: self.scene.clone(),
            settings: self.settings.clone(),
            device: self.device.clone(),
            record: self.record.clone(),
            samples_done: self.state.samples_done,
            parts: self.state.parts.iter().map(PartEntry::from).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};

    use xxhash_rust::xxh3::xxh3_128;

    use crate::Error;
    use crate::renderer::StatePart;
    use crate::scene::load;
    use crate::session::sealed::PREFIX_BYTES;

    fn example() -> Checkpoint {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/furnace/scene.xml");
        let scene = load(&path, &LoadOptions::default()).expect("a scene");
        let defines = vec![("albedo".into(), "0.5".into())];
        let options = LoadOptions { defines, ..LoadOptions::default() };
        let part = |name: &str, bytes: &[u8]| StatePart { name: name.into(), bytes: bytes.to_vec() };
        let settings = Settings { width: 1, height: 1, crop: None, ..Settings::for_scene(&scene) };
        let length = Length { spp: None, seconds: Some(1.0 / 3.0) };
        let history = History { seconds: 5e-324, paths: u64::MAX, ..History::default() };
        Checkpoint {
            scene: SceneSource {
                path: "/scenes/küche.xml".into(),
                options,
                hash: "00ff".into(),
                world_hash: "00fe".into(),
            },
            settings,
            device: "a device".into(),
            record: Record {
                length,
                outputs: PictureFiles::none(),
                kernels: vec!["a".into()],
                history,
                guide_samples: "7:0..64".parse().unwrap(),
            },
            state: RenderState { samples_done: 7, parts: vec![part("a", &[4; 63]), part("b", &[]), part("c", &[5])] },
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
        for length in 1..whole.len() {
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

    /// Bytes of a checkpoint with this header and these parts, whose hashes are right.
    fn with_header(header: &[u8], parts: &[u8]) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend((header.len() as u64).to_le_bytes());
        bytes.extend(xxh3_128(header).to_le_bytes());
        bytes.extend(header);
        bytes.extend(parts);
        bytes
    }

    #[test]
    fn settings_of_another_build_are_refused_in_one_sentence() {
        let (_folder, path) = written();
        let header = format!(r#"{{"version":"{VERSION}","settings":{{"candidates":2}}}}"#);
        let text = refused(&path, &with_header(header.as_bytes(), &[]));
        assert!(text.contains("another build has written it") && !text.contains("column"), "{text}");
    }

    #[test]
    fn another_version_is_named_whatever_its_header_holds() {
        let (_folder, path) = written();
        let text = refused(&path, &with_header(br#"{"version":"9.8.7","anything":[]}"#, &[]));
        assert!(text.contains("version 9.8.7") && text.contains(VERSION), "{text}");
        let text = refused(&path, &with_header(br#"{"version":"9\u001b[2J"}"#, &[]));
        assert!(text.contains("header cannot be read") && !text.contains('\u{1b}'), "{text}");
    }

    /// A change of the example, and a word of the sentence that refuses it.
    type Forged = (fn(&mut Header), &'static str);

    /// Values under a right hash are still checked.
    #[test]
    fn forged_values_are_refused() {
        let forged: [Forged; 11] = [
            (|header| header.settings.width = 1 << 14, "64 bytes per pixel"),
            (
                |header| header.settings.crop = Some(crate::scene::Crop { x: 1, y: 0, width: 1, height: 1 }),
                "crop window",
            ),
            (|header| header.parts[0].bytes = u64::MAX, "cut short or altered"),
            (|header| header.parts[0].bytes += 1, "cut short or altered"),
            (|header| header.parts[0].bytes -= 1, "cut short or altered"),
            (|header| header.parts[0].hash.clear(), "cut short or altered"),
            (|header| header.device = "a\u{1b}[2Jdevice".into(), "control characters"),
            (|header| header.record.kernels.push("\n".into()), "control characters"),
            (|header| (header.samples_done, header.settings.sample_offset) = (2, Some(u32::MAX)), "sample numbers"),
            (|header| header.record.history.seconds = -1.0, "negative"),
            (|header| header.record.length.seconds = Some(-1.0), "negative"),
        ];
        let (_folder, path) = written();
        let parts = [&[4; 63][..], &[5]].concat();
        let bytes = |change: fn(&mut Header)| {
            let mut header = example().header();
            change(&mut header);
            with_header(&serde_json::to_vec(&header).unwrap(), &parts)
        };
        for (change, word) in forged {
            let text = refused(&path, &bytes(change));
            assert!(text.contains(word), "{text}");
        }
        let text = serde_json::to_string(&example().header()).unwrap();
        let (range, forged) =
            (r#""samples":{"start":0,"end":64}"#, r#""samples":{"start":0,"end":18446744073709551615}"#);
        assert!(text.contains(range), "{text}");
        let sentence = refused(&path, &with_header(text.replace(range, forged).as_bytes(), &parts));
        assert!(sentence.contains("sample numbers"), "{sentence}");
        fs::write(&path, bytes(|_| {})).unwrap();
        assert_eq!(Checkpoint::read(&path).unwrap(), example());
    }

    /// A file may announce more than the memory holds, and a disk may hold such a file in no space.
    #[test]
    fn memory_is_not_taken_for_what_does_not_fit() {
        let (_folder, path) = written();
        let huge = 1 << 40;
        let sparse = |prefix: &[u8]| {
            fs::write(&path, prefix).unwrap();
            File::options().write(true).open(&path).unwrap().set_len(huge).unwrap();
        };
        // A header of a terabyte is not read into memory; its first byte that is no JSON ends it.
        let mut prefix = MAGIC.to_vec();
        prefix.extend((huge - PREFIX_BYTES).to_le_bytes());
        sparse(&prefix);
        let mut header = example().header();
        header.parts[0].bytes = huge;
        let bytes = with_header(&serde_json::to_vec(&header).unwrap(), &[]);
        assert!(Checkpoint::read(&path).is_err());
        sparse(&bytes);
        assert!(Checkpoint::read(&path).unwrap_err().to_string().contains("cut short"));
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
