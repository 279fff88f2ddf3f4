//! Acceleration structures, which kernels traverse by ray queries.

use std::sync::Arc;

use ash::vk;

use super::context::Context;

/// Something that must live as long as a structure.
pub(super) type Kept = Arc<dyn Send + Sync>;

/// Acceleration structure within a buffer. `Buffer` declares its backing after this value, so that the structure is destroyed first.
pub(super) struct Structure {
    raw: vk::AccelerationStructureKHR,
    // Order of dropping: the structure, then the structures that it refers to.
    _kept: Vec<Kept>,
    context: Arc<Context>,
}

impl Structure {
    /// Takes a structure, which nothing else owns, and the buffers of the structures that it refers to.
    pub(super) fn new(context: &Arc<Context>, raw: vk::AccelerationStructureKHR, kept: Vec<Kept>) -> Self {
        Self { raw, _kept: kept, context: Arc::clone(context) }
    }

    /// Handle of the structure, for a call during which the caller borrows this value.
    pub(super) fn raw(&self) -> vk::AccelerationStructureKHR {
        self.raw
    }
}

impl Drop for Structure {
    fn drop(&mut self) {
        if let Some(structures) = self.context.logical().structures() {
            // SAFETY: invariants 1 and 3: owned by this value alone, and no submission that used it is under way.
            unsafe { structures.destroy_acceleration_structure(self.raw, None) }
        }
    }
}
