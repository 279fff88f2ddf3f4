//! A glTF file with its buffers, and the warnings about it.

use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::Document;
use gltf::buffer::Source;
use serde_json::Value as Json;

use super::usual::Usual;
use crate::scene::text;
use crate::{Error, Result, inputs, quoted};

/// Largest file in bytes, and largest buffer.
const MAX_BYTES: u64 = 4 << 30;

/// Most elements of all accessors without data, each counted as often as it is used.
const MOST_ZEROS: usize = 1 << 24;

/// First bytes of a `.glb` file.
const MAGIC: &[u8] = b"glTF";

/// Extensions whose content is read, or whose absence changes no picture.
const READ: [&str; 20] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "EXT_texture_webp",
];

/// Extensions of which a file gives the data in no other form.
const COMPRESSIONS: [(&str, &str); 3] = [
    ("KHR_draco_mesh_compression", "Draco"),
    ("EXT_meshopt_compression", "meshopt"),
    ("KHR_texture_basisu", "Basis Universal"),
];

/// A glTF file with its buffers.
pub(super) struct Asset {
    pub path: PathBuf,
    pub document: Document,
    buffers: Vec<Vec<u8>>,
    /// Index and length of the buffer of zeros, which the file does not have.
    zeros: Option<(usize, usize)>,
    /// Number of elements without data that may still be made.
    zeros_left: Cell<usize>,
    warnings: RefCell<Vec<String>>,
}

impl Asset {
    /// Reads the file and its buffers.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = inputs::read(path, MAX_BYTES)?;
        let error = |error: gltf::Error| Error::scene(path, None, format!("it is no glTF 2.0 file: {}", brief(&error)));
        let (json, blob) = match bytes.starts_with(MAGIC) {
            true => chunks(path, &bytes)?,
            false => (text::without_mark(&bytes).to_vec(), None),
        };
        let invalid = |error| Error::scene(path, None, format!("it is no glTF 2.0 file: {}", quoted::message(&error)));
        let raw: Json = serde_json::from_slice(&json).map_err(invalid)?;
        check_required(path, &raw)?;
        let Usual { json, zeros, is_animated } = Usual::of(raw).map_err(|message| Error::scene(path, None, message))?;
        let root: gltf::json::Root = serde_json::from_value(json).map_err(invalid)?;
        check_attributes(path, &root)?;
        check_images(path, &root)?;
        let document = Document::from_json(root).map_err(error)?;
        let (path, warnings) = (path.to_path_buf(), RefCell::default());
        let mut asset =
            Self { path, document, buffers: Vec::new(), zeros, zeros_left: Cell::new(MOST_ZEROS), warnings };
        asset.warn_of_extensions();
        if is_animated {
            asset.warn("animations are ignored; nodes stand where the file puts them");
        }
        asset.buffers = asset.read_buffers(blob)?;
        Ok(asset)
    }

    /// Bytes of a buffer from `offset` on; `None` where the range leaves the buffer.
    pub fn bytes(&self, buffer: usize, offset: usize, length: usize) -> Option<&[u8]> {
        self.buffers.get(buffer)?.get(offset..offset.checked_add(length)?)
    }

    /// Counts elements of an accessor that have no data. The error says that they are too many.
    pub fn count_zeros(&self, view: Option<&gltf::buffer::View>, count: usize) -> Result<(), String> {
        let is_own = view.is_some_and(|view| self.zeros.is_none_or(|(zeros, _)| zeros != view.buffer().index()));
        let left = if is_own { Some(self.zeros_left.get()) } else { self.zeros_left.get().checked_sub(count) };
        self.zeros_left.set(left.ok_or_else(|| format!("with it more than {MOST_ZEROS} elements have no data"))?);
        Ok(())
    }

    /// Bytes of a part of a buffer.
    pub fn view(&self, view: &gltf::buffer::View) -> Result<&[u8]> {
        self.bytes(view.buffer().index(), view.offset(), view.length()).ok_or_else(|| {
            self.error(format!("the buffer view {} reaches beyond its buffer: is the file cut short?", view.index()))
        })
    }

    /// Error of the whole file.
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::scene(&self.path, None, message)
    }

    /// Keeps a warning, once.
    pub fn warn(&self, message: impl std::fmt::Display) {
        let message = format!("{}: {message}", self.path.display());
        let mut warnings = self.warnings.borrow_mut();
        if !warnings.contains(&message) {
            warnings.push(message);
        }
    }

    /// All warnings.
    pub fn into_warnings(self) -> Vec<String> {
        self.warnings.into_inner()
    }

    fn warn_of_extensions(&self) {
        for name in self.document.extensions_used().filter(|name| !READ.contains(name)) {
            if !COMPRESSIONS.iter().any(|(compression, _)| *compression == name) {
                self.warn(format!("the extension {name} is not supported; what it describes is ignored"));
            }
        }
    }

    fn read_buffers(&self, mut blob: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        let read = |buffer: gltf::Buffer| {
            if let Some((_, length)) = self.zeros.filter(|(zeros, _)| *zeros == buffer.index()) {
                return Ok(vec![0; length]);
            }
            let bytes = match buffer.source() {
                Source::Bin => blob.take().ok_or_else(|| self.error("it lacks its binary part: is it cut short?"))?,
                Source::Uri(uri) => self.uri(uri)?,
            };
            if bytes.len() < buffer.length() {
                let message = format!(
                    "buffer {} has {} bytes, but should have {}: is it cut short?",
                    buffer.index(),
                    bytes.len(),
                    buffer.length()
                );
                return Err(self.error(message));
            }
            Ok(bytes)
        };
        self.document.buffers().map(read).collect()
    }

    /// Content of a data URI, or of the file that a relative URI names.
    pub fn uri(&self, uri: &str) -> Result<Vec<u8>> {
        match data_uri(uri) {
            Some(Ok(bytes)) => Ok(bytes),
            Some(Err(reason)) => Err(self.error(format!("a data URI is damaged: {reason}"))),
            None => {
                let path = self.path.parent().unwrap_or(Path::new(".")).join(self.file_name(uri)?);
                inputs::read(&path, MAX_BYTES).map_err(|error| self.error(format!("a file that it names: {error}")))
            }
        }
    }

    /// Name of the file that a relative URI names.
    pub fn file_name(&self, uri: &str) -> Result<String> {
        if uri.split_once(':').is_some_and(|(scheme, _)| scheme.len() > 1 && !scheme.contains(['/', '.'])) {
            return Err(
                self.error(format!("the address {} is not read; put the file beside the scene", quoted::word(uri)))
            );
        }
        percent_decoded(uri).ok_or_else(|| self.error(format!("the address {} is damaged", quoted::word(uri))))
    }
}

