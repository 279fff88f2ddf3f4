//! Views that `EXT_meshopt_compression` or `KHR_meshopt_compression` compresses.

use std::collections::HashSet;

use serde_json::{Map, Value as Json, json};

use super::filters::Filter;
use super::made::{MESHOPT, Made, entry, whole};
use super::{indices, vertices};
use crate::quoted;

/// Extension of a view or of a buffer.
fn extension(object: &Json) -> Option<&Json> {
    let extensions = object.get("extensions")?;
    MESHOPT.iter().find_map(|name| extensions.get(name))
}

/// Indices of buffers without content, whose place is taken by what is decoded: those that are marked, and those without a URI of which
/// every view is compressed.
pub fn placeholders(json: &Json) -> HashSet<usize> {
    let list = |name: &str| json.get(name).and_then(Json::as_array).map_or(&[][..], Vec::as_slice);
    let buffer_of = |view: &Json| whole(view, "buffer");
    let compressed: HashSet<_> =
        list("bufferViews").iter().filter(|view| extension(view).is_some()).filter_map(buffer_of).collect();
    let plain = list("bufferViews").iter().filter(|view| extension(view).is_none()).filter_map(buffer_of);
    let sources = list("bufferViews").iter().filter_map(extension).filter_map(buffer_of);
    let read: HashSet<_> = plain.chain(sources).collect();
    let buffers = list("buffers").iter().enumerate();
    let is_placeholder = |(index, buffer): &(usize, &Json)| {
        let is_marked = extension(buffer).and_then(|extension| extension.get("fallback")?.as_bool()).unwrap_or(false);
        is_marked || (buffer.get("uri").is_none() && compressed.contains(index) && !read.contains(index))
    };
    buffers.filter(is_placeholder).map(|(index, _)| index).collect()
}

/// Decodes the compressed views.
pub(super) fn decode(root: &mut Map<String, Json>, made: &mut Made) -> Result<(), String> {
    let count = root.get("bufferViews").and_then(Json::as_array).map_or(0, Vec::len);
    for index in 0..count {
        let Some(source) = entry(root, "bufferViews", index).and_then(|view| extension(view).cloned()) else {
            continue;
        };
        let bytes = elements(&source, made).map_err(|message| format!("buffer view {index}: {message}"))?;
        let length = bytes.len();
        let buffer = made.add(root, bytes)?;
        if let Some(view) = entry(root, "bufferViews", index).and_then(Json::as_object_mut) {
            view.insert("buffer".to_owned(), json!(buffer));
            view.insert("byteOffset".to_owned(), json!(0));
            view.insert("byteLength".to_owned(), json!(length));
        }
    }
    Ok(())
}

/// Elements of a compressed view.
fn elements(source: &Json, made: &mut Made) -> Result<Vec<u8>, String> {
    let field = |name: &str| whole(source, name).ok_or_else(|| format!("its meshopt compression gives no `{name}`"));
    let (buffer, length, stride, count) =
        (field("buffer")?, field("byteLength")?, field("byteStride")?, field("count")?);
    let text = |name: &str| source.get(name).and_then(Json::as_str);
    let mode = text("mode").unwrap_or_default();
    let fits = match mode {
        "ATTRIBUTES" => stride.is_multiple_of(4) && (4..=256).contains(&stride),
        "TRIANGLES" => matches!(stride, 2 | 4) && count.is_multiple_of(3),
        "INDICES" => matches!(stride, 2 | 4),
        other => {
            return Err(format!("its meshopt compression has the mode {}, which is not read", quoted::word(other)));
        }
    };
    if !fits {
        return Err(format!(
            "its meshopt compression has {count} elements of {stride} bytes, which the mode {mode} cannot have"
        ));
    }
    let name = text("filter").unwrap_or("NONE");
    let filter = Filter::of(name, stride).filter(|filter| mode == "ATTRIBUTES" || *filter == Filter::None);
    let filter = filter.ok_or_else(|| {
        let name = quoted::word(name);
        format!("its meshopt compression has the filter {name}, which elements of {stride} bytes in the mode {mode} cannot have")
    })?;
    made.take(count.checked_mul(stride).ok_or_else(|| made.too_much())?)?;
    let offset = whole(source, "byteOffset").unwrap_or(0);
    let bytes = made.part(buffer, offset, length);
    let bytes = bytes.ok_or("its compressed data reach beyond their buffer: is the file cut short?")?;
    let decoded = match mode {
        "ATTRIBUTES" => vertices::decode(bytes, count, stride),
        "TRIANGLES" => indices::triangles(bytes, count, stride),
        _ => indices::sequence(bytes, count, stride),
    };
    let mut elements =
        decoded.map_err(|fault| format!("its meshopt data are damaged: {fault}; write the file again"))?;
    filter.apply(&mut elements, stride);
    Ok(elements)
}
