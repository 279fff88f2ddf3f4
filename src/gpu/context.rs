//! Contexts: opened devices with their memory and pipelines.

use std::sync::Arc;

use ash::vk;

use super::debug::ValidationLog;
use super::device::LogicalDevice;
use super::device_info::DeviceInfo;
use super::idle_slots::IdleSlots;
use super::instance::Instance;
use super::memory::Memory;
use super::pipeline_cache::PipelineCache;
use super::pipelines::Pipelines;
use super::selection;
use super::timing::{Clock, SubmissionTime, TimingRecord};
use crate::Result;

/// Options for opening a device.
#[derive(Debug, Clone, Default)]
pub struct ContextOptions {
    /// Index of the device, or a part of its name in any case. Without it, the best device is taken, in this order of
    /// kinds: discrete, integrated, virtual, CPU, other.
    pub device: Option<String>,
    /// Whether the validation layer is enabled.
    pub validate: bool,
}

/// Vulkan device with its memory and its pipelines. Everything made from a context holds it.
pub struct Context {
    // These fields hold the device too, so it is declared last.
    pipelines: Pipelines,
    pipeline_cache: PipelineCache,
    memory: Memory,
    idle_slots: IdleSlots,
    timings: TimingRecord,
    device: Arc<LogicalDevice>,
}

/// Lists all Vulkan devices, usable or not.
///
/// # Errors
/// [`crate::Error::Device`] where no loader or no driver is installed.
pub fn list_devices() -> Result<Vec<DeviceInfo>> {
    let instance = Instance::new(false)?;
    Ok(describe(&instance, &instance.physical_devices()?))
}

fn describe(instance: &Instance, devices: &[vk::PhysicalDevice]) -> Vec<DeviceInfo> {
    let devices = devices.iter().enumerate();
    devices.map(|(index, &device)| DeviceInfo::query(instance.raw(), device, index)).collect()
}

impl Context {
    /// Opens a device.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where no loader, driver or validation layer is installed, the wanted device is unknown,
    /// or no device can be used.
    pub fn new(options: &ContextOptions) -> Result<Arc<Self>> {
        Self::choose(options, |devices| selection::choose(devices, options.device.as_deref()))
    }

    /// Opens one of the best devices: ranks on one machine take these in turn. `local_rank` counts them from 0.
    ///
    /// # Errors
    /// Where [`Context::new`] fails.
    pub fn of_local_rank(options: &ContextOptions, local_rank: usize) -> Result<Arc<Self>> {
        Self::choose(options, |devices| selection::in_turn(devices, local_rank))
    }

    fn choose(
        options: &ContextOptions,
        choice: impl FnOnce(&[DeviceInfo]) -> Result<&DeviceInfo>,
    ) -> Result<Arc<Self>> {
        let instance = Instance::new(options.validate)?;
        let physical = instance.physical_devices()?;
        let devices = describe(&instance, &physical);
        let chosen = choice(&devices)?;
        tracing::debug!(device = chosen.name, driver = chosen.driver_info, "opening a Vulkan device");
        let device = Arc::new(LogicalDevice::new(instance, physical[chosen.index], chosen.clone())?);
        let pipeline_cache = PipelineCache::new(Arc::clone(&device))?;
        let memory = Memory::new(Arc::clone(&device))?;
        let idle_slots = IdleSlots::new(Arc::clone(&device));
        let (pipelines, timings) = Default::default();
        Ok(Arc::new(Self { pipelines, pipeline_cache, memory, idle_slots, timings, device }))
    }

    /// Opens all devices that `options` name: a list of indices such as `0,2`, the word `all`, or one device. A list may name a
    /// device several times.
    ///
    /// # Errors
    /// Where [`Context::new`] fails for one of them.
    pub fn all(options: &ContextOptions) -> Result<Vec<Arc<Self>>> {
        let text = options.device.as_deref().unwrap_or_default();
        let open = |index: String| Self::new(&ContextOptions { device: Some(index), ..options.clone() });
        if text.trim() == "all" {
            let usable = list_devices()?.into_iter().filter(|device| device.refused.is_none());
            let contexts = usable.map(|device| open(device.index.to_string())).collect::<Result<Vec<_>>>()?;
            if !contexts.is_empty() {
                return Ok(contexts);
            }
        }
        // Names of devices have commas, too.
        let indices: Vec<_> = text.split(',').map(str::trim).collect();
        if indices.len() > 1 && indices.iter().all(|index| index.parse::<usize>().is_ok()) {
            return indices.into_iter().map(|index| open(index.to_owned())).collect();
        }
        Ok(vec![Self::new(options)?])
    }

    /// Name, kind, driver and limits of the device.
    pub fn device(&self) -> &DeviceInfo {
        self.device.info()
    }

    /// Warnings and errors of the validation layer so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.validation_log().messages()
    }

    /// Handle to the validation messages that may outlive the context.
    pub fn validation_log(&self) -> ValidationLog {
        self.device.instance().log().clone()
    }

    /// Keeps a record of every submission from now on. Each dispatch is timed by the device's clock where it has one,
    /// else each submission is timed as a whole. Returns the clock in use. Kernels of one submission no longer overlap
    /// while dispatches are timed.
    pub fn record_timings(&self) -> Clock {
        self.record_timings_by(Clock::Device)
    }

    /// Keeps a record of every submission from now on, timed by the given clock. A device without a clock falls back on
    /// the host's. Returns the clock in use.
    pub fn record_timings_by(&self, clock: Clock) -> Clock {
        let clock = if self.device.timestamp_bits() > 0 { clock } else { Clock::Host };
        self.timings.start(clock);
        clock
    }

    /// Submissions recorded since the last call; empty where no record is kept.
    pub fn take_timings(&self) -> Vec<SubmissionTime> {
        self.timings.take()
    }

    /// Ends the record, so that submissions are no longer timed.
    pub fn stop_timings(&self) {
        self.timings.stop();
    }

    /// Number of bytes that buffers hold now.
    pub fn allocated_bytes(&self) -> u64 {
        self.memory.allocated_bytes()
    }

    /// Largest number of bytes that buffers have held at once.
    pub fn peak_allocated_bytes(&self) -> u64 {
        self.memory.peak_bytes()
    }

    pub(super) fn logical(&self) -> &LogicalDevice {
        &self.device
    }

    pub(super) fn raw(&self) -> &ash::Device {
        self.device.raw()
    }

    pub(super) fn memory(&self) -> &Memory {
        &self.memory
    }

    pub(super) fn idle_slots(&self) -> &IdleSlots {
        &self.idle_slots
    }

    pub(super) fn timings(&self) -> &TimingRecord {
        &self.timings
    }

    pub(super) fn shared_device(&self) -> &Arc<LogicalDevice> {
        &self.device
    }

    pub(super) fn pipelines(&self) -> &Pipelines {
        &self.pipelines
    }

    pub(super) fn pipeline_cache(&self) -> &PipelineCache {
        &self.pipeline_cache
    }
}
