//! Names of files as the page tells them: no folders of the machine that renders.

use std::path::{MAIN_SEPARATOR, Path};

/// Name of a file.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Name of a scene's file after the name of its folder, because many scenes are called `scene.xml`.
pub fn scene_name(path: &Path) -> String {
    let folder = path.parent().and_then(Path::file_name);
    folder.map_or_else(|| file_name(path), |folder| format!("{}/{}", folder.to_string_lossy(), file_name(path)))
}

/// A sentence with names in place of absolute paths.
pub fn without_folders(sentence: &str) -> String {
    let named = |word: &str| {
        let Some(begin) = word.find(MAIN_SEPARATOR) else { return word.to_owned() };
        // A path begins the word, or follows an opening quote or parenthesis; `a/b` is no absolute path.
        let is_absolute = word[..begin].chars().all(|c| !c.is_alphanumeric() && !matches!(c, '.' | '~' | '_' | '-'));
        let path = word.trim_end_matches(|c: char| c == MAIN_SEPARATOR || c.is_ascii_punctuation());
        match path.rfind(MAIN_SEPARATOR).filter(|_| is_absolute) {
            Some(end) => format!("{}{}", &word[..begin], &word[end + 1..]),
            None => word.to_owned(),
        }
    };
    sentence.split(' ').map(named).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_not_told() {
        assert_eq!(file_name(Path::new("/home/me/a.exr")), "a.exr");
        assert_eq!(scene_name(Path::new("/home/me/kitchen/scene.xml")), "kitchen/scene.xml");
        assert_eq!(scene_name(Path::new("scene.xml")), "scene.xml");
        for (sentence, told) in [
            ("/home/me/a.exr: cannot be written: no space", "a.exr: cannot be written: no space"),
            ("the file `/home/me/a.exr` (/tmp/b/)", "the file `a.exr` (b/)"),
            ("/tmp/folder/, then", "folder/, then"),
            ("12 rays/s, and/or `models/a.ply`", "12 rays/s, and/or `models/a.ply`"),
            ("", ""),
        ] {
            assert_eq!(without_folders(sentence), told);
        }
    }
}
