//! Files of the GLSL.

use std::fs;
use std::path::Path;

/// Path and text of each GLSL file below the folders, which are relative to `root`, in the order of their paths.
pub fn read_all(root: &Path, folders: &[&str]) -> Result<Vec<(String, String)>, String> {
    let mut paths = Vec::new();
    for folder in folders {
        paths.extend(below(root, folder, "")?);
    }
    paths.sort();
    paths.into_iter().map(|path| read(root, &path).map(|text| (path.clone(), text))).collect()
}

/// Paths of the files below a folder whose names end with `ending`, relative to `root`.
pub fn below(root: &Path, folder: &str, ending: &str) -> Result<Vec<String>, String> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(root.join(folder)).map_err(|e| unreadable(folder, &e))?.flatten() {
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            paths.extend(below(root, &path, ending)?);
        } else if path.ends_with(ending) {
            paths.push(path);
        }
    }
    Ok(paths)
}

/// Text of a file.
pub fn read(root: &Path, path: &str) -> Result<String, String> {
    fs::read_to_string(root.join(path)).map_err(|e| unreadable(path, &e))
}

/// Message about a file that cannot be read.
pub fn unreadable(path: &str, error: &std::io::Error) -> String {
    format!("{path}: cannot be read: {error}")
}

/// Writes a file unless it has this content already, so that Cargo does not compile again without need.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    fs::write(path, bytes).map_err(|e| format!("{}: cannot be written: {e}", path.display()))
}
