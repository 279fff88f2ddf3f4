//! Writes the constants that both sides know.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::declarations::{SharedConstant, SpecializationConstant, shared_constants, specialization_constants};

/// Constants whose names end so number the descriptor sets.
const SET_SUFFIX: &str = "_SET";

/// All that the shared files declare.
pub struct Shared {
    constants: Vec<SharedConstant>,
    /// The specialization constants.
    pub specialization: Vec<SpecializationConstant>,
}

impl Shared {
    /// Reads (path, text) of all shared files.
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

    /// Names of the descriptor sets by their numbers.
    pub fn sets(&self) -> BTreeMap<u32, String> {
        let of_set =
            |c: &SharedConstant| Some((c.value.parse().ok()?, c.name.strip_suffix(SET_SUFFIX)?.to_lowercase()));
        self.constants.iter().filter_map(of_set).collect()
    }

    /// A Rust constant for each.
    pub fn code(&self) -> String {
        let mut code = String::new();
        for SharedConstant { name, rust_type, value, comment } in &self.constants {
            let _ = writeln!(code, "/// {}\npub const {name}: {rust_type} = {value};", plain(comment));
        }
        code
    }
}

/// A comment without marks that rustdoc would read.
fn plain(comment: &str) -> String {
    comment.replace(['`', '['], "").replace(']', "")
}
