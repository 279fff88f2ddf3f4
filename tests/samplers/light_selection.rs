//! Selection of lights by what a cell has learned: `glsl/include/light/light_selection.glsl`, and the update at the end of a step,
//! `glsl/kernels/learn/update_lights.comp`.

use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{DVec3, Vec3, vec3};
use lodestar::encode::cosine_trees::{Node, nodes_per_tree};
use lodestar::generated::constants::{BIAS_8, DROPPED_BITS};
use lodestar::generated::kernels::{STORAGE_BUFFERS, Variant};
use lodestar::generated::layout::{LearnedRadiance, RadianceSum, SceneConstants, UpdatePush};
use lodestar::gpu::{Buffer, BufferKind};
use lodestar::scene::texture::Texels;
use lodestar::scene::{DeltaEmitter, DeltaKind, Environment, EnvironmentKind, Image, PrimitiveShape, Scene};
use support::device::Device;
use support::primitives::primitive;
use support::statistics::{Numbers, mean_and_error, within_four_sigma};
use support::twins::radiance_grid::FIXED_POINT_UNITS;

use crate::lights::{LightInput, LightOutput, draw, draw_selected, emitting, empty_scene};

const SAMPLES: usize = 1 << 17;

/// Small lights all around the origin, none behind another. They face it.
fn around(count: usize, shape: PrimitiveShape) -> Scene {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let light = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let (sine, cosine) = (golden * i as f64).sin_cos();
        let at = (DVec3::new(cosine, sine, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z).as_vec3()
            * (2.0 + 0.1 * (i % 5) as f32);
        let u = at.any_orthonormal_vector() * (0.5 / (count as f32).sqrt());
        (primitive(shape, at, u, u.cross(at.normalize())), 1.0 + (i % 3) as f32)
    };
    emitting(&(0..count).map(light).collect::<Vec<_>>())
}

fn with_environment(mut scene: Scene, has_map: bool) -> Scene {
    let kind = if has_map {
        let texels = (0..20 * 10).map(|i| [0.2 + (i % 7) as f32, if i == 77 { 90.0 } else { 1.0 }, 0.5, 1.0]).collect();
        scene.images.push(Image { name: "map".into(), width: 20, height: 10, texels: Texels::Floats(texels) });
        EnvironmentKind::Map { image: 0, scale: 1.0, to_world: glam::Mat3::from_rotation_y(0.9) }
    } else {
        EnvironmentKind::Constant { radiance: vec3(1.0, 2.0, 3.0) }
    };
    scene.environment = Some(Environment { kind, sampling_weight: 1.0 });
    scene
}

/// The scene with point lights, the first of which is never drawn.
fn with_points(mut scene: Scene, count: usize) -> Scene {
    let point = |i: usize| DeltaEmitter {
        kind: DeltaKind::Point {
            position: vec3((0.3 * i as f32).sin(), (0.7 * i as f32).cos(), 0.1 * i as f32 - 1.0),
            intensity: Vec3::splat(if i == 0 { 0.0 } else { 0.1 }),
        },
        sampling_weight: if i == 0 { 0.0 } else { 1.0 },
    };
    scene.delta_emitters = (0..count).map(point).collect();
    scene
}

fn cases() -> Vec<(&'static str, Scene)> {
    use PrimitiveShape::{Disk, Parallelogram, Sphere, Triangle};
    let one =
        |shape| emitting(&[(primitive(shape, vec3(0.2, 1.0, 0.1), vec3(0.9, 0.1, 0.2), vec3(-0.1, -0.2, 0.8)), 3.0)]);
    let rectangle = |scene: Scene| Scene { environment: scene.environment, images: scene.images, ..one(Parallelogram) };
    vec![
        ("a parallelogram in patches", one(Parallelogram)),
        ("a triangle in patches", one(Triangle)),
        ("a disk in patches", one(Disk)),
        ("spheres", around(5, Sphere)),
        ("parallelograms in few patches", around(40, Parallelogram)),
        ("groups of triangles", around(3000, Triangle)),
        ("a constant environment", with_environment(empty_scene(), false)),
        ("triangles and points under a sky", with_environment(with_points(around(250, Triangle), 40), false)),
        ("points", with_points(empty_scene(), 12)),
        ("a map and a parallelogram", rectangle(with_environment(empty_scene(), true))),
    ]
}

