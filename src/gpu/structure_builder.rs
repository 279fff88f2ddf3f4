//! Acceleration structures that the device builds from triangles and boxes.

use std::sync::Arc;

use ash::{khr, vk};
use bytemuck::{Pod, Zeroable};

use super::buffer::{Buffer, BufferKind};
use super::commands::Recorder;
use super::context::Context;
use super::fault::failed;
use super::fault_injection::{self, May};
use super::structure::{Kept, Structure};
use crate::{Error, Result};

/// Part of an acceleration structure: elements of one kind.
#[derive(Debug, Clone, Copy)]
pub enum StructurePart<'a> {
    /// Triangles by their corners. The device takes the nearest one by itself, unless a ray query asks for candidates.
    OpaqueTriangles(&'a [[[f32; 3]; 3]]),
    /// Triangles by their corners. Each one that a ray meets is a candidate, on which the kernel decides.
    Triangles(&'a [[[f32; 3]; 3]]),
    /// Boxes by their lower and upper corners. Each one that a ray meets is a candidate, on which the kernel decides.
    Boxes(&'a [[[f32; 3]; 2]]),
}

/// Bytes of one corner in a buffer of triangles.
const CORNER_BYTES: u64 = size_of::<[f32; 3]>() as u64;

/// Instance of a structure within a structure, as Vulkan reads it (`VkAccelerationStructureInstanceKHR`).
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Instance {
    transform: [[f32; 4]; 3],
    custom_index_and_mask: u32,
    shader_offset_and_flags: u32,
    address: u64,
}

impl Buffer {
    /// Makes an acceleration structure of parts. The elements of a part have its place in `parts` as their custom index
    /// (`rayQueryGetIntersectionInstanceCustomIndexEXT`). Parts may be empty.
    ///
    /// # Errors
    /// [`Error::Device`] where the device has no ray queries or allows fewer elements; other errors where it is out of memory or lost.
    ///
    /// # Panics
    /// Where a box's lower corner is not below its upper one.
    pub fn acceleration_structure(
        context: &Arc<Context>,
        name: &str,
        parts: &[StructurePart<'_>],
    ) -> Result<Arc<Self>> {
        let structures = functions(context)?;
        let mut instances = Vec::new();
        let mut kept: Vec<Kept> = Vec::new();
        for (index, &part) in (0..).zip(parts).filter(|(_, part)| part.count() > 0) {
            let buffer = of_part(context, name, part)?;
            instances.push(Instance {
                transform: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
                custom_index_and_mask: index | 0xff << 24,
                shader_offset_and_flags: 0,
                address: address_of_structure(structures, &buffer),
            });
            kept.push(buffer);
        }
        let input = Self::filled(context, &format!("instances of {name}"), &instances, BufferKind::BuildInput)?;
        let data = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(address_of(&input));
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::INSTANCES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data });
        build(context, name, vk::AccelerationStructureTypeKHR::TOP_LEVEL, geometry, instances.len() as u32, kept)
    }
}

impl StructurePart<'_> {
    fn count(&self) -> usize {
        match self {
            Self::OpaqueTriangles(triangles) | Self::Triangles(triangles) => triangles.len(),
            Self::Boxes(boxes) => boxes.len(),
        }
    }
}

/// Structure of the elements of one part.
fn of_part(context: &Arc<Context>, name: &str, part: StructurePart<'_>) -> Result<Arc<Buffer>> {
    let most = context.device().limits.max_structure_elements.min(u64::from(u32::MAX) / 3);
    if part.count() as u64 > most {
        return Err(Error::Device(format!(
            "the acceleration structure `{name}` needs {} elements, but {} allows {most}",
            part.count(),
            context.device().name
        )));
    }
    let count = part.count() as u32;
    let upload = |bytes: &[u8]| Buffer::filled(context, &format!("input of {name}"), bytes, BufferKind::BuildInput);
    let input;
    let geometry = vk::AccelerationStructureGeometryKHR::default();
    let geometry = match part {
        StructurePart::OpaqueTriangles(triangles) | StructurePart::Triangles(triangles) => {
            input = upload(bytemuck::cast_slice(triangles))?;
            let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
                .vertex_format(vk::Format::R32G32B32_SFLOAT)
                .vertex_data(address_of(&input))
                .vertex_stride(CORNER_BYTES)
                .max_vertex(3 * count - 1)
                .index_type(vk::IndexType::NONE_KHR);
            let data = vk::AccelerationStructureGeometryDataKHR { triangles };
            geometry.geometry_type(vk::GeometryTypeKHR::TRIANGLES).geometry(data)
        }
        StructurePart::Boxes(boxes) => {
            let is_ordered = |[low, high]: &[[f32; 3]; 2]| low.iter().zip(high).all(|(low, high)| low <= high);
            assert!(boxes.iter().all(is_ordered), "a box of `{name}` has corners out of order");
            input = upload(bytemuck::cast_slice(boxes))?;
            let aabbs = vk::AccelerationStructureGeometryAabbsDataKHR::default()
                .data(address_of(&input))
                .stride(2 * CORNER_BYTES);
            let data = vk::AccelerationStructureGeometryDataKHR { aabbs };
            geometry.geometry_type(vk::GeometryTypeKHR::AABBS).geometry(data)
        }
    };
    let geometry = geometry.flags(match part {
        StructurePart::OpaqueTriangles(_) => vk::GeometryFlagsKHR::OPAQUE,
        _ => vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION,
    });
    build(context, name, vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL, geometry, count, Vec::new())
}

