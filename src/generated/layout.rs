//! Every struct that crosses to GLSL, nothing else. `build.rs` holds size and offsets against the reflected shaders; the
//! meaning of each field stands beside it in `glsl/include`.

use bytemuck::{Pod, Zeroable};

/// `glsl/include/film/frame.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct FilmRadiance {
    /// Mean of the pixel's samples, linear sRGB.
    pub mean: [f32; 3],
    /// Their number.
    pub sample_count: u32,
    /// Sum of squared deviations from the mean.
    pub squared_deviation: [f32; 3],
    /// Samples whose camera ray hit something.
    pub hit_count: u32,
}

/// `glsl/include/film/frame.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct FilmFeatures {
    /// Mean albedo of the first hit.
    pub albedo: [f32; 3],
    /// Mean depth of the first hit over the samples that hit.
    pub depth: f32,
    /// Mean shading normal of the first hit.
    pub normal: [f32; 3],
    /// Unused.
    pub reserved: f32,
}

/// `glsl/include/film/frame.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SceneConstants {
    /// Rows of the affine matrix.
    pub world_from_camera: [[f32; 4]; 3],
    /// Whole film in pixels.
    pub film_size: [f32; 2],
    /// Tangents of the half fields of view; orthographic: half the view's sides, camera units.
    pub raster_scale: [f32; 2],
    /// In picture widths and heights.
    pub principal_point: [f32; 2],
    /// Distance of the near plane.
    pub near_clip: f32,
    /// Distance of the far plane.
    pub far_clip: f32,
    /// Lower corner of the scene.
    pub bounds_min: [f32; 3],
    /// Of a thin lens.
    pub aperture_radius: f32,
    /// Grid size / extent.
    pub cells_per_unit: [f32; 3],
    /// Learning targets saturate here, W/(m^2 sr).
    pub target_limit: f32,
    /// Radiance of a constant environment, factor of a map's texels.
    pub environment: [f32; 3],
    /// The render's seed.
    pub seed: u32,
    /// Offset of the rendered window within the film.
    pub window_offset: [u32; 2],
    /// Its size in pixels.
    pub window_size: [u32; 2],
    /// Entries of the table that lights are chosen from.
    pub light_count: u32,
    /// Where it begins among the emitters' texels.
    pub first_light: u32,
    /// Rows; the fourth column is unused.
    pub environment_from_world: [[f32; 4]; 3],
    /// Texels of the environment's map.
    pub environment_size: [u32; 2],
    /// Columns and rows of the table that its directions are drawn from.
    pub environment_blocks: [u32; 2],
    /// Where the map begins among the emitters' texels.
    pub first_environment_texel: u32,
    /// Likewise the table.
    pub first_environment_block: u32,
    /// Entry of the environment among the lights, or `NONE`.
    pub environment_light: u32,
    /// Of a thin lens: depth at which it is sharp.
    pub focus_distance: f32,
    /// Places of the grid along each axis.
    pub grid_size: [u32; 3],
    /// Cells that hold surfaces.
    pub cell_count: u32,
    /// These and the larger ones that they are part of.
    pub all_cell_count: u32,
}

/// `glsl/kernels/layout_probe.comp`; what is done with it: `glsl/include/texture/textures.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct TextureRecord {
    /// `TEXTURE_*`
    pub kind: u32,
    /// Of the first word of its image, the page in the upper bits.
    pub address: u32,
    /// Of its image, in texels.
    pub size: [u32; 2],
    /// First row of `to_uv`.
    pub u_row: [f32; 3],
    /// Factor of an image of halves.
    pub scale: f32,
    /// Second row of `to_uv`.
    pub v_row: [f32; 3],
    /// Unused.
    pub reserved: f32,
    /// Of a checkerboard; the fourth component is 1.
    pub colors: [[f32; 4]; 2],
}

