//! Compiler from GLSL to SPIR-V, for the build scripts of the crate and of `tests/tampered`.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use super::kept::Kept;

/// Folder that includes are relative to.
const INCLUDE_FOLDER: &str = "glsl/include";
/// This file, which has the options of the compiler, and the versions of the crates.
const OPTIONS: &str = include_str!("compile.rs");
const VERSIONS: &str = include_str!("../Cargo.lock");

/// Compiles `file`, a path relative to the folder `root`, with everything that it includes. The files that were written for it
/// lie in `written`. Returns the SPIR-V, that of an earlier build if there is one of the same text.
pub fn compile(root: &Path, file: &str, macros: &[&str], written: &Path) -> Result<Vec<u8>, String> {
    let source = fs::read_to_string(root.join(file)).map_err(|e| format!("{file}: cannot be read: {e}"))?;
    let read = RefCell::new(format!("{}\n{macros:?}\n{file}\n{source}", compiler_identity()));
    let compiler = shaderc::Compiler::new().map_err(|e| e.to_string())?;
    let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_target_spirv(shaderc::SpirvVersion::V1_5);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    // Debug information keeps the names through the optimizer.
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    for name in macros {
        options.add_macro_definition(name, Some("1"));
    }
    options.set_include_callback(|name, _, _, _| {
        let include = resolve_include(root, written, name)?;
        let _ = write!(read.borrow_mut(), "\n{name}\n{}", include.content);
        Ok(include)
    });
    // The preprocessor reads all that is included. What it says of faults, the compiler says, too.
    let is_whole = compiler.preprocess(&source, file, "main", Some(&options)).is_ok();
    let out = env::var_os("OUT_DIR").map(PathBuf::from).filter(|_| is_whole);
    let kept = out.and_then(|out| Kept::new(&out, read.take()));
    if let Some(spirv) = kept.as_ref().and_then(Kept::read) {
        return Ok(spirv);
    }
    let artifact = compiler
        .compile_into_spirv(&source, shaderc::ShaderKind::Compute, file, "main", Some(&options))
        .map_err(|e| diagnostics(root, &e.to_string()))?;
    kept.iter().for_each(|kept| kept.write(artifact.as_binary_u8()));
    Ok(artifact.as_binary_u8().to_vec())
}

/// Identity of the compiler: its options here, the version of its crate, and the library of the system, if there is one.
fn compiler_identity() -> String {
    let of_crate = VERSIONS.split("[[package]]").find(|package| package.contains("\nname = \"shaderc-sys\"\n"));
    let libraries = env::var_os("SHADERC_LIB_DIR").and_then(|folder| fs::read_dir(folder).ok());
    let mut libraries: Vec<_> = libraries
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| {
            let data = fs::metadata(entry.path()).ok();
            (entry.file_name(), data.map(|data| (data.len(), data.modified().ok())))
        })
        .collect();
    libraries.sort();
    format!("{OPTIONS}\n{}\n{libraries:?}", of_crate.unwrap_or_default())
}

fn resolve_include(root: &Path, written: &Path, name: &str) -> Result<shaderc::ResolvedInclude, String> {
    let resolved_name = format!("{INCLUDE_FOLDER}/{name}");
    let content = fs::read_to_string(root.join(&resolved_name)).or_else(|_| fs::read_to_string(written.join(name)));
    let content = content.map_err(|_| format!("no file {name} under {INCLUDE_FOLDER}, and none is written"))?;
    Ok(shaderc::ResolvedInclude { resolved_name, content })
}

/// Converts messages of the form `file:line: error: text` to the form of rustc's messages.
fn diagnostics(root: &Path, message: &str) -> String {
    let mut text = String::new();
    for line in message.lines() {
        let mut parts = line.splitn(3, ':');
        let (file, number, rest) =
            (parts.next(), parts.next().and_then(|n| n.trim().parse::<usize>().ok()), parts.next());
        let (Some(file), Some(number), Some(rest)) = (file, number, rest) else {
            let _ = writeln!(text, "{line}");
            continue;
        };
        let source = fs::read_to_string(root.join(file)).unwrap_or_default();
        let source_line = source.lines().nth(number.saturating_sub(1)).unwrap_or_default();
        let margin = " ".repeat(number.to_string().len());
        let _ = writeln!(
            text,
            "{}\n{margin}--> {file}:{number}\n{margin} |\n{number} | {source_line}\n{margin} |",
            rest.trim()
        );
    }
    text
}
