//! Buffers that kernels read and write.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;

use super::backing::{Backing, check_range};
use super::context::Context;
use super::fault::failed;
use super::structure::Structure;
use crate::generated::interface::BindingKind;
use crate::{Error, Result};

/// Bytes of a texel: four numbers of 32 bits, unless the buffer's kind says otherwise.
const TEXEL_BYTES: u64 = 16;

/// Largest uniform buffer in bytes that every Vulkan device allows.
const MAX_UNIFORM_BYTES: u64 = 16384;

/// Limit in bytes of the staging area through which data travels to buffers that the host cannot reach.
const STAGING_BYTES: usize = 16 << 20;

/// Ways in which kernels see a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BufferKind {
    /// Storage buffer, read and written.
    Storage,
    /// Small buffer that is equal for every invocation.
    Uniform,
    /// Texel buffer of four floats, read only.
    TexelFloat,
    /// Texel buffer of four unsigned integers, read only.
    TexelUint,
    /// Texel buffer of one unsigned integer, read only.
    TexelUint1,
    /// Target of copies that no kernel sees. Its memory is near the host, which reads it in place where the memory is
    /// cached.
    Readback,
    /// Storage buffer, also read as texels of one float.
    StorageTexelFloat1,
    /// Storage buffer, also read as texels of four unsigned integers.
    StorageTexelUint,
    /// Geometry from which the device builds an acceleration structure. No kernel sees it.
    BuildInput,
    /// Scratch memory with which the device builds an acceleration structure. No kernel sees it.
    BuildScratch,
    /// Acceleration structure. [`Buffer::acceleration_structure`] makes it. The host and copies do not touch it.
    AccelerationStructure,
}

impl BufferKind {
    /// Whether a buffer of this kind fits a binding of the given kind.
    pub fn fits(self, binding: BindingKind) -> bool {
        match binding {
            BindingKind::StorageBuffer => self.is_storage(),
            BindingKind::UniformBuffer => self == Self::Uniform,
            BindingKind::TexelBufferFloat => {
                matches!(self, Self::TexelFloat | Self::StorageTexelFloat1)
            }
            BindingKind::TexelBufferUint => matches!(self, Self::TexelUint | Self::TexelUint1 | Self::StorageTexelUint),
            BindingKind::AccelerationStructure => self == Self::AccelerationStructure,
        }
    }

    fn is_storage(self) -> bool {
        matches!(self, Self::Storage | Self::StorageTexelFloat1 | Self::StorageTexelUint)
    }

    fn usage(self) -> vk::BufferUsageFlags {
        let own = match self {
            Self::Storage => vk::BufferUsageFlags::STORAGE_BUFFER,
            Self::Readback => vk::BufferUsageFlags::empty(),
            Self::Uniform => vk::BufferUsageFlags::UNIFORM_BUFFER,
            Self::TexelFloat | Self::TexelUint | Self::TexelUint1 => vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER,
            Self::StorageTexelFloat1 | Self::StorageTexelUint => {
                vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
            }
            Self::BuildInput => {
                vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
                    | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS
            }
            Self::BuildScratch => vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS,
            Self::AccelerationStructure => {
                vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS
            }
        };
        match self {
            Self::BuildScratch | Self::AccelerationStructure => own,
            _ => own | vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST,
        }
    }

    /// Whether only the building of acceleration structures uses such buffers.
    fn is_of_structures(self) -> bool {
        matches!(self, Self::BuildInput | Self::BuildScratch | Self::AccelerationStructure)
    }

    fn place(self) -> MemoryLocation {
        match self {
            Self::Readback => MemoryLocation::GpuToCpu,
            _ => MemoryLocation::GpuOnly,
        }
    }

    fn texel_format(self) -> Option<vk::Format> {
        match self {
            Self::Storage
            | Self::Uniform
            | Self::Readback
            | Self::BuildInput
            | Self::BuildScratch
            | Self::AccelerationStructure => None,
            Self::TexelFloat => Some(vk::Format::R32G32B32A32_SFLOAT),
            Self::StorageTexelFloat1 => Some(vk::Format::R32_SFLOAT),
            Self::TexelUint | Self::StorageTexelUint => Some(vk::Format::R32G32B32A32_UINT),
            Self::TexelUint1 => Some(vk::Format::R32_UINT),
        }
    }
}

