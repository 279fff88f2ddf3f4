//! Acceleration structures that the device builds from triangles and boxes.

use std::sync::Arc;

use ash::vk;
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
    /// Makes an acceleration structure of parts. Each part has the custom index of its elements
    /// (`rayQueryGetIntersectionInstanceCustomIndexEXT`), which is below 2^24.
    ///
    /// # Errors
    /// [`Error::Device`] where the device has no ray queries; other errors where it is out of memory or lost.
    ///
    /// # Panics
    /// Where a custom index is too large.
    pub fn acceleration_structure(
        context: &Arc<Context>,
        name: &str,
        parts: &[(u32, StructurePart<'_>)],
    ) -> Result<Arc<Self>> {
        let mut instances = Vec::new();
        let mut kept: Vec<Kept> = Vec::new();
        for &(index, part) in parts {
            assert!(index < 1 << 24, "the custom index {index} has more than 24 bits");
            let buffer = of_part(context, name, part)?;
            instances.push(Instance {
                transform: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
                custom_index_and_mask: index | 0xff << 24,
                shader_offset_and_flags: 0,
                address: address_of_structure(context, &buffer)?,
            });
            kept.push(buffer);
        }
        let input = Self::with_values(context, &format!("instances of {name}"), &instances, BufferKind::BuildInput)?;
        let data = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(address_of(&input));
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::INSTANCES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data });
        build(context, name, vk::AccelerationStructureTypeKHR::TOP_LEVEL, geometry, instances.len(), kept)
    }
}

/// Structure of the elements of one part.
fn of_part(context: &Arc<Context>, name: &str, part: StructurePart<'_>) -> Result<Arc<Buffer>> {
    let upload =
        |bytes: &[u8]| Buffer::with_values(context, &format!("input of {name}"), bytes, BufferKind::BuildInput);
    let (input, data, count, is_opaque);
    match part {
        StructurePart::OpaqueTriangles(triangles) | StructurePart::Triangles(triangles) => {
            input = upload(bytemuck::cast_slice(triangles))?;
            count = triangles.len();
            is_opaque = matches!(part, StructurePart::OpaqueTriangles(_));
            let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
                .vertex_format(vk::Format::R32G32B32_SFLOAT)
                .vertex_data(address_of(&input))
                .vertex_stride(CORNER_BYTES)
                .max_vertex((3 * count).saturating_sub(1) as u32)
                .index_type(vk::IndexType::NONE_KHR);
            data = vk::AccelerationStructureGeometryDataKHR { triangles };
        }
        StructurePart::Boxes(boxes) => {
            input = upload(bytemuck::cast_slice(boxes))?;
            (count, is_opaque) = (boxes.len(), false);
            let aabbs = vk::AccelerationStructureGeometryAabbsDataKHR::default()
                .data(address_of(&input))
                .stride(2 * CORNER_BYTES);
            data = vk::AccelerationStructureGeometryDataKHR { aabbs };
        }
    }
    let kind = match part {
        StructurePart::Boxes(_) => vk::GeometryTypeKHR::AABBS,
        _ => vk::GeometryTypeKHR::TRIANGLES,
    };
    let flags =
        if is_opaque { vk::GeometryFlagsKHR::OPAQUE } else { vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION };
    let geometry = vk::AccelerationStructureGeometryKHR::default().geometry_type(kind).geometry(data).flags(flags);
    build(context, name, vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL, geometry, count, Vec::new())
}

/// Builds a structure of one geometry and waits until it is built.
fn build(
    context: &Arc<Context>,
    name: &str,
    level: vk::AccelerationStructureTypeKHR,
    geometry: vk::AccelerationStructureGeometryKHR<'_>,
    count: usize,
    kept: Vec<Kept>,
) -> Result<Arc<Buffer>> {
    let Some(structures) = context.logical().structures() else {
        return Err(Error::Device(format!("{} has no ray queries", context.device().name)));
    };
    let (geometries, count) = ([geometry], count as u32);
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

fn address_of_structure(context: &Context, buffer: &Buffer) -> Result<u64> {
    let Some(structures) = context.logical().structures() else {
        return Err(Error::Device(format!("{} has no ray queries", context.device().name)));
    };
    let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(buffer.structure());
    // SAFETY: invariant 1: the structure is alive.
    Ok(unsafe { structures.get_acceleration_structure_device_address(&info) })
}

fn device_address(buffer: &Buffer) -> u64 {
    let info = vk::BufferDeviceAddressInfo::default().buffer(buffer.backing().raw());
    // SAFETY: invariant 1: the buffer is alive. Its kind has the usage for addresses.
    unsafe { buffer.context().raw().get_buffer_device_address(&info) }
}

fn address_of(buffer: &Buffer) -> vk::DeviceOrHostAddressConstKHR {
    vk::DeviceOrHostAddressConstKHR { device_address: device_address(buffer) }
}