/// Irradiance by samples from an octant of directions: its mean and standard error. All is seen from the origin.
fn irradiance(drawn: &[LightOutput], octant: usize) -> (f64, f64) {
    let is_inside =
        |wi: DVec3| [wi.x, wi.y, wi.z].iter().zip([1, 2, 4]).all(|(&x, bit)| (x > 0.0) == (octant & bit != 0));
    let value = |s: &LightOutput| {
        let brings = s.pdf > 0.0 && is_inside(s.wi());
        if brings { f64::from(s.radiance[0] + s.radiance[1]) / f64::from(s.pdf) } else { 0.0 }
    };
    mean_and_error(drawn.iter().map(value))
}

/// Weights that have nothing to do with power. Groups that are not used have small ones.
fn odd_weights(powers: &[f32]) -> Vec<f32> {
    let mut numbers = Numbers::new(7);
    powers.iter().map(|&power| if power > 0.0 { 8_f64.powf(numbers.unit()) as f32 } else { 1.0e-6 }).collect()
}

/// Whatever a cell's weights are, samples bring the same light, and a light that is hit has the density of a sample.
#[test]
fn the_light_and_its_density_do_not_depend_on_weights() {
    let inputs = vec![LightInput { from: [0.0; 3], direction: [0.0, 0.0, 1.0] }; SAMPLES];
    for ((name, scene), seed) in cases().into_iter().zip(61..) {
        let by_power = draw(&scene, &inputs, seed);
        let by_weights = draw_selected(&scene, &inputs, seed + 100, Some(odd_weights));
        // Another light may lie before the one that was drawn.
        let differs = |s: &&LightOutput| {
            s.pdf > 0.0 && s.along_wi.radiance == s.radiance && (s.along_wi.pdf / s.pdf - 1.0).abs() > 1.0e-3
        };
        let differing = by_weights.iter().filter(differs).count();
        // Near the border of a patch, rounding decides which patch a ray hits.
        assert!(differing <= SAMPLES / 1000, "{name}: {differing} densities differ");
        let mut doubted = 0;
        for octant in 0..8 {
            let (mean, error) = irradiance(&by_weights, octant);
            let (expected, other_error) = irradiance(&by_power, octant);
            let found = (mean, error.hypot(other_error));
            assert!(
                (found.1 == 0.0 && expected == 0.0) || within_four_sigma(found, expected),
                "{name}, octant {octant}: {found:?}, not {expected}"
            );
            doubted += usize::from(found.1 > 0.0 && !within_four_sigma(found, 1.1 * expected));
        }
        assert!(doubted > 0, "{name}: a tenth more light is not found");
        assert!(by_power.iter().zip(&by_weights).any(|(a, b)| a.pdf != b.pdf), "{name}: the weights do nothing");
    }
}

const CELLS: u32 = 3;
const LIMIT: f32 = 32.0;
const DIRECTIONS: u32 = 16;
const BINS: u32 = DIRECTIONS * DIRECTIONS;
/// Constants of the kernel.
const POWER_EVIDENCE: f64 = 8.0;
const POWER_SHARE: f64 = 0.0625;
const EVEN_SHARE: f64 = 0.0625;
const DECAY: f32 = 0.75;

/// Evidence of a step about a group: the sum of what connections found, and their number.
type Evidence = (f64, u32);

/// What a cell knows, and the twin of the update.
#[derive(Clone)]
struct Twin {
    power: Vec<f64>,
    means: Vec<(f64, f64)>,
}

