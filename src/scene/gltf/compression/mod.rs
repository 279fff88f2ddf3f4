//! Compressed buffers, turned into buffers as every file may have them: `EXT_meshopt_compression`, `KHR_meshopt_compression` and
//! `KHR_draco_mesh_compression`.
//!
//! Each decoder makes buffers of its own, and changes the JSON so that views and accessors lead there.

mod draco;
mod filters;
mod indices;
mod made;
mod reader;
mod vertices;
mod views;

pub(super) use views::placeholders;

use made::Made;
use serde_json::Value as Json;

/// Decodes what is compressed, into more `buffers`.
///
/// # Errors
/// Where the compressed data are damaged, or become too large. The message names the place.
pub(super) fn decode(json: &mut Json, buffers: &mut Vec<Vec<u8>>) -> Result<(), String> {
    let Some(root) = json.as_object_mut() else { return Ok(()) };
    let mut made = Made::beside(buffers);
    views::decode(root, &mut made)?;
    draco::decode(root, &mut made)
}
