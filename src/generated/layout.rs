//! Structs that cross to GLSL. `build.rs` compares their sizes and offsets with the reflected shaders. The GLSL file
//! that each struct names declares it, too.

use bytemuck::{Pod, Zeroable};

/// `glsl/include/film/frame.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct FilmRadiance {
    /// Mean of the pixel's samples, linear sRGB.
    pub mean: [f32; 3],
    /// Number of the pixel's samples.
    pub sample_count: u32,
    /// Sum of squared deviations from the mean.
    pub squared_deviation: [f32; 3],
    /// Number of samples whose camera ray hit something.
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
    /// Size of the whole film, in pixels.
    pub film_size: [f32; 2],
    /// Tangents of half the fields of view; orthographic: half the sides of the view, in camera units.
    pub raster_scale: [f32; 2],
    /// Principal point, in picture widths and heights.
    pub principal_point: [f32; 2],
    /// Distance of the near plane.
    pub near_clip: f32,
    /// Distance of the far plane.
    pub far_clip: f32,
    /// Lower corner of the scene.
    pub bounds_min: [f32; 3],
    /// Radius of a thin lens.
    pub aperture_radius: f32,
    /// Grid size divided by the scene's extent.
    pub cells_per_unit: [f32; 3],
    /// Limit at which learning targets are clamped, W/(m^2 sr).
    pub target_limit: f32,
    /// Radiance of a constant environment, or factor of a map's texels.
    pub environment: [f32; 3],
    /// The render's seed.
    pub seed: u32,
    /// Offset of the rendered window within the film.
    pub window_offset: [u32; 2],
    /// Size of the rendered window, in pixels.
    pub window_size: [u32; 2],
    /// Number of lights in the alias table.
    pub light_count: u32,
    /// First texel of the alias table of lights among the emitters' texels.
    pub first_light: u32,
    /// Rows of the matrix; the fourth column is unused.
    pub environment_from_world: [[f32; 4]; 3],
    /// Width and height of the environment map, in texels.
    pub environment_size: [u32; 2],
    /// Columns and rows of the alias table for directions of the environment.
    pub environment_blocks: [u32; 2],
    /// First texel of the environment map among the emitters' texels.
    pub first_environment_texel: u32,
    /// First texel of the alias table for directions among the emitters' texels.
    pub first_environment_block: u32,
    /// Index of the environment, or of its first patch, among the lights; `NONE` without one.
    pub environment_light: u32,
    /// Depth at which a thin lens is sharp.
    pub focus_distance: f32,
    /// Number of grid positions along each axis.
    pub grid_size: [u32; 3],
    /// Number of cells that contain surfaces.
    pub cell_count: u32,
    /// Number of all cells, parent cells included.
    pub all_cell_count: u32,
    /// First texel of the groups of lights among the emitters' texels.
    pub first_light_group: u32,
}

/// `glsl/kernels/layout_probe.comp`; read by `glsl/include/texture/textures.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct TextureRecord {
    /// `TEXTURE_*`
    pub kind: u32,
    /// Address of the image's first word. The upper bits hold the page.
    pub address: u32,
    /// Width and height of the image, in texels.
    pub size: [u32; 2],
    /// First row of `to_uv`.
    pub u_row: [f32; 3],
    /// Factor of texels that are stored as halves.
    pub scale: f32,
    /// Second row of `to_uv`.
    pub v_row: [f32; 3],
    /// Unused.
    pub reserved: f32,
    /// Colors of a checkerboard; the fourth component is 1.
    pub colors: [[f32; 4]; 2],
}

