//! GLSL that is written by build scripts for other GLSL to include, of the crate and of `tests/tampered`.

mod bsdfs;
pub mod declarations;
pub mod files;
pub mod records;
pub mod structs;
mod wave;

use std::collections::BTreeMap;
use std::path::Path;

use declarations::shared_constants;
use records::Records;

/// Folder that includes are relative to.
pub const FOLDER: &str = "glsl/include";
/// Folder of the declarations that GLSL and Rust share.
pub const SHARED_FOLDER: &str = "glsl/include/shared";

/// Written files, and what they were written from.
pub struct Includes {
    /// Texts by the name that GLSL includes.
    pub texts: BTreeMap<String, String>,
    /// Structs of the GLSL.
    pub records: Records,
    /// Rust declarations of the constants that follow from the files.
    pub constants: String,
}

impl Includes {
    /// Writes the files from the GLSL below `root`.
    ///
    /// # Errors
    /// The message says which GLSL is wrong, and where.
    pub fn new(root: &Path) -> Result<Self, String> {
        let sources = files::read_all(root, &[FOLDER, "glsl/kernels"])?;
        let mut lengths = BTreeMap::new();
        for (file, text) in sources.iter().filter(|(file, _)| file.starts_with(SHARED_FOLDER)) {
            let constants = shared_constants(file, text)?.into_iter();
            lengths.extend(constants.filter_map(|constant| Some((constant.name, constant.value.parse().ok()?))));
        }
        let records = Records::read(&sources, lengths)?;
        let mut texts = records.includes()?;
        let (code, slot) = wave::write(&records)?;
        texts.insert(wave::INCLUDE.into(), code);
        let (code, kinds) = bsdfs::write(&sources, &records)?;
        texts.insert(bsdfs::INCLUDE.into(), code);
        let constants = format!(
            "{kinds}/// Size of a wave's slot, in groups of four words.\npub const SLOT_QUADRUPLES: u32 = {slot};\n"
        );
        Ok(Self { texts, records, constants })
    }

    /// Writes the files below `folder`.
    ///
    /// # Errors
    /// The message names the file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), String> {
        for (name, text) in &self.texts {
            let path = folder.join(name);
            let parent = path.parent().unwrap_or(folder);
            std::fs::create_dir_all(parent).map_err(|e| format!("{}: cannot be made: {e}", parent.display()))?;
            files::write_file(&path, text.as_bytes())?;
        }
        Ok(())
    }

    /// Text of the file that GLSL includes by this name.
    ///
    /// # Errors
    /// The message names the file that cannot be read.
    pub fn text(&self, root: &Path, name: &str) -> Result<String, String> {
        self.texts.get(name).cloned().map_or_else(|| files::read(root, &format!("{FOLDER}/{name}")), Ok)
    }
}
