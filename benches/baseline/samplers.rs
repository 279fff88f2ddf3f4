//! Samples per second of the guides' samplers (`glsl/test/guided_direction.comp`). A sample draws a direction from one
//! cell and then evaluates its density separately, as emitter sampling does.

use std::rc::Rc;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec3, dvec2};
use lodestar::generated::kernels::{Variant, test};
use lodestar::generated::layout::SceneConstants;
use lodestar::gpu::{Buffer, BufferKind, DeviceKind, Kernel};
use lodestar::math::direction_map::{bin_center, map_to_sphere};
use lodestar::settings::{DirectionMap, Sampler};
use support::bench::rates::{mean_seconds, seconds_of};
use support::device::{Cell, Device, GROUP};
use support::twins::quadtree::Square;

use crate::quantity::{Place, Quantity, Unit};

const SAMPLERS: [(&str, Sampler); 6] = [
    ("product", Sampler::Product),
    ("rejection-mix", Sampler::RejectionMix),
    ("rejection", Sampler::Rejection),
    ("hemisphere-inversion", Sampler::HemisphereInversion),
    ("sphere-inversion", Sampler::SphereInversion),
    ("quadtree", Sampler::Quadtree),
];
/// Minimum time for which each sampler is repeated, in seconds.
const SECONDS: f64 = 0.08;
const DIRECTIONS: u32 = 16;
const NORMALS: u32 = 16;
/// Number of levels of the quadtree before it is refined: 2^7 squares along each side.
const QUADTREE_LEVELS: u32 = 7;
/// Size of the record that `guided_direction.comp` writes for a sample, in bytes.
const DRAWN_BYTES: usize = 32;

/// Radiance as a function of the direction.
type Radiance = fn(DVec3) -> f64;

/// Radiance tables: a smooth one, and a lamp that covers about 4 % of the sphere.
const TABLES: [(&str, Radiance); 2] =
    [("smooth", |w| 1.0 + 0.5 * w.dot(lamp())), ("peaked", |w| if w.dot(lamp()) > 0.93 { 50.0 } else { 0.1 })];

fn lamp() -> DVec3 {
    DVec3::new(0.4, 0.3, 0.9).normalize()
}

/// Push constants of `guided_direction.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    normal: [f32; 3],
    seed: u32,
}

/// Sampler with a filled table.
struct Subject {
    device: Arc<Device>,
    kernel: Kernel,
    /// Buffers, in the order of set and binding.
    buffers: Vec<Arc<Buffer>>,
    count: u32,
}

pub fn quantities(device: &Arc<Device>) -> Vec<Quantity> {
    let pairs = SAMPLERS.iter().flat_map(|sampler| TABLES.iter().map(move |table| (sampler, table)));
    let quantity = |(&(name, sampler), &(of_table, radiance)): (&(&str, Sampler), &(&str, Radiance))| {
        let subject = Rc::new(Subject::new(device, sampler, radiance));
        Quantity {
            name: format!("samples: {name}, {of_table}"),
            unit: Unit::MillionsPerSecond(f64::from(subject.count) / 1.0e6, "samples"),
            place: Place::Device,
            run: Box::new(move || mean_seconds(SECONDS, || subject.draw())),
            request: None,
        }
    };
    pairs.map(quantity).collect()
}

impl Subject {
    fn new(device: &Arc<Device>, sampler: Sampler, radiance: Radiance) -> Self {
        let count = if device.context.device().kind == DeviceKind::Cpu { 1 << 17 } else { 1 << 22 };
        let normal_resolution = if sampler == Sampler::SphereInversion { 1 } else { NORMALS };
        let variant = Variant {
            sampler: sampler as u32,
            direction_resolution: DIRECTIONS,
            normal_resolution,
            ..Variant::default()
        };
        let named = match sampler {
            Sampler::Quadtree => quadtree_buffers(device, radiance),
            _ => cell_buffers(device, &variant, radiance),
        };
        let out = device.storage("drawn", count as usize * DRAWN_BYTES);
        let scene = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        let unused = device.storage("unused", 256);
        let buffer = |name: &str| match name {
            "DrawnSamples" => Arc::clone(&out),
            "Scene" => Arc::clone(&scene),
            _ => named.iter().find(|(own, _)| *own == name).map_or_else(|| Arc::clone(&unused), |(_, b)| Arc::clone(b)),
        };
        let source = &test::GUIDED_DIRECTION;
        let bindings = source.sets.iter().flat_map(|set| set.bindings);
        let buffers = bindings.map(|binding| buffer(binding.name)).collect();
        Self { kernel: device.kernel(source, &variant), buffers, count, device: Arc::clone(device) }
    }

    /// Draws all samples once. Returns the time in seconds.
    fn draw(&self) -> f64 {
        let push = Push { normal: Vec3::Z.into(), seed: 1 };
        let buffers: Vec<_> = self.buffers.iter().collect();
        let bytes = bytemuck::bytes_of(&push);
        seconds_of(self.device.dispatch(&self.kernel, &buffers, bytes, self.count / GROUP))
    }
}

type Named = Vec<(&'static str, Arc<Buffer>)>;

/// Buffers of the grids of one cell. Each bin holds the radiance at its center.
fn cell_buffers(device: &Device, variant: &Variant, radiance: Radiance) -> Named {
    let center = |bin: u32| bin_center(DirectionMap::EqualArea, bin, DIRECTIONS);
    let table: Vec<f32> = (0..DIRECTIONS * DIRECTIONS).map(|bin| radiance(center(bin)) as f32).collect();
    let cell = Cell::new(device, variant);
    cell.fill(device, &table);
    vec![
        ("RadianceTable", cell.radiance),
        ("BinEnds", cell.bin_ends),
        ("RadianceNodes", cell.nodes),
        ("NormalizationTable", cell.entries),
        ("CosineIntegrals", cell.integrals),
        ("CosineNodes", cell.cosine_nodes),
    ]
}

/// Buffers of a quadtree that has learned the radiance.
fn quadtree_buffers(device: &Device, radiance: Radiance) -> Named {
    fn square(radiance: Radiance, corner: DVec2, side: f64, levels: u32) -> Square {
        if levels == 0 {
            let middle = map_to_sphere(DirectionMap::EqualArea, 2.0 * (corner + 0.5 * side) - 1.0);
            return Square::leaf(side * side * radiance(middle));
        }
        let quarter = |i: usize| corner + 0.5 * side * dvec2((i % 2) as f64, (i / 2) as f64);
        Square::of(std::array::from_fn(|i| square(radiance, quarter(i), 0.5 * side, levels - 1)))
    }
    let tree = square(radiance, DVec2::ZERO, 1.0, QUADTREE_LEVELS).refined();
    vec![("RadianceNodes", device.uploaded("nodes", &tree.words()))]
}
