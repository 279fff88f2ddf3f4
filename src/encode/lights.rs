//! Lights for emitter sampling: every light of a scene has a probability in proportion to its power, among all lights or
//! within its group. CPU only; the kernels read them as texels (`glsl/include/light/light.glsl`, `glsl/include/light/environment.glsl`).

mod alias_table;
mod candidate;
mod environment_table;
mod group_tree;
mod groups;
mod patches;
mod textured;

use std::f64::consts::PI;

use glam::{Mat3, Vec3};
use rayon::prelude::*;

pub use alias_table::{AliasEntry, alias_table};
use candidate::Candidate;
pub use environment_table::{EnvironmentMap, EnvironmentTable};
pub(crate) use group_tree::group_nodes;
pub use group_tree::{first_weights, group_tree};

use crate::encode::bvh::Bvh;
use crate::encode::bvh::instances::{is_instance, number_of_part, shown};
use crate::encode::bvh::is_deforming;
use crate::encode::cells::morton_key;
use crate::encode::textures::halves;
use crate::generated::constants;
use crate::generated::layout::{
    BlockRecord, ConeRecord, DeltaLightRecord, EmitterRecord, LightGroupRecord, LightRecord, PlacedLightRecord,
    PrimitiveRecord, SceneConstants, TEXEL_BYTES,
};
use crate::scene::{
    AreaEmitter, Cone, DeltaEmitter, DeltaKind, Environment, EnvironmentKind, PictureAxes, Scene, Textured,
};
use patches::Patches;
use textured::{brightness, points_for};

/// Number of texels of a [`DeltaLightRecord`].
const DELTA_TEXELS: usize = size_of::<DeltaLightRecord>() / TEXEL_BYTES;

/// Lights of a scene and their emission.
pub struct Lights {
    emitters: Vec<EmitterRecord>,
    /// Cone of each emitter; none where no emitter has one.
    cones: Vec<ConeRecord>,
    lights: Vec<LightRecord>,
    /// Groups among which cells learn to choose; none where lights are drawn in proportion to their power.
    groups: Vec<LightGroupRecord>,
    patches_per_side: u32,
    delta_lights: Vec<DeltaLightRecord>,
    /// Area lights that instances show.
    placed_lights: Vec<PlacedLightRecord>,
    environment: Option<EnvironmentLight>,
    total_power: f64,
    brightest: f32,
}

/// Environment in the form that the kernels read.
struct EnvironmentLight {
    /// Radiance, or a factor of the map.
    radiance: Vec3,
    map: Option<(EnvironmentMap, EnvironmentTable)>,
    local_from_world: Mat3,
    light: u32,
}

impl Lights {
    /// Lights of a scene whose hierarchy is `bvh`: every emitting primitive in the order of the leaves, then delta
    /// lights, then the environment. Where cells learn which lights to draw, each patch of the environment is a light.
    pub fn new(scene: &Scene, bvh: &Bvh, learned: bool) -> Self {
        let radius = 0.5 * f64::from((bvh.bounds.1 - bvh.bounds.0).length());
        let AreaLights { mut candidates, placed: placed_lights } = area_lights(scene, bvh);
        // Texels of delta lights follow those of the emitters and of the lights, and then come placed lights.
        let patches = Patches::new(scene, bvh, candidates.len(), learned);
        let first_delta = scene.emitters.len() + patches.light_count;
        let first_placed = (first_delta + scene.delta_emitters.len() * DELTA_TEXELS) as u32;
        let of_instances = candidates.iter_mut().filter(|candidate| candidate.kind == constants::LIGHT_PLACED);
        of_instances.for_each(|candidate| candidate.index += first_placed);
        let mut candidates: Vec<_> =
            candidates.into_iter().flat_map(|light| light.in_parts(patches.area_side * patches.area_side)).collect();
        let deltas = delta_order(scene, bvh, patches.group_count > 0).into_iter();
        candidates.extend(deltas.map(|i| (i, &scene.delta_emitters[i])).map(|(i, emitter)| Candidate {
            kind: delta_light_kind(emitter),
            index: (first_delta + i * DELTA_TEXELS) as u32,
            power: delta_power(scene, emitter, radius) * f64::from(emitter.sampling_weight),
        }));
        let first_patch = candidates.len() as u32;
        let environment = scene
            .environment
            .map(|environment| EnvironmentLight::new(&environment, scene, first_patch, patches.environment_side));
        if let (Some(light), Some(environment)) = (&environment, &scene.environment) {
            let disk = PI * radius * radius * f64::from(environment.sampling_weight);
            candidates.extend((0..).zip(light.fluxes(patches.environment_patches())).map(|(index, flux)| Candidate {
                kind: constants::LIGHT_ENVIRONMENT,
                index,
                power: flux * disk,
            }));
        }
        let total_power: f64 = candidates.iter().map(|candidate| candidate.power).sum();
        let (lights, groups) = match patches.group_count {
            0 => (light_records(&candidates), Vec::new()),
            count => groups::grouped(&candidates, patches.environment_patches(), count),
        };
        Self {
            emitters: scene.emitters.iter().map(emitter_record).collect(),
            cones: cone_records(&scene.emitters),
            total_power,
            lights,
            groups,
            patches_per_side: patches.area_side as u32,
            delta_lights: scene.delta_emitters.iter().map(|emitter| delta_record(&emitter.kind)).collect(),
            placed_lights,
            brightest: brightest(scene, radius, environment.as_ref()),
            environment,
        }
    }

