//! Search for the library: in the folder that the user names, beside the program, and where the system looks.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::library::Oidn;
use crate::{Error, Result};

/// Environment variable that names the library's folder.
pub const FOLDER_VARIABLE: &str = "LODESTAR_OIDN";

/// Advice to a user who does not have the library.
const ADVICE: &str = "get the official build by `./setup.sh --oidn`, or unpack a release of Open Image Denoise 2 and name its folder with --oidn DIR or LODESTAR_OIDN";

/// File names of the library's versions 2.x.
#[cfg(target_os = "macos")]
const NAMES: [&str; 2] = ["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"];
#[cfg(not(target_os = "macos"))]
const NAMES: [&str; 2] = ["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"];

/// Loads the library from `folder`, or, where none is given, from [`FOLDER_VARIABLE`], from beside the program, or from
/// where the system looks. Returns it with the place that it came from.
///
/// # Errors
/// [`Error::Settings`] where there is no library, with the advice how to get it, or where it cannot be used.
pub fn find(folder: Option<&Path>) -> Result<Oidn> {
    let variable = std::env::var_os(FOLDER_VARIABLE).filter(|value| !value.is_empty()).map(PathBuf::from);
    let named = folder.map(|folder| ("--oidn", folder.to_path_buf())).or(variable.map(|path| (FOLDER_VARIABLE, path)));
    if let Some((source, folder)) = named {
        let found = first_library(in_folder(&folder))?;
        return found.ok_or_else(|| {
            let message = format!("{source} names {}, which contains no {}; {ADVICE}", folder.display(), NAMES[0]);
            Error::Settings(message)
        });
    }
    let beside = beside_program().into_iter().flat_map(|folder| in_folder(&folder)).collect();
    let system = NAMES.map(OsString::from).to_vec();
    for candidates in [beside, system] {
        if let Some(library) = first_library(candidates)? {
            return Ok(library);
        }
    }
    Err(Error::Settings(format!("there is no Open Image Denoise 2 on this machine; {ADVICE}")))
}

/// Files that may be the library in `folder`: a folder of libraries, or an unpacked release.
fn in_folder(folder: &Path) -> Vec<OsString> {
    let folders = [folder.to_path_buf(), folder.join("lib"), folder.join("lib64")];
    let files = folders.iter().flat_map(|folder| NAMES.map(|name| folder.join(name)));
    // An absolute path: the system would search for a bare name elsewhere.
    let absolute = files.filter_map(|file| std::path::absolute(file).ok());
    absolute.filter(|file| file.exists()).map(PathBuf::into_os_string).collect()
}

/// Folders beside the program: its own, `oidn` within and beside it, and `lib` beside it.
fn beside_program() -> Vec<PathBuf> {
    let program = std::env::current_exe().ok().and_then(|program| program.canonicalize().ok());
    let Some(folder) = program.as_deref().and_then(Path::parent) else { return Vec::new() };
    let mut folders = vec![folder.to_path_buf(), folder.join("oidn")];
    if let Some(above) = folder.parent() {
        folders.extend([above.join("oidn"), above.join("lib")]);
    }
    folders
}

/// First of the `candidates` that exists.
fn first_library(candidates: Vec<OsString>) -> Result<Option<Oidn>> {
    for candidate in candidates {
        match Oidn::load(&candidate) {
            None => {}
            Some(Ok(library)) => return Ok(Some(library)),
            Some(Err(reason)) => {
                let file = Path::new(&candidate).display();
                let message = format!("{file} is not a usable Open Image Denoise 2: {reason}; {ADVICE}");
                return Err(Error::Settings(message));
            }
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sentence(folder: &Path) -> String {
        find(Some(folder)).err().expect("no library").to_string()
    }

    #[test]
    fn a_folder_without_the_library_is_named_with_the_advice() {
        let folder = tempfile::tempdir().unwrap();
        let sentence = sentence(folder.path());
        for word in [&folder.path().display().to_string()[..], "--oidn", NAMES[0], "setup.sh --oidn"] {
            assert!(sentence.contains(word), "{sentence} lacks {word}");
        }
    }

    #[test]
    fn a_file_that_is_no_library_is_refused() {
        for place in ["", "lib"] {
            let folder = tempfile::tempdir().unwrap();
            std::fs::create_dir_all(folder.path().join(place)).unwrap();
            std::fs::write(folder.path().join(place).join(NAMES[0]), "no library").unwrap();
            let sentence = sentence(folder.path());
            assert!(sentence.contains(NAMES[0]) && sentence.contains("cannot be loaded"), "{sentence}");
        }
    }
}