impl Twin {
    /// Probability of every group after a step.
    fn update(&mut self, step: &[Evidence], even_share: f64) -> Vec<f64> {
        for ((mean, weight), &(sum, count)) in self.means.iter_mut().zip(step) {
            let decayed = *weight * f64::from(DECAY);
            *weight = decayed + f64::from(count);
            if count > 0 {
                *mean = (*mean * decayed + sum) / *weight;
            }
        }
        let found: f64 = self.means.iter().map(|(mean, weight)| mean * weight).sum();
        let expected: f64 = self.means.iter().zip(&self.power).map(|((_, weight), power)| weight * power).sum();
        let scale = if expected > 0.0 { found / expected } else { 0.0 };
        let estimate = |((mean, weight), power): (&(f64, f64), &f64)| {
            (weight * mean + POWER_EVIDENCE * scale * power) / (weight + POWER_EVIDENCE)
        };
        let estimates: Vec<f64> = self.means.iter().zip(&self.power).map(estimate).collect();
        let sum: f64 = estimates.iter().sum();
        let learned = |estimate: f64| if sum > 0.0 { (1.0 - POWER_SHARE - even_share) * estimate / sum } else { 0.0 };
        let used = self.power.iter().filter(|&&power| power > 0.0).count() as f64;
        let even = |power: f64| if power > 0.0 { even_share / used } else { 0.0 };
        let weights: Vec<f64> = estimates
            .iter()
            .zip(&self.power)
            .map(|(&estimate, &power)| learned(estimate) + POWER_SHARE * power + even(power))
            .collect();
        let sum: f64 = weights.iter().sum();
        weights.iter().map(|weight| weight / sum).collect()
    }
}

/// Tables of a few cells, and the kernel that ends a step.
struct Grid {
    device: Device,
    variant: Variant,
    scene: Arc<Buffer>,
    learned: Arc<Buffer>,
    sums: Arc<Buffer>,
    nodes: Arc<Buffer>,
}

impl Grid {
    fn new(groups: u32, powers: &[f64]) -> Self {
        let device = Device::new();
        let lights = CELLS * groups;
        let scene = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        let constants =
            SceneConstants { target_limit: LIMIT, cell_count: CELLS, all_cell_count: CELLS, ..Zeroable::zeroed() };
        scene.upload(0, &[constants]).expect("uploaded");
        let grid = Self {
            learned: device
                .storage("learned", (CELLS * BINS + lights + groups) as usize * size_of::<LearnedRadiance>()),
            sums: device.storage("sums", (CELLS * BINS + lights) as usize * size_of::<RadianceSum>()),
            nodes: device.storage("nodes", (CELLS * (nodes_per_tree(DIRECTIONS) + 17)) as usize * size_of::<Node>()),
            variant: Variant {
                direction_resolution: DIRECTIONS,
                light_groups: groups,
                decay: DECAY,
                ..Variant::default()
            },
            scene,
            device,
        };
        let powers: Vec<_> = powers.iter().map(|&power| LearnedRadiance { mean: power as f32, weight: 0.0 }).collect();
        let at = u64::from(CELLS * BINS + lights) * size_of::<LearnedRadiance>() as u64;
        grid.learned.upload(at, &powers).expect("uploaded");
        grid
    }

