//! Writer of the constants that GLSL and Rust share.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::glsl::declarations::{SharedConstant, SpecializationConstant, shared_constants, specialization_constants};

/// Suffix of the names of constants that number the descriptor sets.
const SET_SUFFIX: &str = "_SET";

/// Constants that the shared files declare.
pub struct Shared {
    constants: Vec<SharedConstant>,
    /// Specialization constants.
    pub specialization: Vec<SpecializationConstant>,
}

impl Shared {
    /// Reads all shared files, given as pairs of path and text.
    pub fn read(files: &[(String, String)]) -> Result<Self, String> {
        let mut constants = Vec::new();
        let mut owners: BTreeMap<String, &str> = BTreeMap::new();
        for (file, text) in files {
            for constant in shared_constants(file, text)? {
                if let Some(other) = owners.insert(constant.name.clone(), file) {
                    return Err(format!("{file}: {} is declared in {other}, too", constant.name));
                }
                constants.push(constant);
            }
        }
        Ok(Self { constants, specialization: specialization_constants(files)? })
    }

    /// Names of the descriptor sets, by number.
    pub fn sets(&self) -> BTreeMap<u32, String> {
        let of_set =
            |c: &SharedConstant| Some((c.value.parse().ok()?, c.name.strip_suffix(SET_SUFFIX)?.to_lowercase()));
        self.constants.iter().filter_map(of_set).collect()
    }

    /// Rust declarations of all shared constants.
    pub fn code(&self) -> String {
        let mut code = String::new();
        for SharedConstant { name, rust_type, value, comment } in &self.constants {
            let _ = writeln!(code, "/// {}\npub const {name}: {rust_type} = {value};", plain(comment));
        }
        code
    }
}

/// Comment without the marks that rustdoc interprets.
fn plain(comment: &str) -> String {
    comment.replace(['`', '['], "").replace(']', "")
}
