//! Buffers that decoders make, and access to the JSON that leads to them.

use serde_json::{Map, Value as Json, json};

use super::super::usual::list;

/// Names of the extensions that compress views.
pub(super) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
/// Name of the extension that compresses primitives.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// Most bytes of all that is decoded, for each byte of the buffers.
const MOST_BYTES_PER_BYTE: usize = 1024;
/// Bytes that a file of any size may become.
const ALWAYS: usize = 64 << 20;
/// Most bytes of all that is decoded.
const MOST_BYTES: usize = 4 << 30;

/// Buffers that decoders make.
pub(super) struct Made<'a> {
    buffers: &'a mut Vec<Vec<u8>>,
    /// Number of bytes that may still be made.
    pub left: usize,
}

impl<'a> Made<'a> {
    /// No buffers yet. What may be made follows from the bytes of the file's own `buffers`.
    pub fn beside(buffers: &'a mut Vec<Vec<u8>>) -> Self {
        let bytes = buffers.iter().map(Vec::len).fold(0, usize::saturating_add);
        let left = bytes.saturating_mul(MOST_BYTES_PER_BYTE).saturating_add(ALWAYS).min(MOST_BYTES);
        Self { buffers, left }
    }

    /// Takes bytes from those that may be made.
    pub fn take(&mut self, bytes: usize) -> Result<(), String> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| self.too_much())?;
        Ok(())
    }

    /// Sentence that says that the data become too large.
    pub fn too_much(&self) -> String {
        format!(
            "the compressed data become more than {MOST_BYTES_PER_BYTE} times as large as the file, or more than 4 GiB; save the \
             file without compression"
        )
    }

    /// Adds a buffer. Returns its index.
    pub fn add(&mut self, root: &mut Map<String, Json>, bytes: Vec<u8>) -> Result<usize, String> {
        let index = self.buffers.len();
        push(root, "buffers", json!({"byteLength": bytes.len(), "uri": "data:,"}))?;
        self.buffers.push(bytes);
        Ok(index)
    }

    /// Bytes of a part of a buffer.
    pub fn part(&self, buffer: usize, offset: usize, length: usize) -> Option<&[u8]> {
        self.buffers.get(buffer)?.get(offset..offset.checked_add(length)?)
    }
}

/// Adds an entry to a list of the file. Returns its index.
pub(super) fn push(root: &mut Map<String, Json>, name: &str, entry: Json) -> Result<usize, String> {
    let entries = root.entry(name).or_insert_with(|| json!([]));
    let entries = entries.as_array_mut().ok_or_else(|| format!("it is no glTF 2.0 file: `{name}` is no list"))?;
    entries.push(entry);
    Ok(entries.len() - 1)
}

/// A whole number of an object; `None` where it is missing or something else.
pub(super) fn whole(object: &Json, name: &str) -> Option<usize> {
    object.get(name).and_then(Json::as_u64).and_then(|number| usize::try_from(number).ok())
}

/// Entry of a list of the file.
pub(super) fn entry<'a>(root: &'a mut Map<String, Json>, name: &str, index: usize) -> Option<&'a mut Json> {
    list(root.get_mut(name)).get_mut(index)
}
