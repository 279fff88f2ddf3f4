//! Valid files in the form that the crate's reader takes.

use serde_json::{Value as Json, json};

/// Most elements of accessors without data, whose elements are zero.
pub(super) const MAX_ZEROS: usize = 1 << 22;

/// A file's JSON in the usual form.
pub(super) struct Usual {
    pub json: Json,
    /// Index of a buffer of zeros, which the file does not have, and its length in bytes.
    pub zeros: Option<(usize, usize)>,
    /// Animations of the file.
    pub animations: Vec<Json>,
}

impl Usual {
    /// The JSON without what changes no picture and confuses the crate: extensions that it must know, `extras` of any type, animations,
    /// and attributes of one's own. Scenes get their list of nodes, and accessors without data a view of zeros.
    ///
    /// # Errors
    /// Where accessors without data are too long.
    pub fn of(mut json: Json) -> Result<Self, String> {
        remove_extras(&mut json);
        let Some(root) = json.as_object_mut() else { return Ok(Self { json, zeros: None, animations: Vec::new() }) };
        root.remove("extensionsRequired");
        let animations = match root.remove("animations") {
            Some(Json::Array(list)) => list,
            _ => Vec::new(),
        };
        for scene in list(root.get_mut("scenes")) {
            if let Some(scene) = scene.as_object_mut() {
                scene.entry("nodes").or_insert_with(|| json!([]));
            }
        }
        for mesh in list(root.get_mut("meshes")) {
            for primitive in list(mesh.get_mut("primitives")) {
                remove_own(primitive.get_mut("attributes"));
                list(primitive.get_mut("targets")).iter_mut().for_each(|target| remove_own(Some(target)));
            }
        }
        let zeros = add_zeros(root)?;
        Ok(Self { json, zeros, animations })
    }
}

/// Elements of a JSON array; none where it is no array.
pub(super) fn list(json: Option<&mut Json>) -> &mut [Json] {
    json.and_then(Json::as_array_mut).map_or(&mut [], Vec::as_mut_slice)
}

/// Removes attributes of one's own, such as `_TEMPERATURE`.
fn remove_own(attributes: Option<&mut Json>) {
    if let Some(attributes) = attributes.and_then(Json::as_object_mut) {
        attributes.retain(|name, _| !name.starts_with('_'));
    }
}

fn remove_extras(json: &mut Json) {
    match json {
        Json::Array(list) => list.iter_mut().for_each(remove_extras),
        Json::Object(entries) => {
            entries.remove("extras");
            entries.values_mut().for_each(remove_extras);
        }
        _ => {}
    }
}

/// Gives accessors without data a view of a buffer of zeros. Returns the buffer's index and length.
fn add_zeros(root: &mut serde_json::Map<String, Json>) -> Result<Option<(usize, usize)>, String> {
    let count = |name: &str| root.get(name).and_then(Json::as_array).map_or(0, Vec::len);
    let (buffer, view) = (count("buffers"), count("bufferViews"));
    let mut length = 0;
    for (index, accessor) in list(root.get_mut("accessors")).iter_mut().enumerate() {
        let Some(accessor) = accessor.as_object_mut() else { continue };
        if accessor.contains_key("bufferView") || accessor.contains_key("sparse") {
            continue;
        }
        let Some(count) = accessor.get("count").and_then(Json::as_u64) else { continue };
        if count > MAX_ZEROS as u64 {
            return Err(format!(
                "accessor {index}: it has {count} elements without a buffer view; no more than {MAX_ZEROS} are read"
            ));
        }
        // The largest element is a matrix of 16 numbers of 4 bytes.
        length = length.max(64 * count as usize);
        accessor.insert("bufferView".to_owned(), json!(view));
    }
    if length == 0 {
        return Ok(None);
    }
    for (name, entry) in [
        ("buffers", json!({"byteLength": length, "uri": "data:,"})),
        ("bufferViews", json!({"buffer": buffer, "byteLength": length})),
    ] {
        if let Some(list) = root.entry(name).or_insert_with(|| json!([])).as_array_mut() {
            list.push(entry);
        }
    }
    Ok(Some((buffer, length)))
}