/// Builds a structure of one geometry and waits until it is built.
fn build(
    context: &Arc<Context>,
    name: &str,
    level: vk::AccelerationStructureTypeKHR,
    geometry: vk::AccelerationStructureGeometryKHR<'_>,
    count: u32,
    kept: Vec<Kept>,
) -> Result<Arc<Buffer>> {
    let structures = functions(context)?;
    let geometries = [geometry];
    let mut info = vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(level)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(&geometries);
    let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
    let on_device = vk::AccelerationStructureBuildTypeKHR::DEVICE;
    // SAFETY: invariant 1: the device is alive, and all that `info` points to are locals.
    unsafe { structures.get_acceleration_structure_build_sizes(on_device, &info, &[count], &mut sizes) };
    let bytes = sizes.acceleration_structure_size;
    let buffer = Buffer::uncleared(context, name, bytes, BufferKind::AccelerationStructure)?;
    let creation =
        vk::AccelerationStructureCreateInfoKHR::default().buffer(buffer.backing().raw()).size(bytes).ty(level);
    // SAFETY: invariant 1: device and buffer are alive, and the buffer has the size that the driver asked for.
    let raw = fault_injection::before(May::RunOutOfMemory)
        .and_then(|()| unsafe { structures.create_acceleration_structure(&creation, None) })
        .map_err(failed(format!("creating the acceleration structure `{name}`")))?;
    let buffer = buffer.with_structure(Structure::new(context, raw, kept));
    context.logical().name(raw, name);
    let alignment = u64::from(context.device().limits.scratch_alignment);
    let scratch_bytes = sizes.build_scratch_size.saturating_add(alignment);
    let scratch = Buffer::uncleared(context, &format!("scratch of {name}"), scratch_bytes, BufferKind::BuildScratch)?;
    info = info.dst_acceleration_structure(raw).scratch_data(vk::DeviceOrHostAddressKHR {
        device_address: device_address(&scratch).next_multiple_of(alignment),
    });
    context.submit(&format!("building the acceleration structure `{name}`"), |recorder: &mut Recorder<'_>| {
        // SAFETY: invariants 1 and 3: the caller's buffers, this structure and the scratch memory live until the submission is
        // done. Sizes and alignment are those that the driver asked for.
        unsafe { recorder.build_structure(structures, &info, count) }
    })?;
    Ok(Arc::new(buffer))
}

/// Functions for acceleration structures, or the error that the device has none.
fn functions(context: &Context) -> Result<&khr::acceleration_structure::Device> {
    let name = &context.device().name;
    context.logical().structures().ok_or_else(|| Error::Device(format!("{name} has no ray queries")))
}

fn address_of_structure(structures: &khr::acceleration_structure::Device, buffer: &Buffer) -> u64 {
    let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(buffer.structure());
    // SAFETY: invariant 1: the structure is alive.
    unsafe { structures.get_acceleration_structure_device_address(&info) }
}

fn device_address(buffer: &Buffer) -> u64 {
    let info = vk::BufferDeviceAddressInfo::default().buffer(buffer.backing().raw());
    // SAFETY: invariant 1: the buffer is alive. Its kind has the usage for addresses.
    unsafe { buffer.context().raw().get_buffer_device_address(&info) }
}

fn address_of(buffer: &Buffer) -> vk::DeviceOrHostAddressConstKHR {
    vk::DeviceOrHostAddressConstKHR { device_address: device_address(buffer) }
}
