//! `lodestar devices`.

use std::fmt::Write as _;
use std::process::ExitCode;

use lodestar::Result;
use lodestar::gpu::{DeviceInfo, list_devices};

use super::print::{print_json, print_line};

/// Lists the Vulkan devices. For a device that cannot be used, it names what the device lacks.
#[derive(Debug, clap::Args)]
pub struct DevicesArgs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Prints the devices.
pub fn run(args: &DevicesArgs) -> Result<ExitCode> {
    let devices = list_devices()?;
    if args.json {
        print_json(&devices)?;
    } else {
        print_line(devices.iter().map(describe).collect::<String>().trim_end())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn describe(device: &DeviceInfo) -> String {
    let DeviceInfo { index, name, kind, api_version, driver_name, driver_info, refused, .. } = device;
    let mut text =
        format!("{index}: {name} ({kind:?}, Vulkan {api_version}, {driver_name} {driver_info})\n").to_string();
    if let Some(need) = refused {
        let _ = writeln!(text, "   cannot be used: {need}");
    }
    text
}
