//! Compiler from GLSL to SPIR-V, for the build scripts of the crate and of `tests/tampered`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Folder that includes are relative to.
const INCLUDE_FOLDER: &str = "glsl/include";

/// Compiles `file`, a path relative to the folder `root`, with everything that it includes. The files that were written for it
/// lie in `written`. Returns the SPIR-V.
pub fn compile(root: &Path, file: &str, macros: &[&str], written: &Path) -> Result<Vec<u8>, String> {
    let source = fs::read_to_string(root.join(file)).map_err(|e| format!("{file}: cannot be read: {e}"))?;
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
    options.set_include_callback(|name, _, _, _| resolve_include(root, written, name));
    let artifact = compiler
        .compile_into_spirv(&source, shaderc::ShaderKind::Compute, file, "main", Some(&options))
        .map_err(|e| diagnostics(root, &e.to_string()))?;
    Ok(artifact.as_binary_u8().to_vec())
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