/// Buffer in device memory, or in host memory where its kind says so.
pub struct Buffer {
    /// Null where kernels see no texels.
    view: vk::BufferView,
    /// `None` where the buffer holds no acceleration structure.
    structure: Option<Structure>,
    kind: BufferKind,
    name: String,
    /// Whether the buffer stands for zeros that its memory does not hold yet.
    is_blank: AtomicBool,
    // Declared last, because view and structure must be destroyed first.
    backing: Backing,
}

impl Buffer {
    /// Makes a buffer of zeros. Its size is rounded up to a multiple of 16 bytes and is at least 16, because an empty
    /// scene has buffers too.
    ///
    /// # Errors
    /// [`Error::Device`] where the device does not allow the size; other errors where it is out of memory or lost.
    ///
    /// # Panics
    /// Where the kind is one of acceleration structures.
    pub fn new(context: &Arc<Context>, name: &str, bytes: u64, kind: BufferKind) -> Result<Arc<Self>> {
        assert!(!kind.is_of_structures(), "`{name}` is made with an acceleration structure only");
        Self::cleared(context, name, bytes, kind)
    }

    fn cleared(context: &Arc<Context>, name: &str, bytes: u64, kind: BufferKind) -> Result<Arc<Self>> {
        let buffer = Self::uncleared(context, name, bytes, kind)?;
        context.submit(&format!("clearing `{name}`"), |recorder| recorder.fill_zero(&buffer))?;
        Ok(Arc::new(buffer))
    }

    /// Makes a buffer of zeros, as [`Buffer::new`] does, but writes the zeros only when they are needed. The memory of a large film
    /// whose render ends early is then never touched. Kernels may see the buffer after [`Buffer::write_zeros`].
    ///
    /// # Errors
    /// All errors of [`Buffer::new`].
    ///
    /// # Panics
    /// Where the kind is one of acceleration structures.
    pub(crate) fn blank(context: &Arc<Context>, name: &str, bytes: u64, kind: BufferKind) -> Result<Arc<Self>> {
        assert!(!kind.is_of_structures(), "`{name}` is made with an acceleration structure only");
        let mut buffer = Self::uncleared(context, name, bytes, kind)?;
        buffer.is_blank = AtomicBool::new(true);
        Ok(Arc::new(buffer))
    }

    /// Whether the buffer stands for zeros that its memory does not hold yet.
    pub(crate) fn is_blank(&self) -> bool {
        self.is_blank.load(Ordering::Relaxed)
    }

    /// Writes the zeros of a [blank](Buffer::blank) buffer. Any other buffer keeps its values.
    ///
    /// # Errors
    /// Where the device is lost or out of memory.
    pub(crate) fn write_zeros(&self) -> Result<()> {
        if self.is_blank() {
            self.context().submit(&format!("clearing `{}`", self.name), |recorder| recorder.fill_zero(self))?;
            self.is_blank.store(false, Ordering::Relaxed);
        }
        Ok(())
    }

    /// Makes a buffer of these values, followed by zeros where its size is rounded up.
    ///
    /// # Errors
    /// All errors of [`Buffer::new`], and [`Error::DeviceLost`].
    ///
    /// # Panics
    /// Where the kind is one of acceleration structures.
    pub fn with_values<T: Pod>(
        context: &Arc<Context>,
        name: &str,
        values: &[T],
        kind: BufferKind,
    ) -> Result<Arc<Self>> {
        assert!(!kind.is_of_structures(), "`{name}` is made with an acceleration structure only");
        Self::filled(context, name, values, kind)
    }

    /// Makes a buffer of any kind of these values.
    pub(super) fn filled<T: Pod>(
        context: &Arc<Context>,
        name: &str,
        values: &[T],
        kind: BufferKind,
    ) -> Result<Arc<Self>> {
        let bytes = size_of_val(values) as u64;
        // A buffer that is overwritten as a whole need not be cleared.
        let is_filled = bytes > 0 && bytes.is_multiple_of(TEXEL_BYTES);
        let buffer = match is_filled {
            true => Arc::new(Self::uncleared(context, name, bytes, kind)?),
            false => Self::cleared(context, name, bytes, kind)?,
        };
        buffer.upload(0, values)?;
        Ok(buffer)
    }

