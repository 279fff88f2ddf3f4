//! Files of a model: its JSON, its buffers and its images, all within the memory that they need.

use std::path::Path;
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::Document;

use crate::{Error, Result};

/// Largest file in bytes, of the model itself or of a buffer.
const MAX_FILE_BYTES: u64 = 2 << 30;

/// Extensions that are read. A model that requires another is refused.
const SUPPORTED: [&str; 13] = [
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_materials_variants",
];

/// Model with its buffers.
pub(super) struct Model<'a> {
    pub path: &'a Path,
    pub document: Document,
    pub buffers: Vec<Vec<u8>>,
}

impl<'a> Model<'a> {
    /// Reads the file at `path` and its buffers.
    pub fn read(path: &'a Path) -> Result<Self> {
        let bytes = bytes_of(path, path)?;
        let parsed = gltf::Gltf::from_slice_without_validation(&bytes).map_err(|error| malformed(path, &error))?;
        let mut blob = parsed.blob;
        let mut root = parsed.document.into_json();
        for name in std::mem::take(&mut root.extensions_required) {
            if !SUPPORTED.contains(&name.as_str()) {
                let message = format!("the model requires the extension {name}, which is not supported; {}", remedy(&name));
                return Err(Error::scene(path, None, message));
            }
        }
        let document = Document::from_json(root).map_err(|error| malformed(path, &error))?;
        let mut model = Self { path, document, buffers: Vec::new() };
        let mut buffers = Vec::new();
        for buffer in &model.document.as_json().buffers {
            let index = buffers.len();
            let content = match &buffer.uri {
                Some(uri) => model.uri(uri, &format!("buffer {index}"))?,
                None => blob.take().ok_or_else(|| model.error(&format!("buffer {index}"), "it has no content"))?,
            };
            if (content.len() as u64) < buffer.byte_length.0 {
                let message = format!("it has {} bytes, but should have {}", content.len(), buffer.byte_length.0);
                return Err(model.error(&format!("buffer {index}"), message));
            }
            buffers.push(content);
        }
        model.buffers = buffers;
        Ok(model)
    }

    /// Error about a thing of the model.
    pub fn error(&self, what: &str, message: impl std::fmt::Display) -> Error {
        Error::scene(self.path, None, format!("{what}: {message}"))
    }

    /// Name of the model in names of files in memory.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Content of a URI: data, or a file relative to the model.
    fn uri(&self, uri: &str, what: &str) -> Result<Vec<u8>> {
        if let Some(data) = uri.strip_prefix("data:") {
            let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
            let encoded = encoded.ok_or_else(|| self.error(what, "its data URI is not in base64"))?;
            return STANDARD.decode(encoded).map_err(|_| self.error(what, "its data URI is no base64"));
        }
        if uri.contains("://") {
            return Err(self.error(what, format!("`{uri}` is an address; only files beside the model are read")));
        }
        let file = self.path.parent().unwrap_or(Path::new("")).join(decoded(uri));
        bytes_of(&file, self.path).map_err(|error| self.error(what, error))
    }

    /// Encoded bytes of an image.
    pub fn image(&self, index: usize, what: &str) -> Result<Arc<[u8]>> {
        let image = self.document.as_json().images.get(index);
        let image = image.ok_or_else(|| self.error(what, format!("there is no image {index}")))?;
        if let Some(uri) = &image.uri {
            return self.uri(uri, what).map(Arc::from);
        }
        let view = image.buffer_view.and_then(|view| self.document.views().nth(view.value()));
        let view = view.ok_or_else(|| self.error(what, format!("image {index} has no content")))?;
        let (start, length) = (view.offset(), view.length());
        let bytes = self.buffers.get(view.buffer().index()).and_then(|all| all.get(start..start.checked_add(length)?));
        bytes.map(Arc::from).ok_or_else(|| self.error(what, format!("image {index} reaches beyond its buffer")))
    }
}

fn malformed(path: &Path, error: &gltf::Error) -> Error {
    let text = match error {
        gltf::Error::Validation(faults) => {
            let of = |(place, fault): &(gltf::json::Path, gltf::json::validation::Error)| format!("{place}: {fault}");
            faults.iter().take(3).map(of).collect::<Vec<_>>().join("; ")
        }
        other => other.to_string(),
    };
    Error::scene(path, None, format!("malformed glTF: {}", text.replace('\n', " ")))
}

/// Sentence about what to do where an extension is required.
fn remedy(name: &str) -> &'static str {
    match name {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export it without compression of meshes"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" => "export its images as PNG or JPEG",
        _ => "export it without",
    }
}

/// Content of the file at `path`, which `model` names.
fn bytes_of(path: &Path, model: &Path) -> Result<Vec<u8>> {
    let size = path.metadata().map_err(Error::read(path))?.len();
    if size > MAX_FILE_BYTES {
        let message = format!("the file {} of {size} bytes is refused; the limit is {MAX_FILE_BYTES}", path.display());
        return Err(Error::scene(model, None, message));
    }
    std::fs::read(path).map_err(Error::read(path))
}

/// Text with `%20` and the like decoded.
fn decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let (mut result, mut at) = (Vec::with_capacity(bytes.len()), 0);
    while at < bytes.len() {
        let hex = bytes.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        let value = hex.and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        result.push(value.unwrap_or(bytes[at]));
        at += if value.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&result).into_owned()
}
