//! Samples that `sample_direction` draws for a surface over the grids of one cell: `glsl/test/sample_direction.comp`.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use lodestar::gpu::Kernel;

use crate::device::{Cell, Device};
use crate::scattering_cases::DeviceBsdf;
use crate::substances::table_words;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct SurfaceInput {
    bsdf: DeviceBsdf,
    wo: [f32; 3],
    normal: [f32; 3],
}

/// Sample, and the density of a given direction.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct DirectionOutput {
    pub wi: [f32; 3],
    pub pdf: f32,
    pub weight: [f32; 3],
    pub pdf_of_wi: f32,
    pub given: [f32; 3],
    pub pdf_of_given: f32,
    pub value_of_given: [f32; 3],
    /// Evidence of this sample about the learned share.
    pub scattered: f32,
    pub of_guide: f32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct TestPush {
    seed: u32,
    count: u32,
}

/// Surface, and the direction to the eye.
#[derive(Clone, Copy)]
pub struct SeenSurface {
    pub bsdf: DeviceBsdf,
    /// Direction to the eye, in local coordinates.
    pub wo: DVec3,
    /// Normal in world space.
    pub normal: DVec3,
}

/// Draws `count` samples with a kernel whose workgroups have `group` invocations.
pub fn draw(
    device: &Device,
    cell: &Cell,
    (kernel, group): (&Kernel, u32),
    surface: SeenSurface,
    (seed, count): (u32, usize),
) -> Vec<DirectionOutput> {
    let SeenSurface { bsdf, wo, normal } = surface;
    let input = SurfaceInput { bsdf, wo: wo.as_vec3().into(), normal: normal.as_vec3().into() };
    let input = device.uploaded("surface", &[input]);
    let output = device.storage("directions", count * size_of::<DirectionOutput>());
    let words: Vec<u32> = table_words().into_iter().chain([0]).collect();
    let words = device.uploaded("tables", &words);
    let mut named = cell.named(("DirectionOutputs", &output)).to_vec();
    named.extend([("SurfaceInputs", &input), ("TexelWords", &words)]);
    let push = TestPush { seed, count: count as u32 };
    device.dispatch_named(kernel, &named, bytemuck::bytes_of(&push), count as u32 / group);
    output.read(0, count).expect("read")
}
