//! SPIR-V of one kernel. With the feature `shaderc` it is compiled from the GLSL. Without the feature it is read from the
//! folder `spirv`, which only the published crate contains.

#[cfg(feature = "shaderc")]
pub use compiled::{check, of};
#[cfg(not(feature = "shaderc"))]
pub use shipped::{check, of};

#[cfg(feature = "shaderc")]
mod compiled {
    use std::path::Path;

    use super::super::compile::compile;
    use super::super::kernels::BackEnd;

    /// Succeeds: compiled SPIR-V fits any GLSL.
    pub fn check(_fingerprint: &str) -> Result<(), String> {
        Ok(())
    }

    /// Compiles the kernel `file`. The files that were written for GLSL lie in `written`.
    pub fn of(file: &str, back_end: BackEnd, written: &Path) -> Result<Vec<u8>, String> {
        compile(Path::new(""), file, back_end.macros(), written)
    }
}

#[cfg(not(feature = "shaderc"))]
mod shipped {
    use std::fs;
    use std::path::Path;

    use super::super::FINGERPRINT_FILE;
    use super::super::glsl::files::unreadable;
    use super::super::kernels::{BackEnd, spirv_file};

    const FOLDER: &str = "spirv";

    /// Fails unless the folder contains SPIR-V that was compiled from GLSL with this fingerprint.
    pub fn check(fingerprint: &str) -> Result<(), String> {
        if !Path::new(FOLDER).exists() {
            return Err("no compiled kernels: the folder spirv is missing, which only the published crate contains. \
                        Build with the feature shaderc, which compiles the kernels"
                .into());
        }
        let path = format!("{FOLDER}/{FINGERPRINT_FILE}");
        match fs::read_to_string(&path).map_err(|e| unreadable(&path, &e))? == fingerprint {
            true => Ok(()),
            false => {
                Err("the compiled kernels in the folder spirv belong to other GLSL than that in the folder glsl. \
                          Build with the feature shaderc, which compiles the kernels"
                    .into())
            }
        }
    }

    /// Reads the SPIR-V of the kernel `file`.
    pub fn of(file: &str, back_end: BackEnd, _written: &Path) -> Result<Vec<u8>, String> {
        let path = format!("{FOLDER}/{}", spirv_file(file, back_end));
        fs::read(&path).map_err(|e| unreadable(&path, &e))
    }
}