    /// Whether no light is ever drawn.
    pub fn is_empty(&self) -> bool {
        self.total_power <= 0.0
    }

    /// Number of groups among which cells learn to choose; 0 where lights are drawn in proportion to their power.
    pub fn group_count(&self) -> u32 {
        self.groups.len() as u32
    }

    /// Patches along each side of an area light.
    pub fn patches_per_side(&self) -> u32 {
        self.patches_per_side
    }

    /// Power of each group over that of all lights.
    pub fn group_powers(&self) -> Vec<f32> {
        self.groups.iter().map(|group| group.power).collect()
    }

    /// Bits `1 << kind` of all kinds of light in the scene.
    pub fn kinds(&self) -> u32 {
        self.lights.iter().fold(0, |bits, light| bits | 1 << (light.kind_and_index >> constants::LIGHT_KIND_SHIFT))
    }

    /// Kind of the environment, one of `ENVIRONMENT_*`.
    pub fn environment_kind(&self) -> u32 {
        match &self.environment {
            None => constants::ENVIRONMENT_NONE,
            Some(EnvironmentLight { map: None, .. }) => constants::ENVIRONMENT_CONSTANT,
            Some(EnvironmentLight { map: Some(_), .. }) => constants::ENVIRONMENT_MAP,
        }
    }

    /// Largest radiance (mean of RGB) that may arrive anywhere. A delta light counts by the radiance that a white
    /// surface reflects at a sixteenth of the scene's radius from it.
    pub fn brightest(&self) -> f32 {
        self.brightest
    }

    /// Content of the buffer that the kernels read: emitters, lights, delta lights, table and map of the environment, then
    /// groups of lights, then cones.
    pub fn texels(&self) -> Vec<[u32; 4]> {
        let mut texels: Vec<[u32; 4]> = Vec::with_capacity(self.texel_count());
        texels.extend_from_slice(bytemuck::cast_slice(&self.emitters));
        texels.extend_from_slice(bytemuck::cast_slice(&self.lights));
        texels.extend_from_slice(bytemuck::cast_slice(&self.delta_lights));
        texels.extend_from_slice(bytemuck::cast_slice(&self.placed_lights));
        if let Some((map, table)) = self.environment.as_ref().and_then(|environment| environment.map.as_ref()) {
            let block = |&AliasEntry { threshold, alias, probability }: &AliasEntry| -> [u32; 4] {
                bytemuck::cast(BlockRecord { threshold, alias, unused: 0, probability })
            };
            texels.extend(table.entries.iter().map(block));
            texels.extend(map_texels(map));
        }
        texels.extend_from_slice(bytemuck::cast_slice(&self.groups));
        texels.extend_from_slice(bytemuck::cast_slice(&self.cones));
        texels
    }

    /// Number of texels in the buffer.
    pub fn texel_count(&self) -> usize {
        self.first_cone() + self.cones.len()
    }

    /// Index of the texel at which the cones begin.
    fn first_cone(&self) -> usize {
        self.first_group() + self.groups.len()
    }