/// `glsl/kernels/layout_probe.comp`; `glsl/include/bsdf/parameters.glsl` lists the meaning of colors and scalars
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct MaterialRecord {
    /// `BSDF_*` or `MATERIAL_BLEND`, `MATERIAL_SIDES`, and `MATERIAL_*` flags.
    pub kind_and_flags: u32,
    /// First material of a blend or of two sides.
    pub material0: u32,
    /// Second material; otherwise the texture of a bump or normal map, or `NONE`.
    pub material1_or_relief: u32,
    /// Factor of a bump map's heights; weight of a blend.
    pub relief_scale: f32,
    /// Colors; the fourth component is unused.
    pub colors: [[f32; 4]; 3],
    /// Scalar parameters.
    pub scalars: [f32; 12],
    /// Links from parameters to textures: `parameter << 24 | texture`, or `NONE`. Colors are parameters 0 to 2; scalars
    /// follow.
    pub links: [[u32; 4]; 2],
    /// Optical thickness (RGB) and eta of the coating.
    pub coating: [f32; 4],
    /// Specular reflectance of the coating; the fourth component is unused.
    pub coating_specular: [f32; 4],
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct EmitterRecord {
    /// Emitted radiance, linear sRGB, W/(m^2 sr).
    pub radiance: [f32; 3],
    /// Texture that multiplies the radiance, or `NONE`.
    pub texture_index: u32,
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct LightRecord {
    /// Threshold for 32 random bits: bits below it take this light, others its alias.
    pub threshold: u32,
    /// Alias: index of another light. Where cells learn which lights to draw, the upper bits hold the light's group.
    pub group_and_alias: u32,
    /// Kind (`LIGHT_*`), and an index: the primitive of an area light, the first texel of a delta light, or the patch of an
    /// environment.
    pub kind_and_index: u32,
    /// Probability of this light among all lights, or among those of its group.
    pub probability: f32,
}

/// `glsl/kernels/layout_probe.comp`; read by `glsl/include/light/light_selection.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct LightGroupRecord {
    /// First light of the group.
    pub first: u32,
    /// Number of lights; 0 for a group that is not used.
    pub count: u32,
    /// Power of the group's lights over that of all lights, for the host alone.
    pub power: f32,
    /// Unused.
    pub unused: u32,
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct DeltaLightRecord {
    /// Position in world space; unused for a directional light.
    pub position: [f32; 3],
    /// Cosine of the cutoff angle of a spot light.
    pub cos_cutoff: f32,
    /// Unit direction in which the light travels; unused for a point light.
    pub direction: [f32; 3],
    /// Cutoff angle of a spot light, radians.
    pub cutoff_angle: f32,
    /// Intensity, W/sr; for a directional light the irradiance, W/m^2.
    pub intensity: [f32; 3],
    /// Falloff of a spot light: 1 / (angle over which the intensity falls to 0).
    pub falloff: f32,
    /// Direction along which the coordinate `u` of a light's picture grows.
    pub axis_u: [f32; 3],
    /// Picture that a light throws, or `NONE`.
    pub texture_index: u32,
    /// Direction along which the coordinate `v` of a light's picture grows.
    pub axis_v: [f32; 3],
    /// Unused.
    pub unused: u32,
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct PrimitiveRecord {
    /// First vertex or center.
    pub origin: [f32; 3],
    /// `SHAPE_*` and `PRIMITIVE_*`.
    pub flags: u32,
    /// First edge vector: [`crate::scene::Primitive::edge_u`].
    pub edge_u: [f32; 3],
    /// Length of the longest edge, or the sphere's radius.
    pub edge_tolerance: f32,
    /// Second edge vector: [`crate::scene::Primitive::edge_v`].
    pub edge_v: [f32; 3],
    /// Dot product of the edges' cross product with every point of a flat shape's plane, relative to the shape's origin or, with
    /// `PRIMITIVE_LARGE`, to the world's; 0 for a sphere.
    pub plane: f32,
}

/// `glsl/kernels/layout_probe.comp`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct AttributeRecord {
    /// Vertex normals in octahedral encoding, 16 bits per coordinate.
    pub normals: [u32; 3],
    /// Index of the material.
    pub material: u32,
    /// Texture coordinates of the first vertex.
    pub uv0: [f32; 2],
    /// Texture coordinates of the second vertex.
    pub uv1: [f32; 2],
    /// Texture coordinates of the third vertex.
    pub uv2: [f32; 2],
    /// Index of the emitter, or `NONE`.
    pub emitter: u32,
    /// Index of the primitive's light in the alias table, or `NONE`.
    pub light: u32,
}

/// `glsl/include/guide/grid/radiance_grid.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct RadianceSum {
    /// Lower word of the fixed-point sum.
    pub low: u32,
    /// Upper word of the fixed-point sum.
    pub high: u32,
    /// Number of targets.
    pub target_count: u32,
    /// Flux of a quarter, including all nodes below it. Only the refinement of quadtrees uses it.
    pub flux: f32,
}

/// `glsl/include/guide/grid/radiance_grid.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct LearnedRadiance {
    /// Mean radiance before the floor is applied.
    pub mean: f32,
    /// Number of targets behind the mean, after decay.
    pub weight: f32,
}

