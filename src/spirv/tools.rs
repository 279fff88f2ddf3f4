//! SPIRV-Tools of the Khronos Group: the programs `spirv-dis`, `spirv-opt` and `spirv-val` on the PATH. Compiling them
//! in would add eight minutes to every first build.

use std::io::{ErrorKind, Write};
use std::process::{Command, Stdio};

const TARGET: &str = "vulkan1.2";

/// Reasons why a tool gave no answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ToolFault {
    /// The tool is not installed.
    Missing,
    /// The tool failed with this message.
    Failed(String),
}

impl std::fmt::Display for ToolFault {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Missing => f.write_str("install SPIRV-Tools (`apt-get install spirv-tools`, or run setup.sh)"),
            Self::Failed(message) => f.write_str(message),
        }
    }
}

/// Disassembles words to the text that `spirv-as` reads, with names for numbers.
pub fn disassemble(words: &[u32]) -> Result<String, ToolFault> {
    let text = run("spirv-dis", &["-"], words)?;
    String::from_utf8(text).map_err(|_| ToolFault::Failed("spirv-dis gave no text".into()))
}

/// Checks that the module keeps Vulkan's rules.
pub fn validate(words: &[u32]) -> Result<(), ToolFault> {
    run("spirv-val", &["--target-env", TARGET, "--scalar-block-layout", "-"], words).map(drop)
}

/// Freezes specialization constants at their defaults and optimizes the module (`spirv-opt -O`), as drivers' own
/// optimizers are expected to do.
pub fn fold_constants(words: &[u32]) -> Result<Vec<u8>, ToolFault> {
    let target = format!("--target-env={TARGET}");
    let passes = ["--freeze-spec-const", "--fold-spec-const-op-composite", "-O"];
    run("spirv-opt", &[&[&target, "--scalar-block-layout"], &passes[..], &["-", "-o", "-"]].concat(), words)
}

/// Runs a program with the words as input and returns its output. All three programs read their whole input before they
/// write.
fn run(program: &str, arguments: &[&str], words: &[u32]) -> Result<Vec<u8>, ToolFault> {
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => ToolFault::Missing,
        _ => ToolFault::Failed(format!("{program} cannot be run: {error}")),
    };
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(failed)?;
    if let Some(mut stdin) = child.stdin.take() {
        match stdin.write_all(bytemuck::cast_slice(words)) {
            // The program has stopped reading, and its error output says why.
            Err(error) if error.kind() != ErrorKind::BrokenPipe => return Err(failed(error)),
            _ => {}
        }
    }
    let output = child.wait_with_output().map_err(failed)?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let first = said.lines().find(|line| !line.trim().is_empty()).unwrap_or("it failed without a message");
    Err(ToolFault::Failed(format!("{program}: {}", first.trim().trim_start_matches("error: "))))
}