    /// Index of the texel at which the groups of lights begin.
    fn first_group(&self) -> usize {
        let map = self.environment.as_ref().and_then(|environment| environment.map.as_ref());
        let of_map = map.map_or(0, |(map, table)| map.texels.len().div_ceil(2) + table.entries.len());
        self.first_block() + of_map
    }

    /// Index of the texel at which the environment's table begins.
    fn first_block(&self) -> usize {
        self.emitters.len() + self.lights.len() + self.delta_lights.len() * DELTA_TEXELS + self.placed_lights.len()
    }

    /// Sets the constants through which kernels find the lights.
    pub fn write_constants(&self, constants: &mut SceneConstants) {
        constants.light_count = self.lights.len() as u32;
        constants.first_light = self.emitters.len() as u32;
        constants.first_light_group = self.first_group() as u32;
        constants.first_cone = if self.cones.is_empty() { constants::NONE } else { self.first_cone() as u32 };
        constants.environment_light = constants::NONE;
        let Some(environment) = &self.environment else { return };
        let first_block = self.first_block();
        constants.environment = (environment.radiance * environment.unit()).into();
        constants.environment_light = environment.light;
        constants.environment_from_world = [0, 1, 2].map(|i| environment.local_from_world.row(i).extend(0.0).into());
        if let Some((map, table)) = &environment.map {
            constants.environment_size = [map.width as u32, map.height as u32];
            constants.environment_blocks = [table.columns as u32, table.rows as u32];
            constants.first_environment_block = first_block as u32;
            constants.first_environment_texel = (first_block + table.entries.len()) as u32;
        }
    }
}

impl EnvironmentLight {
    /// Environment of `patch_side`^2 patches, the first of which is the light number `light`.
    fn new(environment: &Environment, scene: &Scene, light: u32, patch_side: usize) -> Self {
        match environment.kind {
            EnvironmentKind::Constant { radiance } => {
                Self { radiance, map: None, local_from_world: Mat3::IDENTITY, light }
            }
            EnvironmentKind::Map { image, scale, to_world } => {
                let image = &scene.images[image as usize];
                let map = EnvironmentMap::new(image);
                let table = EnvironmentTable::new(&map, patch_side);
                let local_from_world = to_world.transpose();
                Self { radiance: Vec3::splat(scale), map: Some((map, table)), local_from_world, light }
            }
        }
    }

    /// Unit of the map's texels, as radiance.
    fn unit(&self) -> f32 {
        self.map.as_ref().map_or(1.0, |(map, _)| map_unit(map))
    }

    /// Integral of the mean radiance (of RGB) over the directions of each patch, W/m^2.
    fn fluxes(&self, patch_count: usize) -> Vec<f64> {
        let equal = || vec![4.0 * PI / patch_count as f64; patch_count];
        let fluxes = self.map.as_ref().map_or_else(equal, |(_, table)| table.fluxes.clone());
        fluxes.into_iter().map(|flux| mean_rgb(self.radiance) * flux).collect()
    }

    fn brightest(&self) -> f64 {
        let brightest_texel = self.map.as_ref().map_or(1.0, |(map, _)| map.brightest_texel());
        mean_rgb(self.radiance) * brightest_texel
    }
}

fn map_unit(map: &EnvironmentMap) -> f32 {
    halves::scale(map.texels.iter().map(|texel| texel.max_element()))
}

/// Texels of a map as halves, two texels of the map in one texel of the buffer. Each has red, green, blue and an unused
/// half.
fn map_texels(map: &EnvironmentMap) -> Vec<[u32; 4]> {
    let unit = map_unit(map);
    let pair = |pair: &[Vec3]| {
        let [first, second] = [0, 1].map(|i| pair.get(i).map_or([0; 2], |t| halves::words(t.extend(0.0).into(), unit)));
        [first[0], first[1], second[0], second[1]]
    };
    map.texels.par_chunks(2).map(pair).collect()
}

