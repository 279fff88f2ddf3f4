//! Checkpoints and pictures with arbitrary content, read back or merged, give a result or an error, never a panic.

use std::path::Path;

use lodestar::film::Picture;
use lodestar::film::merge::{PartialPicture, merge};
use lodestar::film::ranges::SampleRanges;
use lodestar::film::{read_picture, write_picture};
use lodestar::image::exr::{read_attributes, read_layer, read_rgb};
use lodestar::renderer::{RenderState, StatePart};
use lodestar::scene::LoadOptions;
use lodestar::session::checkpoint::{Checkpoint, MAGIC, Record, SceneSource};
use lodestar::session::{History, Length, PictureFiles};
use lodestar::settings::Settings;
use proptest::prelude::*;
use xxhash_rust::xxh3::xxh3_128;

use crate::fuzz::{fuzz, mangled};
use crate::{Folder, load_body};

/// Number of bytes before the header: a magic number, the header's length and its hash.
const PREFIX_BYTES: usize = 32;

fn checkpoint_file() -> Vec<u8> {
    let scene = load_body("").unwrap();
    let part = |name: &str, bytes: &[u8]| StatePart { name: name.into(), bytes: bytes.to_vec() };
    let length = Length { spp: Some(8), seconds: None };
    let history = History { seconds: 0.5, paths: 8, ..History::default() };
    let options = LoadOptions { defines: vec![("a".into(), "1".into())], ..LoadOptions::default() };
    let checkpoint = Checkpoint {
        scene: SceneSource { path: "/a.xml".into(), options, hash: "00ff".into(), world_hash: "00fe".into() },
        settings: Settings { width: 1, height: 1, ..Settings::for_scene(&scene) },
        device: "a device".into(),
        record: Record {
            length,
            outputs: PictureFiles::none(),
            kernels: Vec::new(),
            history,
            guide_samples: SampleRanges::default(),
        },
        state: RenderState { samples_done: 8, parts: vec![part("a", &[1, 2, 3]), part("b", &[4; 64])] },
    };
    let folder = Folder::new(&[]);
    checkpoint.write(&folder.path("a.ckpt")).unwrap();
    std::fs::read(folder.path("a.ckpt")).unwrap()
}

/// Picture file of two by two pixels, with samples from index `first` on.
fn picture_file(first: u32) -> Vec<u8> {
    let mut picture = Picture::empty(2, 2, [0, 0], [2, 2]);
    picture.sample_count.fill(8);
    picture.radiance.fill([0.25, 0.5, 1.0]);
    let text = |name: &str, value: String| (name.to_owned(), value);
    let attributes = [text("sample_ranges", format!("1:{first}..{}", first + 8)), text("spp", "8".into())];
    let folder = Folder::new(&[]);
    write_picture(&folder.path("a.exr"), &picture, &attributes).unwrap();
    std::fs::read(folder.path("a.exr")).unwrap()
}

fn read_checkpoint(bytes: &[u8]) -> lodestar::Result<Checkpoint> {
    let folder = Folder::new(&[]);
    folder.write("a.ckpt", bytes);
    Checkpoint::read(&folder.path("a.ckpt"))
}

fn read_part(path: &Path) -> lodestar::Result<PartialPicture> {
    let (picture, attributes) = read_picture(path)?;
    Ok(PartialPicture { path: path.into(), picture, attributes })
}

#[test]
fn checkpoints() {
    fuzz(mangled(checkpoint_file()), |bytes| {
        if let Ok(checkpoint) = read_checkpoint(&bytes) {
            prop_assert_eq!(checkpoint.state.samples_done, 8);
        }
        Ok(())
    });
}

/// Headers are mangled before their hash is taken: most faults after that are found by the hash.
#[test]
fn checkpoints_with_headers_of_any_kind() {
    let file = checkpoint_file();
    let length = u64::from_le_bytes(file[8..16].try_into().unwrap()) as usize;
    let (header, parts) = file[PREFIX_BYTES..].split_at(length);
    let (header, parts) = (header.to_vec(), parts.to_vec());
    let files = mangled(header).prop_map(move |header| {
        let [length, hash] = [(header.len() as u64).to_le_bytes().to_vec(), xxh3_128(&header).to_le_bytes().to_vec()];
        [&MAGIC[..], &length, &hash, &header, &parts].concat()
    });
    fuzz(files, |bytes| {
        drop(read_checkpoint(&bytes));
        Ok(())
    });
}

#[test]
fn pictures_that_are_read_back_and_merged() {
    let other = Folder::new(&[]);
    other.write("b.exr", &picture_file(8));
    let other = read_part(&other.path("b.exr")).unwrap();
    fuzz(mangled(picture_file(0)), |bytes| {
        let folder = Folder::new(&[]);
        let path = folder.path("a.exr");
        folder.write("a.exr", &bytes);
        drop((read_rgb(&path), read_layer(&path, "variance"), read_attributes(&path)));
        if let Ok(part) = read_part(&path) {
            let (width, height) = (part.picture.width as usize, part.picture.height as usize);
            prop_assert_eq!(part.picture.radiance.len(), width * height);
            drop(merge(&[part, other.clone()]));
        }
        Ok(())
    });
}

/// Corpus in `tests/corpus`: a small file for each reader, and for each fault that was found. Files whose name begins
/// with `ok` are read. All others are refused with one sentence.
#[test]
fn the_corpus() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for file in &files {
        let name = file.file_name().unwrap().to_str().unwrap();
        let bytes = std::fs::read(file).unwrap();
        let outcome = read_by_name(name, &bytes).map_err(|error| error.to_string());
        assert_eq!(outcome.is_ok(), name.starts_with("ok"), "{name}: {outcome:?}");
        assert!(outcome.is_ok() || !outcome.unwrap_err().contains('\n'), "{name}");
    }
    assert!(files.len() >= 12, "{files:?}");
}

fn read_by_name(name: &str, bytes: &[u8]) -> lodestar::Result<()> {
    let folder = Folder::new(&[]);
    folder.write(name, bytes);
    let path = folder.path(name);
    let shape = |plugin: &str| {
        let body = format!(r#"<shape type="{plugin}"><string name="filename" value="{name}"/></shape>"#);
        folder.write("scene.xml", crate::with_sensor(&body).as_bytes());
        folder.load(&[]).map(drop)
    };
    match path.extension().and_then(|extension| extension.to_str()).unwrap() {
        "xml" => {
            folder.write("scene.xml", bytes);
            folder.load(&[]).map(drop)
        }
        "obj" => shape("obj"),
        "ply" => shape("ply"),
        "serialized" => shape("serialized"),
        "ckpt" => Checkpoint::read(&path).map(drop),
        "exr" => read_picture(&path).map(drop),
        other => panic!("no reader for .{other}"),
    }
}

#[test]
fn the_unmangled_files_are_fine() {
    assert_eq!(read_checkpoint(&checkpoint_file()).unwrap().record.history.seconds, 0.5);
    let folder = Folder::new(&[]);
    let parts = [0, 8].map(|first| {
        let name = format!("{first}.exr");
        folder.write(&name, &picture_file(first));
        read_part(&folder.path(&name)).unwrap()
    });
    assert_eq!(merge(&parts).unwrap().0.sample_count, [16; 4]);
}