/// `glsl/kernels/layout_probe.comp`; what colors and scalars mean: `glsl/include/bsdf/parameters.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct MaterialRecord {
    /// `BSDF_*` or `MATERIAL_BLEND`, `MATERIAL_SIDES`, and `MATERIAL_*` flags.
    pub kind_and_flags: u32,
    /// Of a blend or of two sides: the first material.
    pub material0: u32,
    /// The second; otherwise the texture of a bump or normal map, or `NONE`.
    pub material1_or_relief: u32,
    /// Factor of a bump map's heights; weight of a blend.
    pub relief_scale: f32,
    /// Colors; the fourth component is unused.
    pub colors: [[f32; 4]; 3],
    /// Numbers.
    pub scalars: [f32; 12],
    /// Parameters with textures, `parameter << 24 | texture`, or `NONE`; colors are parameters 0 to 2, scalars follow.
    pub links: [[u32; 4]; 2],
    /// Of a coating: optical thickness, eta.
    pub coating: [f32; 4],
    /// Of a coating: specular reflectance.
    pub coating_specular: [f32; 4],
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct EmitterRecord {
    /// Linear sRGB, W/(m^2 sr).
    pub radiance: [f32; 3],
    /// The texture that multiplies it, or `NONE`.
    pub texture_index: u32,
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct LightRecord {
    /// Of 32 random bits: those below take this light, the others its alias.
    pub threshold: u32,
    /// Another light.
    pub alias: u32,
    /// `LIGHT_*`; the primitive of an area light, the first texel of a delta light, else 0.
    pub kind_and_index: u32,
    /// Of this light among all.
    pub probability: f32,
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct DeltaLightRecord {
    /// World space; unused where the light is directional.
    pub position: [f32; 3],
    /// Of a spot, as are the next two angles.
    pub cos_cutoff: f32,
    /// Unit, in which the light travels; unused where the light is a point.
    pub direction: [f32; 3],
    /// Radians.
    pub cutoff_angle: f32,
    /// W/sr; of a directional light the irradiance, W/m^2.
    pub intensity: [f32; 3],
    /// One over the angle in which the intensity falls to 0.
    pub falloff: f32,
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct PrimitiveRecord {
    /// First vertex or center.
    pub origin: [f32; 3],
    /// `SHAPE_*` and `PRIMITIVE_*`.
    pub flags: u32,
    /// See [`crate::scene::Primitive::edge_u`].
    pub edge_u: [f32; 3],
    /// Length of the longest edge, or the sphere's radius.
    pub edge_tolerance: f32,
    /// See [`crate::scene::Primitive::edge_v`].
    pub edge_v: [f32; 3],
    /// Unused.
    pub reserved: f32,
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct AttributeRecord {
    /// Vertex normals, octahedral, 16 bits a coordinate.
    pub normals: [u32; 3],
    /// Index of the material.
    pub material: u32,
    /// Texture coordinates of the first vertex.
    pub uv0: [f32; 2],
    /// Of the second.
    pub uv1: [f32; 2],
    /// Of the third.
    pub uv2: [f32; 2],
    /// Index of the emitter, or `NONE`.
    pub emitter: u32,
    /// Entry of the table that lights are chosen from, or `NONE`.
    pub light: u32,
}

/// `glsl/include/guide/grid/radiance_grid.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct RadianceSum {
    /// Lower word of the fixed-point sum.
    pub low: u32,
    /// Upper word.
    pub high: u32,
    /// Number of targets.
    pub target_count: u32,
    /// While quadtrees are refined: of a quarter with all below it.
    pub flux: f32,
}

/// `glsl/include/guide/grid/radiance_grid.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct LearnedRadiance {
    /// Mean radiance, before any floor.
    pub mean: f32,
    /// Decayed number of targets behind it.
    pub weight: f32,
}

/// `glsl/include/guide/normalization/normalization_grid.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct NormalizationEntry {
    /// Times L cos: density of a guided direction.
    pub guide_scale: f32,
    /// Density of the uniform share and the fallback; 0 marks an unfilled entry.
    pub uniform_density: f32,
    /// Times L cos: probability that a proposal is accepted.
    pub acceptance_scale: f32,
    /// Probability of the uniform component.
    pub uniform_share: f32,
}

/// `glsl/include/guide/normalization/normalization_grid.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct CosineIntegral {
    /// Integral of the clamped cosine over the direction bin, sr.
    pub integral: f32,
    /// Upper bound of the cosine over the bin, at least 0.
    pub maximum: f32,
}