fn brightest(scene: &Scene, scene_radius: f64, environment: Option<&EnvironmentLight>) -> f32 {
    let near = (scene_radius / 16.0).max(1.0e-18);
    let emitters = scene.emitters.iter().map(|emitter| {
        let texture = brightest_texel(scene, emitter).unwrap_or(Vec3::ONE);
        mean_rgb(emitter.radiance.value * texture)
    });
    let delta_emitters = scene.delta_emitters.iter().map(|emitter| match emitter.kind {
        DeltaKind::Directional { irradiance, .. } => mean_rgb(irradiance) / PI,
        DeltaKind::Point { intensity, .. } | DeltaKind::Spot { intensity, .. } => {
            mean_rgb(intensity) / (near * near * PI)
        }
        DeltaKind::PicturedSpot { intensity, .. } => {
            mean_rgb(intensity.value * largest(scene, intensity.texture)) / (near * near * PI)
        }
        // Towards the corners of the picture, the intensity grows with the cubed secant.
        DeltaKind::Projector { irradiance, axes, .. } => {
            let corner = [axes.u, axes.v].map(|axis| 0.25 / f64::from(axis.length_squared()));
            let secant = (1.0 + corner[0] + corner[1]).sqrt();
            mean_rgb(irradiance.value * largest(scene, irradiance.texture)) * secant.powi(3) / (near * near)
        }
    });
    let environment = environment.map(EnvironmentLight::brightest);
    emitters.chain(delta_emitters).chain(environment).fold(0.0, f64::max) as f32
}

/// Brightest texel of the emitter's texture, where it has one.
fn brightest_texel(scene: &Scene, emitter: &AreaEmitter) -> Option<Vec3> {
    emitter.radiance.texture.map(|texture| scene.textures[texture as usize].maximum(&scene.images))
}

/// Brightest texel of a texture; 1 without one.
fn largest(scene: &Scene, texture: Option<u32>) -> Vec3 {
    texture.map_or(Vec3::ONE, |texture| scene.textures[texture as usize].maximum(&scene.images))
}

/// Mean color of a texture; 1 without one.
fn mean(scene: &Scene, texture: Option<u32>) -> Vec3 {
    texture.map_or(Vec3::ONE, |texture| scene.textures[texture as usize].mean(&scene.images))
}

fn mean_rgb(color: Vec3) -> f64 {
    f64::from(color.element_sum()) / 3.0
}

/// Area lights of a scene, in the order of their numbers.
struct AreaLights {
    /// The index of one that an instance shows is its place among the placed ones.
    candidates: Vec<Candidate>,
    placed: Vec<PlacedLightRecord>,
}

fn area_lights(scene: &Scene, bvh: &Bvh) -> AreaLights {
    let emits = |index: &u32| bvh.attributes[*index as usize].light != constants::NONE;
    let of_parts: Vec<Vec<u32>> =
        bvh.parts.iter().map(|part| part.primitives.clone().filter(emits).collect()).collect();
    let has_lamps = of_parts.iter().any(|lights| !lights.is_empty());
    // Primitives that emit, each with the instance that shows it, if there is one.
    let mut emitting: Vec<(u32, Option<u32>)> = Vec::new();
    for leaf in 0..bvh.world_len() as u32 {
        let record = &bvh.primitives[leaf as usize];
        match bvh.has_instances() && is_instance(record) {
            true if has_lamps => {
                let lights = &of_parts[number_of_part(&bvh.parts, record)];
                emitting.extend(lights.iter().map(|&primitive| (primitive, Some(leaf))));
            }
            true => {}
            false => emitting.extend(emits(&leaf).then_some((leaf, None))),
        }
    }
    let has_texture = |index: u32| {
        let attributes = &bvh.attributes[index as usize];
        scene.emitters[attributes.emitter as usize].radiance.texture.is_some()
    };
    let points = points_for(emitting.iter().filter(|(index, _)| has_texture(*index)).count());
    // Each is the maximum over a whole image, so it is not found again for each triangle.
    let brightest: Vec<_> = scene.emitters.iter().map(|emitter| brightest_texel(scene, emitter)).collect();
    let power = |&(index, instance): &(u32, Option<u32>)| {
        let attributes = &bvh.attributes[index as usize];
        let emitter = &scene.emitters[attributes.emitter as usize];
        let primitive = &bvh.primitives[index as usize];
        let of_texture = |texture: u32| {
            let maximum = brightest[attributes.emitter as usize].unwrap_or_default();
            brightness(&scene.textures[texture as usize], &scene.images, maximum, primitive, attributes, points)
        };
        let of_cone = emitter.cone.map_or(1.0, |cone| cone.share());
        let radiance = of_cone * mean_rgb(emitter.radiance.value) * emitter.radiance.texture.map_or(1.0, of_texture);
        let area_of = |primitive: &PrimitiveRecord| {
            let in_world = instance.map(|instance| shown(primitive, &bvh.attributes[instance as usize]));
            area(in_world.as_ref().unwrap_or(primitive))
        };
        let area = match is_deforming(primitive) {
            true => mean_area(bvh.deforming_vertices(primitive).map(|vertices| area_of(&spanned(primitive, vertices)))),
            false => area_of(primitive),
        };
        area * PI * radiance * f64::from(emitter.sampling_weight)
    };
    let powers: Vec<f64> = emitting.par_iter().map(power).collect();
    let mut placed = Vec::new();
    let candidate = |(&(primitive, instance), power): (&(u32, Option<u32>), f64)| match instance {
        None => Candidate { kind: constants::LIGHT_AREA, index: primitive, power },
        Some(instance) => {
            placed.push(PlacedLightRecord { primitive, instance, unused: [0; 2] });
            Candidate { kind: constants::LIGHT_PLACED, index: placed.len() as u32 - 1, power }
        }
    };
    let candidates = emitting.iter().zip(powers).map(candidate).collect();
    AreaLights { candidates, placed }
}

