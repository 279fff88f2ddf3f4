//! A glTF file with its buffers, and the warnings about it.

use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};

use gltf::Document;
use serde_json::Value as Json;

use super::choices::{Choices, choose_variant, told};
use super::pose::Pose;
use super::usual::Usual;
use super::{buffers, compression};
use crate::scene::text;
use crate::{Error, Result, inputs, quoted};

/// Most elements of all accessors without data, each counted as often as it is used.
const MOST_ZEROS: usize = 1 << 24;

/// First bytes of a `.glb` file.
const MAGIC: &[u8] = b"glTF";

/// Extensions whose content is read, or whose absence changes no picture.
const READ: [&str; 26] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "EXT_texture_webp",
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
    /// Animations of the file.
    pub animations: Vec<Json>,
    /// Pose of the nodes at the moment that is shown.
    pub pose: Pose,
}

impl Asset {
    /// Reads the file and its buffers, with the choices of the user.
    pub fn open(path: &Path, choices: &Choices) -> Result<Self> {
        let bytes = inputs::read(path, buffers::MAX_BYTES)?;
        let error = |error: gltf::Error| Error::scene(path, None, format!("it is no glTF 2.0 file: {}", brief(&error)));
        let (json, blob) = match bytes.starts_with(MAGIC) {
            true => buffers::chunks(path, &bytes)?,
            false => (text::without_mark(&bytes).to_vec(), None),
        };
        let invalid = |error| Error::scene(path, None, format!("it is no glTF 2.0 file: {}", quoted::message(&error)));
        let mut raw: Json = serde_json::from_slice(&json).map_err(invalid)?;
        check_required(path, &raw)?;
        let mut buffers = buffers::read(path, &raw, blob)?;
        let fault = |message| Error::scene(path, None, message);
        compression::decode(&mut raw, &mut buffers).map_err(fault)?;
        let variants = choose_variant(&mut raw, choices.variant.as_deref()).map_err(fault)?;
        let Usual { json, zeros, animations } = Usual::of(raw).map_err(fault)?;
        buffers.extend(zeros.map(|(_, length)| vec![0; length]));
        let root: gltf::json::Root = serde_json::from_value(json).map_err(invalid)?;
        check_attributes(path, &root)?;
        check_images(path, &root)?;
        let document = Document::from_json(root).map_err(error)?;
        let (path, warnings) = (path.to_path_buf(), RefCell::default());
        let (zeros_left, pose) = (Cell::new(MOST_ZEROS), Pose::default());
        let asset = Self { path, document, buffers, zeros, zeros_left, warnings, animations, pose };
        asset.warn_of_extensions();
        if choices.variant.is_none() && !variants.is_empty() {
            let names = told(&variants);
            asset.warn(format!(
                "its materials have the variants {names}; the default is rendered (--variant NAME chooses)"
            ));
        }
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

    /// Content of a data URI, or of the file that a relative URI names.
    pub fn uri(&self, uri: &str) -> Result<Vec<u8>> {
        buffers::content(&self.path, uri)
    }

    fn warn_of_extensions(&self) {
        for name in self.document.extensions_used().filter(|name| !READ.contains(name)) {
            self.warn(format!("the extension {name} is not supported; what it describes is ignored"));
        }
    }
}

/// Refuses files that require what this reader does not know.
fn check_required(path: &Path, raw: &Json) -> Result<()> {
    let required = raw.get("extensionsRequired").and_then(Json::as_array).into_iter().flatten();
    for name in required.filter_map(Json::as_str) {
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