    /// Makes a buffer that something must fill before it is read.
    pub(super) fn uncleared(context: &Arc<Context>, name: &str, bytes: u64, kind: BufferKind) -> Result<Self> {
        let bytes = bytes.max(1).checked_next_multiple_of(TEXEL_BYTES).unwrap_or(u64::MAX);
        check_size(context, name, bytes, kind)?;
        let backing = Backing::new(context, name, bytes, kind.usage(), kind.place())?;
        let (view, is_blank) = (vk::BufferView::null(), AtomicBool::new(false));
        let mut buffer = Self { view, structure: None, kind, name: name.into(), is_blank, backing };
        if let Some(format) = kind.texel_format() {
            buffer.create_view(format)?;
        }
        Ok(buffer)
    }

    fn create_view(&mut self, format: vk::Format) -> Result<()> {
        let context = self.context();
        check_format(context, format, &self.name)?;
        let info =
            vk::BufferViewCreateInfo::default().buffer(self.backing.raw()).format(format).range(self.backing.bytes());
        // SAFETY: invariant 1: device and buffer are alive, and `info` is a local.
        let view = unsafe { context.raw().create_buffer_view(&info, None) }
            .map_err(failed(format!("creating a view of the buffer `{}`", self.name)))?;
        context.logical().name(view, &self.name);
        self.view = view;
        Ok(())
    }

    /// Size in bytes, rounded up.
    pub fn len_bytes(&self) -> u64 {
        self.backing.bytes()
    }

    /// How kernels see the buffer.
    pub fn kind(&self) -> BufferKind {
        self.kind
    }

    /// The buffer's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Copies values into the buffer at `offset_bytes`. Waits for work under way.
    ///
    /// # Errors
    /// Where the device is lost or out of memory.
    ///
    /// # Panics
    /// Where the values do not fit, or the buffer holds an acceleration structure.
    pub fn upload<T: Pod>(&self, offset_bytes: u64, values: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        self.check_reachable();
        check_range(self.len_bytes(), offset_bytes, bytes.len() as u64);
        self.write_zeros()?;
        if let Some(mapped) = self.backing.mapped() {
            return mapped.write(offset_bytes, bytes);
        }
        self.upload_staged(offset_bytes, bytes)
    }

    /// Copies `count` values out of the buffer, from `offset_bytes`. Waits for work under way.
    ///
    /// # Errors
    /// Where the device is lost or out of memory.
    ///
    /// # Panics
    /// Where the buffer does not hold that many, or holds an acceleration structure.
    pub fn read<T: Pod>(&self, offset_bytes: u64, count: usize) -> Result<Vec<T>> {
        let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
        self.check_reachable();
        check_range(self.len_bytes(), offset_bytes, bytes);
        let mut values = vec![T::zeroed(); count];
        if self.is_blank() {
            return Ok(values);
        }
        let bytes = bytemuck::cast_slice_mut(&mut values);
        match self.backing.mapped().filter(|_| self.backing.is_host_cached()) {
            Some(mapped) => mapped.read(offset_bytes, bytes)?,
            None => self.read_staged(offset_bytes, bytes)?,
        }
        Ok(values)
    }

    fn upload_staged(&self, mut offset: u64, bytes: &[u8]) -> Result<()> {
        let staging = self.staging(bytes.len(), MemoryLocation::CpuToGpu)?;
        for chunk in bytes.chunks(STAGING_BYTES) {
            staging.mapped().ok_or_else(unmapped)?.write(0, chunk)?;
            self.context().submit(&format!("uploading `{}`", self.name), |recorder| {
                recorder.copy_backing(&staging, 0, &self.backing, offset, chunk.len() as u64);
            })?;
            offset += chunk.len() as u64;
        }
        Ok(())
    }

    fn read_staged(&self, mut offset: u64, bytes: &mut [u8]) -> Result<()> {
        let staging = self.staging(bytes.len(), MemoryLocation::GpuToCpu)?;
        for chunk in bytes.chunks_mut(STAGING_BYTES) {
            self.context().submit(&format!("reading `{}`", self.name), |recorder| {
                recorder.copy_backing(&self.backing, offset, &staging, 0, chunk.len() as u64);
            })?;
            staging.mapped().ok_or_else(unmapped)?.read(0, chunk)?;
            offset += chunk.len() as u64;
        }
        Ok(())
    }

