//! Entry point of the `lodestar` command line.
#![deny(missing_docs)]

fn main() -> std::process::ExitCode {
    lodestar::cli::run(std::env::args_os())
}
