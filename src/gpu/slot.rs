//! Slot of a submission: its command buffer, fence and timestamp queries.

use std::cell::Cell;
use std::mem;
use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::idle_slots::Handles;
use super::queries::Timestamps;
use crate::Result;

/// Handles of one submission, returned to the idle ones when dropped.
pub(super) struct Slot {
    handles: Handles,
    /// Whether the handles can serve another submission: not while one is under way, nor after a failed one.
    reusable: Cell<bool>,
    context: Arc<Context>,
}

impl Slot {
    pub(super) fn take(context: &Arc<Context>) -> Result<Self> {
        let idle = context.idle_slots().take();
        let is_new = idle.is_none();
        let mut slot =
            Self { handles: idle.unwrap_or_default(), reusable: Cell::new(false), context: Arc::clone(context) };
        match is_new {
            true => slot.handles.create(context.logical())?,
            false => slot.handles.reset(context.logical())?,
        }
        slot.reusable.set(true);
        Ok(slot)
    }

    /// Sets whether the handles may be reused: `false` before a submission, `true` once it is done.
    pub(super) fn set_reusable(&self, reusable: bool) {
        self.reusable.set(reusable);
    }

    pub(super) fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// Handle of the command buffer, for a call during which the caller borrows this value.
    pub(super) fn commands(&self) -> vk::CommandBuffer {
        self.handles.commands
    }

    /// Handle of the fence, for a call during which the caller borrows this value.
    pub(super) fn fence(&self) -> vk::Fence {
        self.handles.fence
    }

    /// Timestamps of the submission; `None` where the queue has none.
    pub(super) fn timestamps(&self) -> Option<Timestamps<'_>> {
        let queries = self.handles.queries;
        (queries != vk::QueryPool::null()).then(|| Timestamps::new(self.context.logical(), queries))
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        let handles = mem::take(&mut self.handles);
        match self.reusable.get() {
            true => self.context.idle_slots().put(handles),
            false => handles.destroy(self.context.logical()),
        }
    }
}