    fn staging(&self, bytes: usize, place: MemoryLocation) -> Result<Backing> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let bytes = bytes.clamp(1, STAGING_BYTES) as u64;
        Backing::new(self.context(), &format!("staging of {}", self.name), bytes, usage, place)
    }

    pub(super) fn backing(&self) -> &Backing {
        &self.backing
    }

    pub(super) fn context(&self) -> &Arc<Context> {
        self.backing.context()
    }

    /// Checks that the host and copies may touch the buffer. An acceleration structure with other content could lead the device
    /// anywhere.
    pub(super) fn check_reachable(&self) {
        let is_closed = self.structure.is_some();
        assert!(!is_closed, "`{}` holds an acceleration structure, which nothing else may touch", self.name);
    }

    /// The buffer with the acceleration structure that it will hold.
    pub(super) fn with_structure(mut self, structure: Structure) -> Self {
        self.structure = Some(structure);
        self
    }

    /// Acceleration structure that the buffer holds, for a call during which the caller borrows this value; null where it holds
    /// none.
    pub(super) fn structure(&self) -> vk::AccelerationStructureKHR {
        self.structure.as_ref().map_or(vk::AccelerationStructureKHR::null(), Structure::raw)
    }

    /// View of the buffer's texels, for a call during which the caller borrows this value; null where kernels see no
    /// texels.
    pub(super) fn view(&self) -> vk::BufferView {
        self.view
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 3: owned by this value alone (null is allowed), and no submission that used it is
        // under way.
        unsafe { self.context().raw().destroy_buffer_view(self.view, None) }
    }
}

fn check_size(context: &Context, name: &str, bytes: u64, kind: BufferKind) -> Result<()> {
    let limits = &context.device().limits;
    let texels = |texel_bytes| ("texel", limits.max_texel_elements.saturating_mul(texel_bytes));
    let storage = ("storage", limits.max_storage_buffer_bytes);
    let bounds = match kind {
        BufferKind::Readback
        | BufferKind::BuildInput
        | BufferKind::BuildScratch
        | BufferKind::AccelerationStructure => vec![],
        BufferKind::Storage => vec![storage],
        BufferKind::Uniform => vec![("uniform", MAX_UNIFORM_BYTES)],
        BufferKind::TexelFloat | BufferKind::TexelUint => vec![texels(TEXEL_BYTES)],
        BufferKind::TexelUint1 => vec![texels(TEXEL_BYTES / 4)],
        BufferKind::StorageTexelUint => vec![storage, texels(TEXEL_BYTES)],
        BufferKind::StorageTexelFloat1 => vec![storage, texels(TEXEL_BYTES / 4)],
    };
    let device = &context.device().name;
    match bounds.into_iter().find(|&(_, most)| bytes > most) {
        None => Ok(()),
        Some((what, most)) => Err(Error::Device(format!(
            "the buffer `{name}` needs {bytes} bytes, but {device} allows {most} in a {what} buffer"
        ))),
    }
}

fn check_format(context: &Context, format: vk::Format, name: &str) -> Result<()> {
    let device = context.logical();
    // SAFETY: invariant 1: the physical device comes from the living instance.
    let offered = unsafe { device.instance().raw().get_physical_device_format_properties(device.physical(), format) };
    if offered.buffer_features.contains(vk::FormatFeatureFlags::UNIFORM_TEXEL_BUFFER) {
        return Ok(());
    }
    let device = &context.device().name;
    Err(Error::Device(format!("the buffer `{name}` needs texels of format {format:?}, which {device} does not offer")))
}

fn unmapped() -> Error {
    Error::Vulkan { call: "mapping a staging buffer".into(), reason: "the driver mapped no memory".into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::ContextOptions;

    /// Tests staged copies directly: lavapipe's memory is visible to the host, so other tests never take these paths.
    #[test]
    fn staged_transfers_cross_chunks_at_odd_offsets() {
        let options = ContextOptions { device: None, validate: true };
        let context = Context::new(&options).expect("a device");
        let sent: Vec<u8> = (0..STAGING_BYTES + 12_345).map(|i| (i * 31 % 251) as u8).collect();
        let buffer = Buffer::new(&context, "staged", sent.len() as u64 + 64, BufferKind::Storage).expect("a buffer");
        buffer.upload_staged(7, &sent).expect("an upload");
        let mut back = vec![0; sent.len()];
        buffer.read_staged(7, &mut back).expect("a read");
        assert!(sent == back, "what was sent comes back");
        assert_eq!(buffer.read::<u8>(0, 7).expect("a read"), [0; 7]);
        assert_eq!(buffer.read::<u8>(7, 100).expect("a read"), sent[..100]);
        let (log, allocated) = (context.validation_log(), context.allocated_bytes());
        assert_eq!(allocated, buffer.len_bytes().next_multiple_of(64), "the staging areas are gone");
        drop((buffer, context));
        assert_eq!(log.messages(), [""; 0]);
    }
}
