//! A device, ready for work.

use std::sync::Arc;

use ash::vk;

use super::debug::ValidationLog;
use super::device::LogicalDevice;
use super::device_info::DeviceInfo;
use super::instance::Instance;
use super::memory::Memory;
use super::pipeline_cache::PipelineCache;
use super::selection;
use super::slots::IdleSlots;
use super::timing::{Clock, SubmissionTime, TimingRecord};
use crate::Result;

/// How to open a device.
#[derive(Debug, Clone, Default)]
pub struct ContextOptions {
    /// Its index, or a part of its name in any case; without it, the best one: discrete, integrated, virtual, CPU, other.
    pub device: Option<String>,
    /// Whether the validation layer watches.
    pub validate: bool,
}

/// A Vulkan device, its memory and its pipelines. All that is made from it holds it.
pub struct Context {
    // These hold the device too; it goes last.
    pipeline_cache: PipelineCache,
    memory: Memory,
    idle_slots: IdleSlots,
    timings: TimingRecord,
    device: Arc<LogicalDevice>,
}

/// All Vulkan devices, usable or not.
///
/// # Errors
/// Where no loader or no driver is installed.
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
    /// Where no loader, driver or validation layer is installed, the wanted device is unknown, or none can be used.
    pub fn new(options: &ContextOptions) -> Result<Arc<Self>> {
        let instance = Instance::new(options.validate)?;
        let physical = instance.physical_devices()?;
        let devices = describe(&instance, &physical);
        let chosen = selection::choose(&devices, options.device.as_deref())?;
        tracing::debug!(device = chosen.name, driver = chosen.driver_info, "opening a Vulkan device");
        let device = Arc::new(LogicalDevice::new(instance, physical[chosen.index], chosen.clone())?);
        let pipeline_cache = PipelineCache::new(Arc::clone(&device))?;
        let memory = Memory::new(Arc::clone(&device))?;
        let idle_slots = IdleSlots::new(Arc::clone(&device));
        Ok(Arc::new(Self { pipeline_cache, memory, idle_slots, timings: TimingRecord::default(), device }))
    }

    /// What the device is and allows.
    pub fn device(&self) -> &DeviceInfo {
        self.device.info()
    }

    /// The validation layer's warnings and errors so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.validation_log().messages()
    }

    /// A handle to those messages that outlives the context.
    pub fn validation_log(&self) -> ValidationLog {
        self.device.instance().log().clone()
    }

    /// Keeps a record of every submission from now on: each dispatch by the device's clock where it has one, else each
    /// submission as a whole. Returns whose clock it is. Kernels of one submission then no longer overlap.
    pub fn record_timings(&self) -> Clock {
        self.record_timings_by(Clock::Device)
    }

    /// The same by a clock of the caller's choice; a device without one gives way to the host's.
    pub fn record_timings_by(&self, clock: Clock) -> Clock {
        let clock = if self.device.timestamp_bits() > 0 { clock } else { Clock::Host };
        self.timings.start(clock);
        clock
    }

    /// The submissions since the last call, where a record is kept.
    pub fn take_timings(&self) -> Vec<SubmissionTime> {
        self.timings.take()
    }

    /// Bytes that buffers hold now.
    pub fn allocated_bytes(&self) -> u64 {
        self.memory.allocated_bytes()
    }

    /// The most bytes that buffers ever held at once.
    pub fn peak_allocated_bytes(&self) -> u64 {
        self.memory.peak_bytes()
    }

    /// Writes the compiled pipelines to the user's cache folder, for a faster start next time. Also done, silently, when the
    /// context is dropped.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn save_pipeline_cache(&self) -> Result<()> {
        self.pipeline_cache.save()
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

    pub(super) fn pipeline_cache(&self) -> &PipelineCache {
        &self.pipeline_cache
    }
}
