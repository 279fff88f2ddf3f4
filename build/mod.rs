//! Generator of the files that `src/generated` includes: the SPIR-V of the kernels in `glsl/`, and Rust code that
//! describes it. Each module writes one file:
//!
//! | file | content |
//! |---|---|
//! | `constants.rs` | constants that GLSL and Rust share, and binding numbers |
//! | `variant.rs` | the specialization constants as one struct |
//! | `registry.rs` | the kernels with their interfaces |
//! | `layout.rs` | the structs that cross to GLSL, and assertions that they have the same layout there |
//!
//! The folder `include` gets the files that are written for GLSL to include.
//!
//! `packages/crate.sh` copies the SPIR-V of the product's kernels and the fingerprint of their GLSL to the published crate.

#[cfg(feature = "shaderc")]
mod compile;
mod constants;
mod cores;
mod glsl;
mod interface;
#[cfg(feature = "shaderc")]
mod kept;
mod kernels;
mod layout;
mod registry;
mod sets;
mod spirv;
mod variant;

use std::path::Path;

use glsl::files::{self, write_file};
use glsl::{Includes, SHARED_FOLDER};

/// File with the fingerprint of the GLSL, beside the SPIR-V.
const FINGERPRINT_FILE: &str = "fingerprint";
/// Folder of the files that are written for GLSL to include.
const INCLUDE_FOLDER: &str = "include";

/// Writes all files into the folder `out`.
///
/// # Errors
/// The message says which GLSL is wrong, and where.
pub fn run(out: &Path) -> Result<(), String> {
    let root = Path::new("");
    let shared = constants::Shared::read(&files::read_all(root, &[SHARED_FOLDER])?)?;
    let includes = Includes::new(root)?;
    includes.write(&out.join(INCLUDE_FOLDER))?;
    let fingerprint = kernels::fingerprint(&includes)?;
    spirv::check(&fingerprint)?;
    let kernels = kernels::all(&includes, &out.join(INCLUDE_FOLDER))?;
    let binding_numbers = sets::binding_numbers(&shared.sets(), &kernels)?;
    write(out, "constants.rs", &(shared.code() + &includes.constants + &binding_numbers))?;
    write(out, "variant.rs", &variant::code(&shared.specialization))?;
    write(out, "registry.rs", &registry::code(&kernels)?)?;
    write(out, "layout.rs", &layout::code(&includes.records, &kernels)?)?;
    write_file(&out.join(FINGERPRINT_FILE), fingerprint.as_bytes())?;
    kernels.iter().try_for_each(|kernel| kernel.write_modules(out))
}

fn write(out: &Path, name: &str, code: &str) -> Result<(), String> {
    write_file(&out.join(name), format!("// Written by build.rs from glsl/.\n\n{code}").as_bytes())
}
