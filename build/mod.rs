//! Generator of the files that `src/generated` includes: the SPIR-V of the kernels in `glsl/`, and Rust code that
//! describes it. Each module writes one file:
//!
//! | file | content |
//! |---|---|
//! | `constants.rs` | constants that GLSL and Rust share, and binding numbers |
//! | `variant.rs` | the specialization constants as one struct |
//! | `registry.rs` | the kernels with their interfaces |
//! | `layout_checks.rs` | assertions that structs have the same layout in GLSL |
//!
//! `packages/crate.sh` copies the SPIR-V of the product's kernels and the fingerprint of their GLSL to the published crate.

#[cfg(feature = "shaderc")]
mod compile;
mod constants;
mod cores;
mod declarations;
mod interface;
mod kernels;
mod layout;
mod registry;
mod sets;
mod spirv;
mod variant;

use std::fs;
use std::path::Path;

/// Folder of the declarations that GLSL and Rust share.
const SHARED_FOLDER: &str = "glsl/include/shared";
/// File with the fingerprint of the GLSL, beside the SPIR-V.
const FINGERPRINT_FILE: &str = "fingerprint";

/// Writes all files into the folder `out`.
///
/// # Errors
/// The message says which GLSL is wrong, and where.
pub fn run(out: &Path) -> Result<(), String> {
    let shared = constants::Shared::read(&shared_files()?)?;
    let fingerprint = kernels::fingerprint()?;
    spirv::check(&fingerprint)?;
    let kernels = kernels::all()?;
    write(out, "constants.rs", &(shared.code() + &sets::binding_numbers(&shared.sets(), &kernels)?))?;
    write(out, "variant.rs", &variant::code(&shared.specialization))?;
    write(out, "registry.rs", &registry::code(&kernels)?)?;
    write(out, "layout_checks.rs", &layout::code(&kernels))?;
    write_file(&out.join(FINGERPRINT_FILE), fingerprint.as_bytes())?;
    kernels.iter().try_for_each(|kernel| kernel.write_modules(out))
}

/// Files that may declare shared constants, with their texts.
fn shared_files() -> Result<Vec<(String, String)>, String> {
    let mut files = kernels::files_below(SHARED_FOLDER, ".glsl")?;
    files.sort();
    let read =
        |file: String| fs::read_to_string(&file).map(|text| (file.clone(), text)).map_err(|e| unreadable(&file, &e));
    files.into_iter().map(read).collect()
}

fn unreadable(path: &str, error: &std::io::Error) -> String {
    format!("{path}: cannot be read: {error}")
}

fn write(out: &Path, name: &str, code: &str) -> Result<(), String> {
    write_file(&out.join(name), format!("// Written by build.rs from glsl/.\n\n{code}").as_bytes())
}

/// Writes a file unless it has this content already, so that Cargo does not compile again without need.
fn write_file(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    fs::write(path, bytes).map_err(|e| format!("{}: cannot be written: {e}", path.display()))
}