/// The triangle with other vertices.
fn spanned(triangle: &PrimitiveRecord, [a, b, c]: [Vec3; 3]) -> PrimitiveRecord {
    PrimitiveRecord { origin: a.into(), edge_u: (b - a).into(), edge_v: (c - a).into(), ..*triangle }
}

/// Mean of the areas at all times.
fn mean_area(areas: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = areas.fold((0.0, 0.0), |(sum, count), area| (sum + area, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// Area of a primitive.
fn area(primitive: &PrimitiveRecord) -> f64 {
    let [edge_u, edge_v] = [primitive.edge_u, primitive.edge_v].map(|edge| Vec3::from(edge).as_dvec3());
    let spanned = edge_u.cross(edge_v).length();
    match primitive.flags & constants::PRIMITIVE_SHAPE_MASK {
        constants::SHAPE_TRIANGLE => 0.5 * spanned,
        constants::SHAPE_PARALLELOGRAM => 4.0 * spanned,
        constants::SHAPE_DISK => PI * spanned,
        _ => 4.0 * PI * edge_u.length_squared(),
    }
}

/// Order of the delta lights. For groups, lights that are near each other follow each other, and those without a position are
/// last.
fn delta_order(scene: &Scene, bvh: &Bvh, in_groups: bool) -> Vec<usize> {
    /// Places along each side of the scene's box.
    const PLACES: f32 = 65536.0;
    let mut order: Vec<usize> = (0..scene.delta_emitters.len()).collect();
    if in_groups {
        let (low, high) = bvh.bounds;
        let place = |position: Vec3| {
            (PLACES * (position - low) / (high - low).max(Vec3::splat(f32::MIN_POSITIVE)))
                .clamp(Vec3::ZERO, Vec3::splat(PLACES))
        };
        let key = |&i: &usize| {
            scene.delta_emitters[i].kind.position().map_or(u64::MAX, |at| morton_key(place(at).as_uvec3()))
        };
        order.sort_by_key(key);
    }
    order
}

fn light_records(candidates: &[Candidate]) -> Vec<LightRecord> {
    let powers: Vec<f64> = candidates.iter().map(|candidate| candidate.power).collect();
    let record = |(candidate, entry): (&Candidate, AliasEntry)| LightRecord {
        threshold: entry.threshold,
        group_and_alias: entry.alias,
        kind_and_index: candidate.kind_and_index(),
        probability: entry.probability,
    };
    candidates.iter().zip(alias_table(&powers)).map(record).collect()
}

fn emitter_record(emitter: &AreaEmitter) -> EmitterRecord {
    let Textured { value, texture } = emitter.radiance;
    EmitterRecord { radiance: value.into(), texture_index: texture.unwrap_or(constants::NONE) }
}

fn cone_records(emitters: &[AreaEmitter]) -> Vec<ConeRecord> {
    if emitters.iter().all(|emitter| emitter.cone.is_none()) {
        return Vec::new();
    }
    let record = |cone: Cone| {
        let rise = cone.cos_beam - cone.cos_cutoff;
        ConeRecord { slope: (cone.axis / rise as f32).into(), offset: (-cone.cos_cutoff / rise) as f32 }
    };
    let none = ConeRecord { slope: [0.0; 3], offset: 1.0 };
    emitters.iter().map(|emitter| emitter.cone.map_or(none, record)).collect()
}

fn delta_light_kind(emitter: &DeltaEmitter) -> u32 {
    match emitter.kind {
        DeltaKind::Point { .. } => constants::LIGHT_POINT,
        DeltaKind::Spot { .. } => constants::LIGHT_SPOT,
        DeltaKind::Directional { .. } => constants::LIGHT_DIRECTIONAL,
        DeltaKind::PicturedSpot { .. } => constants::LIGHT_PICTURED_SPOT,
        DeltaKind::Projector { .. } => constants::LIGHT_PROJECTOR,
    }
}

/// Power of a delta light in W. A directional light counts by the power that meets the disk of the scene's radius.
fn delta_power(scene: &Scene, emitter: &DeltaEmitter, scene_radius: f64) -> f64 {
    let cone = |cutoff_angle: f32, beam_width: f32| {
        let mean_angle = 0.5 * f64::from(cutoff_angle + beam_width.min(cutoff_angle));
        2.0 * PI * (1.0 - mean_angle.cos())
    };
    match emitter.kind {
        DeltaKind::Point { intensity, .. } => 4.0 * PI * mean_rgb(intensity),
        DeltaKind::Spot { intensity, cutoff_angle, beam_width, .. } => {
            cone(cutoff_angle, beam_width) * mean_rgb(intensity)
        }
        DeltaKind::PicturedSpot { intensity, cutoff_angle, beam_width, .. } => {
            cone(cutoff_angle, beam_width) * mean_rgb(intensity.value * mean(scene, intensity.texture))
        }
        DeltaKind::Projector { irradiance, axes, .. } => {
            let area = 1.0 / f64::from(axes.u.length() * axes.v.length());
            PI * area * mean_rgb(irradiance.value * mean(scene, irradiance.texture))
        }
        DeltaKind::Directional { irradiance, .. } => PI * scene_radius * scene_radius * mean_rgb(irradiance),
    }
}

/// Record of a delta light, without its picture.
fn plain_record(kind: &DeltaKind) -> DeltaLightRecord {
    let zero = DeltaLightRecord { texture_index: constants::NONE, ..bytemuck::Zeroable::zeroed() };
    match *kind {
        DeltaKind::Point { position, intensity } => {
            DeltaLightRecord { position: position.into(), intensity: intensity.into(), ..zero }
        }
        DeltaKind::Spot { position, direction, intensity, cutoff_angle, beam_width } => DeltaLightRecord {
            position: position.into(),
            cos_cutoff: cutoff_angle.cos(),
            direction: direction.into(),
            cutoff_angle,
            intensity: intensity.into(),
            // Without a transition, the intensity falls at once.
            falloff: 1.0 / (cutoff_angle - beam_width).max(1.0e-20),
            ..zero
        },
        DeltaKind::Directional { direction, irradiance } => {
            DeltaLightRecord { direction: direction.into(), intensity: irradiance.into(), ..zero }
        }
        DeltaKind::PicturedSpot { position, direction, axes, intensity, cutoff_angle, beam_width } => {
            let intensity = intensity.value;
            let spot = DeltaKind::Spot { position, direction, intensity, cutoff_angle, beam_width };
            with_axes(plain_record(&spot), axes)
        }
        DeltaKind::Projector { position, direction, axes, irradiance } => {
            let (position, direction) = (position.into(), direction.into());
            let intensity = (irradiance.value * PI as f32).into();
            with_axes(DeltaLightRecord { position, direction, intensity, ..zero }, axes)
        }
    }
}

fn with_axes(record: DeltaLightRecord, axes: PictureAxes) -> DeltaLightRecord {
    DeltaLightRecord { axis_u: axes.u.into(), axis_v: axes.v.into(), ..record }
}

fn delta_record(kind: &DeltaKind) -> DeltaLightRecord {
    DeltaLightRecord { texture_index: kind.texture().unwrap_or(constants::NONE), ..plain_record(kind) }
}
