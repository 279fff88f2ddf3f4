//! Vulkan buffers with their memory: the common part of kernel buffers and staging areas.

use std::ptr::NonNull;
use std::sync::{Arc, MutexGuard};

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::context::Context;
use super::fault::failed;
use crate::{Error, Result};

/// Vulkan buffer and the memory bound to it.
pub(super) struct Backing {
    raw: vk::Buffer,
    /// `None` only while the buffer is being made.
    allocation: Option<Allocation>,
    bytes: u64,
    context: Arc<Context>,
}

impl Backing {
    pub(super) fn new(
        context: &Arc<Context>,
        name: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        place: MemoryLocation,
    ) -> Result<Self> {
        let most = context.device().limits.max_allocation_bytes;
        if bytes > most {
            return Err(Error::Device(format!(
                "the buffer `{name}` needs {bytes} bytes, but {} holds at most {most} in one piece",
                context.device().name
            )));
        }
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: invariant 1: the device is alive, and `info` is a local.
        let raw = unsafe { context.raw().create_buffer(&info, None) }
            .map_err(failed(format!("creating the buffer `{name}` of {bytes} bytes")))?;
        let mut backing = Self { raw, allocation: None, bytes, context: Arc::clone(context) };
        context.logical().name(raw, name);
        backing.bind(name, place)?;
        Ok(backing)
    }

    fn bind(&mut self, name: &str, place: MemoryLocation) -> Result<()> {
        // SAFETY: invariant 1: the buffer is alive and owned by this value.
        let needs = unsafe { self.context.raw().get_buffer_memory_requirements(self.raw) };
        let allocation = self.context.memory().allocate(name, needs, place)?;
        let allocation = self.allocation.insert(allocation);
        // SAFETY: invariant 1: buffer and memory are alive and owned by this value, of the size and alignment asked
        // for, and the buffer is not yet bound.
        unsafe { self.context.raw().bind_buffer_memory(self.raw, allocation.memory(), allocation.offset()) }
            .map_err(failed(format!("binding memory to the buffer `{name}`")))
    }

    /// Handle of the buffer, for a call during which the caller borrows this value.
    pub(super) fn raw(&self) -> vk::Buffer {
        self.raw
    }

    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(super) fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// The memory as the host sees it; `None` where it is not mapped. Waits until the device is idle and keeps it idle
    /// while held: do not submit in the meantime.
    pub(super) fn mapped(&self) -> Option<Mapped<'_>> {
        let allocation = self.allocation.as_ref()?;
        let start = allocation.mapped_ptr()?.cast();
        let idle = self.context.logical().idle_queue();
        Some(Mapped { backing: self, allocation, start, _idle: idle })
    }

    /// Whether the host reads the memory through its cache. Without a cache, copying first is faster than reading.
    pub(super) fn is_host_cached(&self) -> bool {
        let properties = self.allocation.as_ref().map(Allocation::memory_properties).unwrap_or_default();
        properties.contains(vk::MemoryPropertyFlags::HOST_CACHED)
    }
}

impl Drop for Backing {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 3: owned by this value alone, and no submission that used it is under way.
        unsafe { self.context.raw().destroy_buffer(self.raw, None) }
        if let Some(allocation) = self.allocation.take() {
            self.context.memory().free(allocation);
        }
    }
}

/// Buffer memory as the host sees it. The device is idle while this value lives.
pub(super) struct Mapped<'a> {
    backing: &'a Backing,
    allocation: &'a Allocation,
    start: NonNull<u8>,
    _idle: MutexGuard<'a, vk::Queue>,
}

impl Mapped<'_> {
    pub(super) fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        let start = self.place(offset, bytes.len());
        // SAFETY: `place` has checked the range; invariants 1 and 3: the memory is mapped while the buffer lives, and
        // neither the device nor another thread touches it while the queue is held. `bytes` is host memory: no overlap.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), start, bytes.len()) };
        match self.incoherent_range(offset, bytes.len()) {
            // SAFETY: invariant 1: the memory is alive and mapped, the range inside it and in whole atoms.
            Some(range) => unsafe { self.backing.context.raw().flush_mapped_memory_ranges(&[range]) }
                .map_err(failed("vkFlushMappedMemoryRanges")),
            None => Ok(()),
        }
    }

    pub(super) fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<()> {
        let start = self.place(offset, bytes.len());
        if let Some(range) = self.incoherent_range(offset, bytes.len()) {
            // SAFETY: invariant 1: the memory is alive and mapped, the range inside it and in whole atoms.
            unsafe { self.backing.context.raw().invalidate_mapped_memory_ranges(&[range]) }
                .map_err(failed("vkInvalidateMappedMemoryRanges"))?;
        }
        // SAFETY: invariants 1 and 3, as in `write`; every buffer is filled before it is read, so the memory is
        // initialized.
        unsafe { std::ptr::copy_nonoverlapping(start.cast_const(), bytes.as_mut_ptr(), bytes.len()) };
        Ok(())
    }

    fn place(&self, offset: u64, len: usize) -> *mut u8 {
        check_range(self.backing.bytes, offset, len as u64);
        // SAFETY: invariant 1: the range is inside the buffer, which lives and is mapped whole, so `offset` fits in a
        // usize.
        unsafe { self.start.as_ptr().add(offset as usize) }
    }

    /// Range of whole atoms around a range of bytes, for flushing and invalidating; `None` where memory is coherent.
    fn incoherent_range(&self, offset: u64, len: usize) -> Option<vk::MappedMemoryRange<'static>> {
        if len == 0 || self.allocation.memory_properties().contains(vk::MemoryPropertyFlags::HOST_COHERENT) {
            return None;
        }
        let atom = self.backing.context.device().limits.non_coherent_atom_bytes.max(1);
        let (begin, bytes) = whole_atoms(offset, len as u64, atom, self.allocation.size());
        // SAFETY: invariant 1: the handle is used by the caller alone, while the allocation is borrowed.
        let memory = unsafe { self.allocation.memory() };
        Some(vk::MappedMemoryRange::default().memory(memory).offset(self.allocation.offset() + begin).size(bytes))
    }
}

/// Start and length in bytes of the atoms that a range touches. `Memory::allocate` has rounded the allocation up to
/// whole atoms.
fn whole_atoms(offset: u64, len: u64, atom: u64, allocated: u64) -> (u64, u64) {
    let begin = offset / atom * atom;
    let end = (offset + len).next_multiple_of(atom).min(allocated);
    (begin, end - begin)
}

/// Checks that a range lies inside a buffer of `bytes` bytes.
///
/// # Panics
/// Where it does not: the caller's mistake.
pub(super) fn check_range(bytes: u64, offset: u64, len: u64) {
    let end = offset.checked_add(len);
    assert!(end.is_some_and(|end| end <= bytes), "{len} bytes at {offset} are outside a buffer of {bytes}");
}

#[cfg(test)]
mod tests {
    use super::whole_atoms;

    #[test]
    fn flushed_ranges_are_whole_atoms() {
        assert_eq!(whole_atoms(0, 1, 64, 256), (0, 64));
        assert_eq!(whole_atoms(63, 2, 64, 256), (0, 128));
        assert_eq!(whole_atoms(64, 64, 64, 256), (64, 64));
        assert_eq!(whole_atoms(200, 56, 64, 256), (192, 64));
        assert_eq!(whole_atoms(5, 7, 1, 12), (5, 7));
    }
}
