//! Compiles kernels of `glsl/` with every mutation of `src/mutations.rs` in them, behind a specialization constant.

#[path = "../../build/compile.rs"]
mod compile;
#[path = "../../build/cores.rs"]
mod cores;
#[expect(dead_code, reason = "it also serves the crate's build script")]
#[path = "../../build/glsl/mod.rs"]
mod glsl;
#[path = "../../build/kept.rs"]
mod kept;
#[path = "src/mutations.rs"]
mod mutations;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

use mutations::{MUTATIONS, Patch};

const REPOSITORY: &str = "../..";
/// Kernels to compile. They read storage buffers, which every device has.
const KERNELS: [&str; 19] = [
    "glsl/kernels/layers/first_hits.comp",
    "glsl/kernels/noise/judge_noise.comp",
    "glsl/kernels/trace/trace.comp",
    "glsl/kernels/wave/wave_extend.comp",
    "glsl/kernels/wave/wave_connect.comp",
    "glsl/kernels/wave/wave_shadow.comp",
    "glsl/kernels/wave/wave_shade.comp",
    "glsl/kernels/wave/wave_film.comp",
    "glsl/kernels/learn/update_radiance.comp",
    "glsl/kernels/learn/pool_radiance.comp",
    "glsl/kernels/learn/blend_radiance.comp",
    "glsl/kernels/learn/refine_quadtrees.comp",
    "glsl/kernels/learn/update_lights.comp",
    "glsl/kernels/learn/update_normalization.comp",
    "glsl/test/add_target.comp",
    "glsl/test/guided_density.comp",
    "glsl/test/guided_direction.comp",
    "glsl/test/normalize_cell.comp",
    "glsl/test/sample_direction.comp",
];
/// File that declares the constant. Every file that a mutation may patch includes it.
const VARIANT: &str = "glsl/include/shared/variant.glsl";
const CONSTANT: &str = "layout(constant_id = 2000) const uint MUTATION = 0u;";

fn main() {
    for watched in ["build.rs", "src", "../../build", "../../glsl"] {
        println!("cargo::rerun-if-changed={watched}");
    }
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    if let Err(message) = run(&out) {
        message.lines().for_each(|line| println!("cargo::error={line}"));
        process::exit(1);
    }
}

fn run(out: &Path) -> Result<(), String> {
    let sources = out.join("sources");
    // A file of an earlier build may be gone.
    let copy = sources.join("glsl");
    if copy.exists() {
        fs::remove_dir_all(&copy).map_err(|e| format!("{}: cannot be removed: {e}", copy.display()))?;
    }
    copy_folder(&Path::new(REPOSITORY).join("glsl"), &copy)?;
    edit(&sources, VARIANT, |text| {
        Ok(text.replacen("layout(local_size", &format!("{CONSTANT}\nlayout(local_size"), 1))
    })?;
    for (number, mutation) in (1..).zip(MUTATIONS) {
        for patch in mutation.patches {
            edit(&sources, patch.file, |text| apply(mutation.name, number, patch, &text))?;
        }
    }
    // A mutation may patch what the included files are written from.
    let written = out.join("include");
    glsl::Includes::new(&sources)?.write(&written)?;
    let mut code = String::from("// Written by build.rs.\nconst KERNELS: &[(&str, &[u8])] = &[\n");
    let compiled =
        cores::on_all_cores(KERNELS.len(), |kernel| compile::compile(&sources, KERNELS[kernel], &[], &written));
    for (file, spirv) in KERNELS.into_iter().zip(compiled) {
        let name = Path::new(file).file_stem().expect("a name").to_string_lossy();
        let path = out.join(format!("{name}.spv"));
        fs::write(&path, spirv?).map_err(|e| format!("{}: cannot be written: {e}", path.display()))?;
        let _ = writeln!(code, "    ({name:?}, include_bytes!({path:?})),");
    }
    code.push_str("];\n");
    fs::write(out.join("kernels.rs"), code).map_err(|e| format!("kernels.rs: cannot be written: {e}"))
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("{}: cannot be copied: {e}", from.display());
    fs::create_dir_all(to).map_err(failed)?;
    for entry in fs::read_dir(from).map_err(failed)?.flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target).map_err(failed)?;
        }
    }
    Ok(())
}

fn edit(root: &Path, file: &str, change: impl FnOnce(String) -> Result<String, String>) -> Result<(), String> {
    let path = root.join(file);
    let text = fs::read_to_string(&path).map_err(|e| format!("{file}: cannot be read: {e}"))?;
    fs::write(&path, change(text)?).map_err(|e| format!("{file}: cannot be written: {e}"))
}

fn apply(name: &str, number: u32, patch: &Patch, text: &str) -> Result<String, String> {
    match text.matches(patch.text).count() {
        1 => Ok(text.replacen(patch.text, &patch.mutated.replace("MUTATED", &format!("(MUTATION == {number}u)")), 1)),
        count => Err(format!(
            "{}: the mutation `{name}` of tests/tampered/src/mutations.rs stands in place of `{}`, which must occur once \
             in the file but occurs {count} times: bring the mutation up to date with the kernel",
            patch.file, patch.text
        )),
    }
}