/// `glsl/include/guide/learners/path_vertex.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Segment {
    /// Bin that learns a target, or `NONE`.
    pub index: u32,
    /// Factor of its targets.
    pub scale: f32,
}

/// `glsl/include/guide/learners/path_vertex.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct PathVertex {
    /// The segment that leads there.
    pub segment: Segment,
    /// Light of the vertex itself.
    pub light: [f32; 3],
    /// Factor of the next segment's radiance.
    pub factor: [f32; 3],
}

/// Pushed to `glsl/kernels/trace/path_trace.comp`: a slice of a film page and its next samples.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct PathTracePush {
    /// First workgroup of the slice among those of the film page's tiles that are sampled.
    pub first_workgroup: u32,
    /// Workgroups of the slice.
    pub workgroup_count: u32,
    /// Coprime to the count.
    pub workgroup_stride: u32,
    /// Pixels, in tile order, before this film page.
    pub page_first_pixel: u32,
    /// What the samples count for beside those before them.
    pub weights: SampleWeights,
    /// Index of the first sample.
    pub first_sample: u32,
    /// Samples to take.
    pub sample_count: u32,
    /// Index of the first sample whose set may reach to these.
    pub first_of_sets: u32,
}

/// Pushed to the kernels of a wave: `glsl/include/path/wavefront.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct WavePush {
    /// Whose samples the wave takes.
    pub slice: PathTracePush,
    /// That the paths travel: 0 from the camera.
    pub edge: u32,
}

/// `glsl/include/film/slice.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SampleWeights {
    /// Of each of a dispatch's samples.
    pub of_sample: f32,
    /// By how much the sum of the weights of all samples before them falls short of their number.
    pub lost_weight: f32,
    /// The same of the number of samples of one weight whose mean has the variance of theirs.
    pub lost_samples: f32,
}

/// Pushed to the kernels that update the grids.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct UpdatePush {
    /// Cell of the first workgroup.
    pub first_cell: u32,
}

/// Pushed to `glsl/kernels/noise/judge_noise.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct JudgePush {
    /// Tile of the first workgroup, within the film page.
    pub first_tile: u32,
}

/// Pushed to `glsl/kernels/learn/refine_quadtrees.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct RefinePush {
    /// `REFINE_*`
    pub stage: u32,
    /// Of how many steps, as a power of two.
    pub iteration: u32,
}

/// Bytes of a texel.
pub const TEXEL_BYTES: usize = 16;

/// Where a member of a record begins, in texels.
macro_rules! first_texel {
    ($record:ident, $member:ident) => {
        std::mem::offset_of!($record, $member) / TEXEL_BYTES
    };
}

// The sizes and places that GLSL gives the records that it reads as texels.
const _: () = {
    use super::constants::*;
    assert!(size_of::<PrimitiveRecord>() == PRIMITIVE_TEXELS as usize * TEXEL_BYTES);
    assert!(size_of::<AttributeRecord>() == ATTRIBUTE_TEXELS as usize * TEXEL_BYTES);
    assert!(size_of::<MaterialRecord>() == MATERIAL_TEXELS as usize * TEXEL_BYTES);
    assert!(size_of::<TextureRecord>() == TEXTURE_TEXELS as usize * TEXEL_BYTES);
    assert!(first_texel!(MaterialRecord, kind_and_flags) == MATERIAL_HEAD as usize);
    assert!(first_texel!(MaterialRecord, colors) == MATERIAL_COLORS as usize);
    assert!(first_texel!(MaterialRecord, scalars) == MATERIAL_SCALARS as usize);
    assert!(first_texel!(MaterialRecord, links) == MATERIAL_LINKS as usize);
    assert!(first_texel!(MaterialRecord, coating) == MATERIAL_COATING as usize);
    assert!(first_texel!(TextureRecord, kind) == TEXTURE_HEAD as usize);
    assert!(first_texel!(TextureRecord, u_row) == TEXTURE_TO_UV as usize);
    assert!(first_texel!(TextureRecord, colors) == TEXTURE_COLORS as usize);
};

include!(concat!(env!("OUT_DIR"), "/layout_checks.rs"));
