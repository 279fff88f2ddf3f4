//! `lodestar devices`.

use std::fmt::Write as _;
use std::process::ExitCode;

use lodestar::gpu::{DeviceInfo, DeviceKind, Survey, survey};
use lodestar::{Error, Result};

use super::print::{print_json, print_line};
use super::render_args::device_name;

/// Lists the Vulkan devices and says what keeps a device from use. For a device that cannot be used, it names what the device
/// lacks.
#[derive(Debug, clap::Args)]
pub struct DevicesArgs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Prints the devices. Without any device, the advice is the error.
pub fn run(args: &DevicesArgs) -> Result<ExitCode> {
    let survey = survey(device_name(std::env::var("LODESTAR_DEVICE").ok()).as_deref());
    if args.json {
        print_json(&survey)?;
    }
    if survey.devices.is_empty() {
        return Err(Error::Device(survey.advice.join("; ")));
    }
    if !args.json {
        print_line(describe(&survey).trim_end())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn describe(survey: &Survey) -> String {
    let mut text = String::new();
    for device in &survey.devices {
        let DeviceInfo { index, name, kind, api_version, driver_name, driver_info, refused, .. } = device;
        let kind = kind_words(*kind);
        // Writing to a string cannot fail.
        let queries = if device.limits.has_ray_queries { ", ray queries" } else { "" };
        let _ = write!(text, "{index}: {name} ({kind}, Vulkan {api_version}{queries}, {driver_name} {driver_info})");
        text += if survey.default == Some(*index) { " - the default\n" } else { "\n" };
        if let Some(need) = refused {
            let _ = writeln!(text, "   cannot be used: {need}");
        }
    }
    for sentence in &survey.advice {
        let _ = writeln!(text, "note: {sentence}");
    }
    text
}

fn kind_words(kind: DeviceKind) -> &'static str {
    match kind {
        DeviceKind::Discrete => "discrete GPU",
        DeviceKind::Integrated => "integrated GPU",
        DeviceKind::Virtual => "virtual GPU",
        DeviceKind::Cpu => "CPU",
        DeviceKind::Other => "other device",
    }
}