/// Content of a data URI; `None` for any other.
pub(super) fn data_uri(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let content = uri.strip_prefix("data:")?;
    Some(match content.split_once(',') {
        Some((kind, data)) if kind.ends_with(";base64") => match percent_decoded(data) {
            Some(data) => STANDARD.decode(data).map_err(|error| error.to_string()),
            None => Err("a code that begins with % is wrong".to_owned()),
        },
        _ => Err("it has no base64 content".to_owned()),
    })
}

fn percent_decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        if *first == b'%' {
            let code = std::str::from_utf8(tail.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(code, 16).ok()?);
            rest = &tail[2..];
        } else {
            bytes.push(*first);
            rest = tail;
        }
    }
    String::from_utf8(bytes).ok()
}

/// JSON and binary chunk of a `.glb` file.
fn chunks(path: &Path, bytes: &[u8]) -> Result<(Vec<u8>, Option<Vec<u8>>)> {
    // What follows the declared length does not belong to the file.
    let declared = bytes.get(8..12).and_then(|length| Some(u32::from_le_bytes(length.try_into().ok()?) as usize));
    let bytes = declared.and_then(|length| bytes.get(..length)).unwrap_or(bytes);
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    if word(4) != Some(2) {
        return Err(Error::scene(path, None, "it is a .glb file, but not of version 2; save it as glTF 2.0"));
    }
    let (mut json, mut binary, mut at) = (None, None, 12);
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let chunk = bytes.get(at + 8..(at + 8).saturating_add(length as usize));
        let chunk = chunk.ok_or_else(|| Error::scene(path, None, "it ends within a chunk: is it cut short?"))?;
        match &kind.to_le_bytes() {
            // Some writers fill the chunk up with zeros instead of spaces.
            b"JSON" if json.is_none() => {
                let end = chunk.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
                json = Some(chunk[..end].to_vec());
            }
            b"BIN\0" if binary.is_none() => binary = Some(chunk.to_vec()),
            _ => {}
        }
        at += 8 + length as usize;
    }
    let json =
        json.ok_or_else(|| Error::scene(path, None, "it is a .glb file without a JSON chunk: is it cut short?"))?;
    Ok((json, binary))
}

/// Refuses files whose data this reader cannot decode.
fn check_required(path: &Path, raw: &Json) -> Result<()> {
    let required = raw.get("extensionsRequired").and_then(Json::as_array).into_iter().flatten();
    for name in required.filter_map(Json::as_str) {
        if let Some((_, compression)) = COMPRESSIONS.iter().find(|(known, _)| *known == name) {
            let message =
                format!("its data is compressed by {compression} ({name}), which is not read; save it without");
            return Err(Error::scene(path, None, message));
        }
        if !READ.contains(&name) {
            let message = format!("it requires the extension {name}, which is not supported; save it without");
            return Err(Error::scene(path, None, message));
        }
    }
    Ok(())
}

/// Refuses attributes without an accessor, before the crate's validation looks them up.
fn check_attributes(path: &Path, root: &gltf::json::Root) -> Result<()> {
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    match primitives.flat_map(|primitive| primitive.attributes.values()).find(|at| at.value() >= root.accessors.len()) {
        None => Ok(()),
        Some(at) => {
            Err(Error::scene(path, None, format!("it is no glTF 2.0 file: there is no accessor {}", at.value())))
        }
    }
}

/// Refuses images without content or without the type of their content, both of which the crate takes for given.
fn check_images(path: &Path, root: &gltf::json::Root) -> Result<()> {
    let is_whole = |image: &gltf::json::Image| match image.buffer_view {
        Some(_) => image.mime_type.is_some(),
        None => image.uri.is_some(),
    };
    match root.images.iter().position(|image| !is_whole(image)) {
        None => Ok(()),
        Some(at) => {
            let message =
                format!("it is no glTF 2.0 file: image {at} has no `uri`, nor a `bufferView` with a `mimeType`");
            Err(Error::scene(path, None, message))
        }
    }
}

/// The first reason of an error, in one line.
fn brief(error: &gltf::Error) -> String {
    match error {
        gltf::Error::Validation(faults) => match faults.first() {
            Some((path, fault)) => quoted::message(&format!("{path}: {fault}")),
            None => "it is not valid".to_owned(),
        },
        other => quoted::message(other),
    }
}

/// The name with every character that is neither a letter nor a digit replaced by `_`.
pub(super) fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}
