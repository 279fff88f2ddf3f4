//! Device memory and a count of the bytes in use.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationError, AllocationSizes, AllocatorDebugSettings, MemoryLocation};

use super::device::LogicalDevice;
use crate::{Error, Result};

/// Alignment in bytes of all buffers. Devices read instances of acceleration structures at multiples of it.
const LEAST_ALIGNMENT: u64 = 16;

/// Size in bytes of a block that small buffers share; larger buffers have their own.
const BLOCK_BYTES: u64 = 32 << 20;

/// Allocator with a count of the bytes that it gave out.
pub(super) struct Memory {
    // Declared before the device, because it frees its blocks when dropped.
    allocator: Mutex<Allocator>,
    allocated_bytes: AtomicU64,
    peak_bytes: AtomicU64,
    device: Arc<LogicalDevice>,
}

impl Memory {
    pub(super) fn new(device: Arc<LogicalDevice>) -> Result<Self> {
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: device.instance().raw().clone(),
            device: device.raw().clone(),
            physical_device: device.physical(),
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: device.info().limits.has_ray_queries,
            allocation_sizes: AllocationSizes::new(BLOCK_BYTES, BLOCK_BYTES),
        })
        .map_err(|error| Error::Vulkan { call: "creating the memory allocator".into(), reason: error.to_string() })?;
        let (allocated_bytes, peak_bytes) = (AtomicU64::new(0), AtomicU64::new(0));
        Ok(Self { allocator: Mutex::new(allocator), allocated_bytes, peak_bytes, device })
    }

    /// Allocates memory for a buffer. Size and offset are rounded to whole atoms of incoherent memory, so that a flush
    /// of one buffer never reaches outside it.
    pub(super) fn allocate(
        &self,
        name: &str,
        needs: vk::MemoryRequirements,
        place: MemoryLocation,
    ) -> Result<Allocation> {
        let atom = self.device.info().limits.non_coherent_atom_bytes.max(1);
        let requirements =
            needs.size(needs.size.next_multiple_of(atom)).alignment(needs.alignment.max(atom).max(LEAST_ALIGNMENT));
        let description = AllocationCreateDesc {
            name,
            requirements,
            location: place,
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let mut allocator = self.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        let allocation = allocator.allocate(&description).map_err(|error| self.refusal(name, needs.size, &error))?;
        let in_use = self.allocated_bytes.fetch_add(allocation.size(), Ordering::Relaxed) + allocation.size();
        self.peak_bytes.fetch_max(in_use, Ordering::Relaxed);
        Ok(allocation)
    }

    pub(super) fn free(&self, allocation: Allocation) {
        let bytes = allocation.size();
        let mut allocator = self.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        match allocator.free(allocation) {
            Ok(()) => _ = self.allocated_bytes.fetch_sub(bytes, Ordering::Relaxed),
            Err(error) => tracing::warn!("device memory was not freed: {error}"),
        }
    }

    pub(super) fn allocated_bytes(&self) -> u64 {
        self.allocated_bytes.load(Ordering::Relaxed)
    }

    pub(super) fn peak_bytes(&self) -> u64 {
        self.peak_bytes.load(Ordering::Relaxed)
    }

    fn refusal(&self, name: &str, bytes: u64, error: &AllocationError) -> Error {
        let (call, note) = (format!("allocating {bytes} bytes for the buffer `{name}`"), String::new());
        let fault = match error {
            // Mapping fails where the host's address space has no room.
            AllocationError::OutOfMemory | AllocationError::FailedToMap(_) => Error::OutOfDeviceMemory { call, note },
            other => Error::Vulkan { call, reason: other.to_string() },
        };
        fault.noting(&format!("{} bytes were already in use", self.allocated_bytes()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Buffer, BufferKind, Context, ContextOptions};

    /// Asks for more than a heap holds, which the allocator itself refuses.
    #[test]
    fn out_of_memory_is_a_sentence() {
        let context = Context::new(&ContextOptions { device: None, validate: true }).expect("a device");
        let buffer = Buffer::new(&context, "small", 4096, BufferKind::Storage).expect("a buffer");
        let needs = vk::MemoryRequirements { size: 1 << 60, alignment: 64, memory_type_bits: !0 };
        let refused = context.memory().allocate("large", needs, MemoryLocation::GpuOnly);
        let in_use = context.allocated_bytes();
        assert!(in_use >= buffer.len_bytes());
        assert_eq!(
            refused.map(|_| ()).expect_err("a refusal").to_string(),
            format!(
                "allocating 1152921504606846976 bytes for the buffer `large` failed: \
                 out of device memory; {in_use} bytes were already in use"
            )
        );
    }
}