/// `glsl/include/guide/normalization/normalization_grid.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct NormalizationEntry {
    /// Factor of L cos: the product is the density of a guided direction, per steradian.
    pub guide_scale: f32,
    /// Density of the uniform share and the fallback, per steradian; 0 marks an unfilled entry.
    pub uniform_density: f32,
    /// Factor of L cos: the product is the probability that a proposal is accepted.
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
    /// Index of the bin that receives the target, or `NONE`.
    pub index: u32,
    /// Factor of the bin's targets.
    pub scale: f32,
}

/// `glsl/include/guide/learners/path_vertex.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct PathVertex {
    /// Segment that leads to the vertex.
    pub segment: Segment,
    /// Light that the vertex itself emits or receives from a sampled light.
    pub light: [f32; 3],
    /// Factor of the next segment's radiance.
    pub factor: [f32; 3],
}

/// Push constants of `glsl/kernels/trace/trace.comp`: a slice of a film page and the range of samples to add.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct TracePush {
    /// First workgroup of the slice, counted over the film page's tiles that are sampled.
    pub first_workgroup: u32,
    /// Number of workgroups of the slice.
    pub workgroup_count: u32,
    /// Stride that spreads neighboring workgroups; coprime to their number.
    pub workgroup_stride: u32,
    /// Number of pixels, in tile order, before this film page.
    pub page_first_pixel: u32,
    /// Weights of the samples relative to the samples before them.
    pub weights: DispatchWeights,
    /// Index of the first sample.
    pub first_sample: u32,
    /// Number of samples to add.
    pub sample_count: u32,
    /// Index of a sample before which no set of samples starts.
    pub first_of_sets: u32,
    /// Places of the page's tiles that this device traces.
    pub tiles: TilePlaces,
}

/// Places of the tiles of a film page that one device traces: in every run of `period` tiles of the film, `width` tiles are its own.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct TilePlaces {
    /// Number of the device's tiles before this page.
    pub own_before: u32,
    /// Place of the device's first tile of the film, relative to the page's first tile. It wraps.
    pub first: u32,
    /// Number of the device's tiles in a run.
    pub width: u32,
    /// Number of tiles of a run.
    pub period: u32,
}

/// Push constants of the kernels of a wave (`glsl/include/path/wavefront.glsl`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct WavePush {
    /// Slice whose samples the wave traces.
    pub slice: TracePush,
    /// Number of the edge that the paths travel; 0 leaves the camera.
    pub edge: u32,
}

/// `glsl/include/film/slice.glsl`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct DispatchWeights {
    /// Weight of each sample of the dispatch.
    pub of_sample: f32,
    /// Number of earlier samples minus the sum of their weights.
    pub lost_weight: f32,
    /// Number of earlier samples minus their effective number.
    pub lost_samples: f32,
}

/// Push constants of the kernels that update the grids.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct UpdatePush {
    /// Cell of the first workgroup.
    pub first_cell: u32,
}

/// Push constants of `glsl/kernels/learn/blend_radiance.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct BlendPush {
    /// First cell of the dispatch.
    pub first_cell: u32,
    /// One more than the last cell of the dispatch.
    pub end_cell: u32,
}

/// Push constants of `glsl/kernels/noise/judge_noise.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct JudgePush {
    /// Tile of the first workgroup, within the film page.
    pub first_tile: u32,
}

/// Push constants of `glsl/kernels/learn/refine_quadtrees.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct RefinePush {
    /// `REFINE_*`
    pub stage: u32,
    /// Number k of the iteration; iteration k has 2^k steps.
    pub iteration: u32,
}

/// Size of a texel, in bytes.
pub const TEXEL_BYTES: usize = 16;

/// Offset of a member within a record, in texels.
macro_rules! first_texel {
    ($record:ident, $member:ident) => {
        std::mem::offset_of!($record, $member) / TEXEL_BYTES
    };
}

// Checks that the records which GLSL reads as texels have the sizes and offsets that GLSL declares.
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
