//! Parent cells of `glsl/kernels/learn/pool_radiance.comp` and `glsl/kernels/learn/blend_radiance.comp`, against the
//! twins and in closed form.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{UVec3, Vec2, Vec3};
use lodestar::encode::bvh::Bvh;
use lodestar::encode::cells::Cells;
use lodestar::generated::constants::LANES_PER_CELL;
use lodestar::generated::kernels::{STORAGE_BUFFERS, Variant};
use lodestar::generated::layout::{BlendPush, LearnedRadiance, SceneConstants, UpdatePush};
use lodestar::gpu::{Buffer, BufferKind, KernelSource};
use lodestar::scene::{Primitive, PrimitiveShape};
use support::device::Device;
use support::statistics::Numbers;
use support::twins::radiance_grid as twin;

const LIMIT: f32 = 32.0;
const FALLBACK: f32 = 6.0;
/// Weight of a block's prior, in units of FALLBACK: the constant of `glsl/include/guide/grid/block_scales.glsl`.
const BLOCK_EVIDENCE: f64 = 16.0;
const DIRECTIONS: u32 = 8;
const BINS: usize = (DIRECTIONS * DIRECTIONS) as usize;

/// Cells of a ball, on a grid whose sides are not powers of two.
fn cells() -> Cells {
    let ball = Primitive {
        shape: PrimitiveShape::Sphere,
        origin: Vec3::ZERO,
        edge_u: Vec3::X,
        edge_v: Vec3::Z,
        normals: None,
        uvs: [Vec2::ONE; 3],
        flip_normal: false,
        front_only: false,
        unseen: false,
        material: 0,
        emitter: None,
    };
    Cells::new(&Bvh::build(&[ball]), &[], UVec3::new(7, 5, 6))
}

/// Device with the kernels that pool and blend learned radiance.
struct Blend {
    device: Device,
    cells: Cells,
    scene: Arc<Buffer>,
    table: Arc<Buffer>,
    learned: Arc<Buffer>,
    radiance: Arc<Buffer>,
}

impl Blend {
    fn new() -> Self {
        let (device, cells) = (Device::new(), cells());
        let scene = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        let constants = SceneConstants {
            target_limit: LIMIT,
            grid_size: cells.grid.size.into(),
            cell_count: cells.count(),
            all_cell_count: cells.all_count(),
            ..SceneConstants::zeroed()
        };
        scene.upload(0, &[constants]).expect("uploaded");
        Self {
            table: device.uploaded("cells", &cells.table),
            learned: device.storage("learned", cells.all_count() as usize * BINS * size_of::<LearnedRadiance>()),
            radiance: device.storage("radiance", cells.count() as usize * BINS * size_of::<f32>()),
            scene,
            device,
            cells,
        }
    }

    fn pool(&self, cells: Range<u32>) {
        let push = UpdatePush { first_cell: cells.start, ends_step: 1 };
        self.dispatch(&STORAGE_BUFFERS.pool_radiance, bytemuck::bytes_of(&push), cells.end - cells.start);
    }

    fn blend(&self, cells: Range<u32>) {
        let push = BlendPush { first_cell: cells.start, end_cell: cells.end };
        let groups = (LANES_PER_CELL * (cells.end - cells.start)).div_ceil(Variant::default().workgroup_size);
        self.dispatch(&STORAGE_BUFFERS.blend_radiance, bytemuck::bytes_of(&push), groups);
    }

    fn dispatch(&self, kernel: &KernelSource, push: &[u8], groups: u32) {
        let variant = Variant { fallback: FALLBACK, direction_resolution: DIRECTIONS, ..Variant::default() };
        let named = [
            ("Scene", &self.scene),
            ("CellTable", &self.table),
            ("LearnedTable", &self.learned),
            ("RadianceTable", &self.radiance),
        ];
        self.device.dispatch_renderers(kernel, &variant, &named, push, groups);
    }

    /// Table `[cell][bin]` after the cells have learned `learned`.
    fn radiance(&self, learned: &[LearnedRadiance]) -> Vec<f32> {
        self.learned.upload(0, learned).expect("uploaded");
        let levels = self.cells.parent_levels();
        levels.iter().for_each(|level| self.pool(level.clone()));
        let from_the_largest = levels.iter().rev().cloned().chain(std::iter::once(0..self.cells.count()));
        from_the_largest.for_each(|level| self.blend(level));
        self.radiance.read(0, self.cells.count() as usize * BINS).expect("read")
    }

    /// Table of the twins.
    fn expected(&self, learned: &[LearnedRadiance], fallback: f64, evidence: f64) -> Vec<f64> {
        let (count, all) = (self.cells.count() as usize, self.cells.all_count() as usize);
        let (parents, first_children) =
            self.cells.table[self.cells.grid.size.element_product() as usize..].split_at(all);
        let wide = |l: &LearnedRadiance| twin::LearnedRadiance { mean: l.mean.into(), weight: l.weight.into() };
        let mut known: Vec<Vec<_>> = learned.chunks(BINS).map(|cell| cell.iter().map(wide).collect()).collect();
        for children in first_children.windows(2) {
            let cells = &known[children[0] as usize..children[1] as usize];
            let of_bin = |bin: usize| cells.iter().map(|cell| cell[bin]).collect::<Vec<_>>();
            known.push((0..BINS).map(|bin| twin::pooled(&of_bin(bin), fallback)).collect());
        }
        let mut estimates = vec![Vec::new(); all];
        for cell in (0..all).rev() {
            let scaled = estimates.get(parents[cell] as usize).map(|parent: &Vec<f64>| {
                let scales = twin::block_scales(&known[cell], parent, DIRECTIONS as usize, evidence);
                scales.iter().zip(parent).map(|(scale, estimate)| scale * estimate).collect::<Vec<_>>()
            });
            let prior = |bin: usize| scaled.as_ref().map(|scaled| scaled[bin]);
            estimates[cell] =
                (0..BINS).map(|bin| twin::blended(known[cell][bin], prior(bin), fallback)).collect::<Vec<f64>>();
        }
        estimates[..count].iter().flat_map(|cell| twin::floored(cell, LIMIT.into())).collect()
    }
}

