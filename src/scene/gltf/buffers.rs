//! Buffers of a file: the chunk of a `.glb`, data URIs, and files beside the scene.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value as Json;

use super::compression;
use crate::{Error, Result, inputs, quoted};

/// Largest file in bytes, and largest buffer.
pub(super) const MAX_BYTES: u64 = 4 << 30;

/// Buffers of a file, of which the first without a URI is the binary chunk. Those whose place is taken by decoded data stay empty.
pub(super) fn read(path: &Path, json: &Json, mut chunk: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
    let placeholders = compression::placeholders(json);
    let error = |message: String| Error::scene(path, None, message);
    let read = |(index, buffer): (usize, &Json)| {
        if placeholders.contains(&index) {
            return Ok(Vec::new());
        }
        let bytes = match buffer.get("uri").and_then(Json::as_str) {
            None => chunk.take().ok_or_else(|| error("it lacks its binary part: is it cut short?".to_owned()))?,
            Some(uri) => content(path, uri)?,
        };
        let length = buffer.get("byteLength").and_then(Json::as_u64).unwrap_or(0);
        if (bytes.len() as u64) < length {
            let held = bytes.len();
            return Err(error(format!("buffer {index} has {held} bytes, but should have {length}: is it cut short?")));
        }
        Ok(bytes)
    };
    let buffers = json.get("buffers").and_then(Json::as_array);
    buffers.into_iter().flatten().enumerate().map(read).collect()
}

/// Content of a data URI, or of the file that a relative URI names.
pub(super) fn content(path: &Path, uri: &str) -> Result<Vec<u8>> {
    match data_uri(uri) {
        Some(Ok(bytes)) => Ok(bytes),
        Some(Err(reason)) => Err(Error::scene(path, None, format!("a data URI is damaged: {reason}"))),
        None => {
            let beside = path.parent().unwrap_or(Path::new(".")).join(file_name(path, uri)?);
            inputs::read(&beside, MAX_BYTES)
                .map_err(|error| Error::scene(path, None, format!("a file that it names: {error}")))
        }
    }
}

/// Name of the file that a relative URI names.
pub(super) fn file_name(path: &Path, uri: &str) -> Result<String> {
    if uri.split_once(':').is_some_and(|(scheme, _)| scheme.len() > 1 && !scheme.contains(['/', '.'])) {
        return Err(Error::scene(
            path,
            None,
            format!("the address {} is not read; put the file beside the scene", quoted::word(uri)),
        ));
    }
    percent_decoded(uri)
        .ok_or_else(|| Error::scene(path, None, format!("the address {} is damaged", quoted::word(uri))))
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
pub(super) fn chunks(path: &Path, bytes: &[u8]) -> Result<(Vec<u8>, Option<Vec<u8>>)> {
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
