//! `lodestar devices`.

use std::process::ExitCode;

use lodestar::{Error, Result};

/// Lists the Vulkan devices and, for those that cannot be used, the need that they lack.
#[derive(Debug, clap::Args)]
pub struct DevicesArgs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Prints the devices.
pub fn run(args: &DevicesArgs) -> Result<ExitCode> {
    let _ = args.json;
    Err(Error::Device("listing devices is not supported yet; use a later version".into()))
}
