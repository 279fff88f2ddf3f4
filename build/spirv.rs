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
    use std::collections::BTreeMap;
    use std::fs;
    use std::io::Read;
    use std::path::Path;
    use std::sync::OnceLock;

    use ruzstd::StreamingDecoder;

    use super::super::FINGERPRINT_FILE;
    use super::super::glsl::files::unreadable;
    use super::super::kernels::{BackEnd, spirv_file};

    const FOLDER: &str = "spirv";
    /// File with a line for each kernel: the name of its file, and the number of its bytes.
    const LIST: &str = "spirv/kernels.txt";
    /// All kernels of the list, one after the other, compressed together: the back ends of a kernel have most of their code in common.
    const KERNELS: &str = "spirv/kernels.zst";

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

    /// SPIR-V of the kernel `file`.
    pub fn of(file: &str, back_end: BackEnd, _written: &Path) -> Result<Vec<u8>, String> {
        static ALL: OnceLock<Result<BTreeMap<String, Vec<u8>>, String>> = OnceLock::new();
        let name = spirv_file(file, back_end);
        let all = ALL.get_or_init(read).as_ref().map_err(Clone::clone)?;
        all.get(&name).cloned().ok_or_else(|| format!("{LIST} lacks {name}"))
    }

    /// Reads all kernels.
    fn read() -> Result<BTreeMap<String, Vec<u8>>, String> {
        let list = fs::read_to_string(LIST).map_err(|e| unreadable(LIST, &e))?;
        let compressed = fs::read(KERNELS).map_err(|e| unreadable(KERNELS, &e))?;
        let mut decoder = StreamingDecoder::new(&compressed[..]).map_err(|e| format!("{KERNELS}: {e}"))?;
        list.lines()
            .map(|line| {
                let (name, bytes) =
                    line.split_once(' ').ok_or_else(|| format!("{LIST}: `{line}` lacks the number of bytes"))?;
                let mut spirv = vec![0; bytes.parse().map_err(|e| format!("{LIST}: `{line}`: {e}"))?];
                decoder.read_exact(&mut spirv).map_err(|e| unreadable(KERNELS, &e))?;
                Ok((name.to_owned(), spirv))
            })
            .collect()
    }
}