/// Learned radiance: for each bin, many cells have learned nothing, others little or much.
fn some(cells: &Cells) -> Vec<LearnedRadiance> {
    let mut numbers = Numbers::new(17);
    let mut learned = |_| {
        let weight = if numbers.unit() < 0.4 { 0.0 } else { 10_f64.powf(numbers.between(-1.0, 3.0)) };
        let mean = if weight == 0.0 { 0.0 } else { 10_f64.powf(numbers.between(-3.0, 1.0)) };
        LearnedRadiance { mean: mean as f32, weight: weight as f32 }
    };
    (0..cells.count() as usize * BINS).map(&mut learned).collect()
}

fn worst(ours: &[f32], twin: &[f64]) -> f64 {
    assert_eq!(ours.len(), twin.len());
    ours.iter().zip(twin).map(|(&a, b)| (f64::from(a) / b - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn cells_fall_back_as_the_twins_do() {
    let blend = Blend::new();
    assert!(blend.cells.count() > 50 && blend.cells.parent_levels().len() == 3);
    let learned = some(&blend.cells);
    let ours = blend.radiance(&learned);
    let (fallback, evidence) = (f64::from(FALLBACK), BLOCK_EVIDENCE * f64::from(FALLBACK));
    let off = worst(&ours, &blend.expected(&learned, fallback, evidence));
    assert!(off < 1.0e-4, "{off}");
    // The twins must fail: parents with a 5 % larger weight, and blocks whose prior has a 5 % larger weight.
    assert!(worst(&ours, &blend.expected(&learned, 1.05 * fallback, evidence)) > 1.0e-2);
    assert!(worst(&ours, &blend.expected(&learned, fallback, 1.05 * evidence)) > 1.0e-3);
    // A second run gives the same table: earlier blended values do not matter.
    assert!(blend.radiance(&learned) == ours);
}

/// Cells that have learned nothing borrow from cells that have. If one cell alone has learned something, all others
/// take its radiance. If all cells are sure, each keeps its own.
#[test]
fn what_nobody_knows_is_taken_from_who_does() {
    let blend = Blend::new();
    let count = blend.cells.count() as usize;
    let mean = |bin: usize| 1.0 + bin as f32 / 16.0;
    let mut learned = vec![LearnedRadiance::zeroed(); count * BINS];
    for bin in 0..BINS {
        learned[9 * BINS + bin] = LearnedRadiance { mean: mean(bin), weight: 3.0 };
    }
    for (i, l) in blend.radiance(&learned).iter().enumerate() {
        assert!((l / mean(i % BINS) - 1.0).abs() < 1.0e-5, "{i}: {l}");
    }
    let sure: Vec<_> =
        some(&blend.cells).iter().map(|l| LearnedRadiance { mean: l.mean + 0.5, weight: 1.0e9 }).collect();
    for (l, own) in blend.radiance(&sure).iter().zip(&sure) {
        assert!((l / own.mean - 1.0).abs() < 1.0e-5, "{l}, not {}", own.mean);
    }
}

/// A cell that has found some bins brighter than its parent expects takes the bins that it knows nothing about to be brighter by
/// the same factor.
#[test]
fn known_bins_scale_their_unknown_neighbors() {
    let blend = Blend::new();
    let count = blend.cells.count() as usize;
    let (cell, weight, brighter) = (9, 1.0e6, 3.0);
    let mut learned = vec![LearnedRadiance { mean: 1.0, weight }; count * BINS];
    // The cell knows every other bin of one half of the map.
    let is_known = |bin: usize| bin < BINS / 2 && bin.is_multiple_of(2);
    for (bin, l) in learned[cell * BINS..(cell + 1) * BINS].iter_mut().enumerate() {
        *l = if is_known(bin) { LearnedRadiance { mean: brighter, weight } } else { LearnedRadiance::zeroed() };
    }
    let parents = &blend.cells.table[blend.cells.grid.size.element_product() as usize..];
    let siblings = parents[..count].iter().filter(|&&parent| parent == parents[cell]).count() as f32;
    assert!(siblings > 1.0);
    // The parent's estimate is the mean over its cells: 1 in the bins that this cell does not know.
    let of_parent = (siblings - 1.0 + brighter) / siblings;
    for (bin, l) in blend.radiance(&learned)[cell * BINS..(cell + 1) * BINS].iter().enumerate() {
        let expected = if is_known(bin) { brighter } else { brighter / of_parent };
        assert!((l / expected - 1.0).abs() < 1.0e-3, "bin {bin}: {l}, not {expected}");
    }
}