    /// Probabilities of the groups of every cell after a step.
    fn update(&self, step: &[Evidence]) -> Vec<Vec<f64>> {
        let sum = |&(value, target_count): &Evidence| {
            let units = (value / f64::from(LIMIT) * FIXED_POINT_UNITS) as u64;
            RadianceSum { low: units as u32, high: (units >> 32) as u32, target_count, flux: 0.0 }
        };
        let sums: Vec<_> = step.iter().map(sum).collect();
        self.sums.upload(u64::from(CELLS * BINS) * size_of::<RadianceSum>() as u64, &sums).expect("uploaded");
        let named = [
            ("Scene", &self.scene),
            ("LearnedTable", &self.learned),
            ("RadianceSums", &self.sums),
            ("RadianceNodes", &self.nodes),
        ];
        let push = UpdatePush { first_cell: 0, ends_step: 1 };
        let kernel = &STORAGE_BUFFERS.update_lights;
        self.device.dispatch_renderers(kernel, &self.variant, &named, bytemuck::bytes_of(&push), CELLS);
        let nodes_per_cell = if self.variant.light_groups == 16 { 1 } else { 17 };
        let first = u64::from(CELLS * nodes_per_tree(DIRECTIONS)) * size_of::<Node>() as u64;
        let nodes: Vec<Node> = self.nodes.read(first, CELLS as usize * nodes_per_cell).expect("read");
        nodes.chunks_exact(nodes_per_cell).map(probabilities).collect()
    }
}

/// Probabilities of a node's parts: twin of `unpack_weights_8`.
fn parts(node: &Node) -> Vec<f64> {
    let code = |i: usize| node[i / 4] >> (8 * (i % 4)) & 255;
    let weights: Vec<f64> =
        (0..16).map(|i| f64::from(f32::from_bits((code(i) << DROPPED_BITS) + (BIAS_8 << 23)))).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / sum).collect()
}

fn probabilities(tree: &[Node]) -> Vec<f64> {
    let upper = parts(&tree[0]);
    if tree.len() == 1 {
        return upper;
    }
    upper.iter().zip(&tree[1..]).flat_map(|(part, node)| parts(node).into_iter().map(move |p| p * part)).collect()
}

#[test]
fn probabilities_are_what_the_evidence_says() {
    for (groups, used) in [(16, 5), (16, 16), (256, 256), (256, 70)] {
        let mut numbers = Numbers::new(groups + used);
        let mut powers: Vec<f64> =
            (0..groups).map(|g| if g < used { numbers.between(0.1, 2.0) } else { 0.0 }).collect();
        let total: f64 = powers.iter().sum();
        powers.iter_mut().for_each(|power| *power /= total);
        let grid = Grid::new(groups, &powers);
        let mut twins = vec![Twin { power: powers.clone(), means: vec![(0.0, 0.0); groups as usize] }; CELLS as usize];
        let mut tampered = twins.clone();
        let mut differ = 0;
        for number in 0..4 {
            // The first step has no evidence, and the last cell never has any.
            let evidence = |index: u32| {
                let (cell, group) = (index / groups, index % groups);
                let count = if number == 0 || cell + 1 == CELLS || group >= used { 0 } else { 1 + index * 7 % 400 };
                let found = if index.is_multiple_of(3) { 0.0 } else { f64::from(1 + index * 13 % 50) / 25.0 };
                (f64::from(count) * found, count)
            };
            let step: Vec<Evidence> = (0..CELLS * groups).map(evidence).collect();
            let found = grid.update(&step);
            for (cell, of_step) in step.chunks_exact(groups as usize).enumerate() {
                let twin = twins[cell].update(of_step, EVEN_SHARE);
                let other = tampered[cell].update(of_step, 0.25 * EVEN_SHARE);
                for group in 0..groups as usize {
                    // Both levels of a tree round their weights to three bits, and the smallest weight is not 0.
                    let agrees = |p: f64| (found[cell][group] - p).abs() <= 0.2 * p + 1.0e-8;
                    assert!(agrees(twin[group]), "step {number}, cell {cell}, group {group}: {found:?}, not {twin:?}");
                    let is_used = group < used as usize;
                    assert!(!is_used || found[cell][group] > 0.8 * EVEN_SHARE / f64::from(used), "forgotten: {group}");
                    differ += usize::from(!agrees(other[group]));
                }
            }
        }
        assert!(differ > 0, "another share of even draws is not found");
    }
}
