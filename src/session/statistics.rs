//! Numbers about a render, as `--stats` writes them.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::film::noise::NoiseReport;
use crate::fleet::SharingTimes;
use crate::gpu::DeviceInfo;
use crate::image::metrics::Metrics;
use crate::renderer::Counts;
use crate::settings::Settings;

/// All numbers about one render.
#[derive(Debug, Serialize)]
pub struct Statistics {
    /// The scene's name.
    pub scene: String,
    /// The settings.
    pub settings: Settings,
    /// The device.
    pub device: DeviceInfo,
    /// The software.
    pub versions: Versions,
    /// Times before the first sample.
    #[serde(flatten)]
    pub times: SetupTimes,
    /// Sums over the steps.
    pub totals: Totals,
    /// The steps in order.
    pub steps: Vec<StepStatistics>,
}

/// Times before the first sample, and the size of the scene.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct SetupTimes {
    /// Reading the scene.
    pub load_seconds: f64,
    /// Building the hierarchy.
    pub bvh_seconds: f64,
    /// Building the kernels and uploading the scene.
    pub pipeline_seconds: f64,
    /// Wall time from the start until the first sample could be taken. Some of the work runs at the same time, so the sum of
    /// the other times may be larger.
    pub setup_seconds: f64,
    /// Primitives of the scene.
    #[serde(skip)]
    pub primitive_count: usize,
}

/// What `work` gives, and the seconds that it has taken.
pub(super) fn timed<T>(work: impl FnOnce() -> Result<T>) -> Result<(T, f64)> {
    let begin = Instant::now();
    Ok((work()?, begin.elapsed().as_secs_f64()))
}

/// The software that produced the numbers.
#[derive(Debug, Serialize)]
pub struct Versions {
    /// This crate's version.
    pub lodestar: &'static str,
    /// The device's Vulkan version.
    pub vulkan: String,
    /// The driver's name and version.
    pub driver: String,
}

impl Versions {
    /// The versions on `device`.
    pub fn of(device: &DeviceInfo) -> Self {
        Self {
            lodestar: env!("CARGO_PKG_VERSION"),
            vulkan: device.api_version.clone(),
            driver: format!("{} {}", device.driver_name, device.driver_info),
        }
    }
}

/// Numbers about one step, or about all of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepStatistics {
    /// Samples per pixel. A pixel that has reached its noise target has fewer.
    pub spp: u64,
    /// Wall time.
    pub seconds: f64,
    /// Paths traced.
    pub paths: u64,
    /// Rays traced, without shadow rays.
    pub rays: u64,
    /// Shadow rays, which test whether a sampled light is visible.
    pub shadow_rays: u64,
    /// Milliseconds in which every pixel of the picture receives one sample.
    pub ms_per_sample: f64,
    /// Share of the guided directions that pointed below the surface.
    pub invalid_rate: f64,
    /// Share of the scattered rays that hit an emitter.
    pub light_hit_rate: f64,
    /// Number of proposals per guided direction.
    pub tries_per_sample: f64,
    /// Error of the picture after this step, if it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub errors: Option<Metrics>,
}

/// Sums over the steps of a render.
#[derive(Debug, Serialize)]
pub struct Totals {
    /// The sums.
    #[serde(flatten)]
    pub sums: StepStatistics,
    /// Primitives of the scene.
    pub primitives: usize,
    /// Samples and learning targets dropped because they were NaN or infinite.
    pub nonfinite_samples: u64,
    /// Noise of the picture, if noise can end the render.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseReport>,
    /// Times of the work that several devices do only because they share the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharing: Option<SharingTimes>,
    /// Peak memory of the buffers of this process's devices in bytes.
    pub peak_bytes: u64,
    /// Peak memory of the process in bytes, on systems that report it.
    pub peak_resident_bytes: Option<u64>,
}

impl StepStatistics {
    /// Numbers about `paths` paths. Every pixel has `spp` of them, a pixel that has reached its noise target fewer. A step that was
    /// cut short has a few paths more.
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

/// Peak resident memory of this process in bytes, on systems with `/proc`.
pub(super) fn peak_resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}
