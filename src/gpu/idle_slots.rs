//! Idle slots: command buffers, fences and timestamp queries that no submission uses. They are kept for later
//! submissions, because some drivers take as long to make them as to run a small dispatch.

use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

use super::device::LogicalDevice;
use super::fault::failed;
use super::queries::QUERY_COUNT;
use crate::Result;

/// Command buffer with its pool, a fence, and timestamp queries (null where the queue has no timestamps).
#[derive(Default)]
pub(super) struct Handles {
    pub(super) pool: vk::CommandPool,
    pub(super) commands: vk::CommandBuffer,
    pub(super) fence: vk::Fence,
    pub(super) queries: vk::QueryPool,
}

impl Handles {
    /// Makes all handles in place, so that handles made before an error have an owner.
    pub(super) fn create(&mut self, device: &LogicalDevice) -> Result<()> {
        let raw = device.raw();
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(device.queue_family());
        // SAFETY: invariant 1: the device is alive, and `pool` is a local.
        self.pool = unsafe { raw.create_command_pool(&pool, None) }.map_err(failed("vkCreateCommandPool"))?;
        let buffer = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: invariant 1: the pool is alive and owned by this value alone.
        let buffers = unsafe { raw.allocate_command_buffers(&buffer) };
        self.commands = buffers.map_err(failed("vkAllocateCommandBuffers"))?[0];
        // SAFETY: invariant 1: the device is alive.
        self.fence =
            unsafe { raw.create_fence(&vk::FenceCreateInfo::default(), None) }.map_err(failed("vkCreateFence"))?;
        if device.timestamp_bits() > 0 {
            let queries =
                vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(QUERY_COUNT);
            // SAFETY: invariant 1: the device is alive, and `queries` is a local.
            self.queries = unsafe { raw.create_query_pool(&queries, None) }.map_err(failed("vkCreateQueryPool"))?;
        }
        Ok(())
    }

    /// Resets pool and fence for another submission.
    pub(super) fn reset(&self, device: &LogicalDevice) -> Result<()> {
        // SAFETY: invariants 1 and 3: owned by this value alone, and no submission that used them is under way.
        unsafe {
            device
                .raw()
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .map_err(failed("vkResetCommandPool"))?;
            device.raw().reset_fences(&[self.fence]).map_err(failed("vkResetFences"))
        }
    }

    pub(super) fn destroy(self, device: &LogicalDevice) {
        // SAFETY: invariants 1 and 3: owned by this value alone (null is allowed), and no submission that used them is
        // under way.
        unsafe {
            device.raw().destroy_query_pool(self.queries, None);
            device.raw().destroy_fence(self.fence, None);
            device.raw().destroy_command_pool(self.pool, None);
        }
    }
}

/// Handles that no submission uses.
pub(super) struct IdleSlots {
    idle: Mutex<Vec<Handles>>,
    device: Arc<LogicalDevice>,
}

impl IdleSlots {
    pub(super) fn new(device: Arc<LogicalDevice>) -> Self {
        Self { idle: Mutex::default(), device }
    }

    pub(super) fn take(&self) -> Option<Handles> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop()
    }

    pub(super) fn put(&self, handles: Handles) {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(handles);
    }
}

impl Drop for IdleSlots {
    fn drop(&mut self) {
        let idle = self.idle.get_mut().unwrap_or_else(PoisonError::into_inner);
        idle.drain(..).for_each(|handles| handles.destroy(&self.device));
    }
}
