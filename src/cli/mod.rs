//! The command line: one file per subcommand. Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted.

mod compare;
mod devices;
mod progress;
mod render;
mod render_args;
mod stats;

use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use lodestar::{Error, Result};

/// Renders Mitsuba scenes with path guiding on any Vulkan device.
#[derive(Debug, Parser)]
#[command(name = "lodestar", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render_args::RenderArgs>),
    Devices(devices::DevicesArgs),
    Compare(compare::CompareArgs),
}

/// Parses the arguments, runs the subcommand and reports its failure as one sentence.
pub fn run() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Compare(args) => compare::run(&args),
    };
    outcome.unwrap_or_else(|error| {
        // Nothing is left to report to where standard error is closed, too.
        let _ = writeln!(io::stderr(), "lodestar: error: {error}");
        ExitCode::FAILURE
    })
}

/// Prints `text` and a line break. A reader that has left (`lodestar ... | head -1`) is no error: it has what it wanted.
fn print_line(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::write(Path::new("standard output"))(error)),
        _ => Ok(()),
    }
}

/// Prints `value` as indented JSON.
fn print_json(value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(io::Error::from);
    print_line(&text.map_err(Error::write(Path::new("standard output")))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }
}
