//! `lodestar completions`.

use std::process::ExitCode;

use clap_complete::Shell;
use lodestar::Result;

use super::print::print_line;

/// Prints a script that completes commands and options in a shell.
///
/// For bash: `lodestar completions bash > ~/.local/share/bash-completion/completions/lodestar`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the subcommand for the command line `command`.
pub fn run(args: &CompletionsArgs, mut command: clap::Command) -> Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "lodestar", &mut script);
    print_line(String::from_utf8_lossy(&script).trim_end())?;
    Ok(ExitCode::SUCCESS)
}
