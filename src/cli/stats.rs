//! What `--stats` writes.

use lodestar::film::noise::NoiseReport;
use lodestar::gpu::DeviceInfo;
use lodestar::image::metrics::Metrics;
use lodestar::renderer::Counts;
use lodestar::settings::Settings;
use serde::{Deserialize, Serialize};

/// The whole file.
#[derive(Debug, Serialize)]
pub struct Stats {
    pub scene: String,
    pub settings: Settings,
    pub device: DeviceInfo,
    pub versions: Versions,
    #[serde(flatten)]
    pub times: SetupTimes,
    pub totals: Totals,
    pub steps: Vec<Step>,
}

/// How long it took to come to the first sample, and with what.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct SetupTimes {
    pub load_seconds: f64,
    pub bvh_seconds: f64,
    pub pipeline_seconds: f64,
    /// From the command's start until the first sample could be taken: less than the sum where things went side by side, more
    /// by what none of them counts.
    pub setup_seconds: f64,
    #[serde(skip)]
    pub primitive_count: usize,
}

/// What produced the numbers.
#[derive(Debug, Serialize)]
pub struct Versions {
    pub lodestar: &'static str,
    pub vulkan: String,
    pub driver: String,
}

impl Versions {
    /// With the driver of `device`.
    pub fn of(device: &DeviceInfo) -> Self {
        Self {
            lodestar: env!("CARGO_PKG_VERSION"),
            vulkan: device.api_version.clone(),
            driver: format!("{} {}", device.driver_name, device.driver_info),
        }
    }
}

/// One step, or all of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Samples that every pixel has taken, but those that noise has ended.
    pub spp: u64,
    pub seconds: f64,
    pub paths: u64,
    pub rays: u64,
    /// Rays towards sampled lights, which are not among `rays`.
    pub shadow_rays: u64,
    /// Milliseconds per sample per pixel, for the whole picture.
    pub ms_per_sample: f64,
    pub invalid_rate: f64,
    pub light_hit_rate: f64,
    pub tries_per_sample: f64,
    /// Of the picture after this step, where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub errors: Option<Metrics>,
}

/// The sum of the steps.
#[derive(Debug, Serialize)]
pub struct Totals {
    #[serde(flatten)]
    pub sums: Step,
    pub primitives: usize,
    pub nonfinite_samples: u64,
    /// Where noise ends the render.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseReport>,
    /// The most memory that the device's buffers ever held.
    pub peak_bytes: u64,
    /// The most memory of the process, where the system tells.
    pub peak_resident_bytes: Option<u64>,
}

impl Step {
    /// Of `paths` paths, `spp` for every pixel of the window that noise has not ended and, where the step was cut short, some more
    /// for a few.
    pub fn new(spp: u64, paths: u64, pixels: u64, seconds: f64, counts: &Counts) -> Self {
        let mean_spp = paths as f64 / pixels as f64;
        Self {
            spp,
            seconds,
            paths,
            rays: counts.rays,
            shadow_rays: counts.shadow_rays,
            ms_per_sample: if paths == 0 { 0.0 } else { seconds * 1000.0 / mean_spp },
            invalid_rate: counts.invalid_rate(),
            light_hit_rate: counts.light_hit_rate(),
            tries_per_sample: counts.tries_per_sample(),
            errors: None,
        }
    }
}

/// Peak resident memory of this process, on systems that tell it through a file.
pub fn peak_resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}
