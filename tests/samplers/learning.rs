//! `glsl/update_radiance.comp`: the renderer's own kernel.

use std::sync::Arc;

use bytemuck::Zeroable;
use lodestar::gpu::{Buffer, BufferKind};
use lodestar::kernels::{STORAGE_BUFFERS, Variant};
use lodestar::layout::{LearnedRadiance, RadianceSum, SceneConstants, UpdatePush};
use lodestar::reference::radiance_grid as twin;
use lodestar::reference::radiance_grid::FIXED_POINT_UNITS;

use crate::device::Device;
use crate::statistics::Numbers;

const LIMIT: f32 = 32.0;
const CELLS: usize = 4;

/// Grids of a few cells on the device.
struct Grid {
    device: Device,
    variant: Variant,
    radiance: Arc<Buffer>,
    learned: Arc<Buffer>,
    sums: Arc<Buffer>,
    scene: Arc<Buffer>,
    bins: usize,
}

impl Grid {
    fn new(variant: Variant) -> Self {
        let device = Device::new();
        let bins = CELLS * variant.direction_resolution.pow(2) as usize;
        let scene = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        scene.upload(0, &[SceneConstants { target_limit: LIMIT, ..SceneConstants::zeroed() }]).expect("uploaded");
        Self {
            radiance: device.storage("radiance", bins * size_of::<f32>()),
            learned: device.storage("learned", bins * size_of::<LearnedRadiance>()),
            sums: device.storage("sums", bins * size_of::<RadianceSum>()),
            device,
            variant,
            scene,
            bins,
        }
    }

    /// Ends a step that recorded `sums`, in the cells from `first` on.
    fn update(&self, sums: &[RadianceSum], first: u32, cells: u32) {
        self.sums.upload(0, sums).expect("uploaded");
        let named = [
            ("RadianceTable", &self.radiance),
            ("LearnedTable", &self.learned),
            ("RadianceSums", &self.sums),
            ("Scene", &self.scene),
        ];
        let kernel = &STORAGE_BUFFERS.update_radiance;
        for (name, _) in named {
            let mut bindings = kernel.sets.iter().flat_map(|set| set.bindings);
            assert!(bindings.any(|binding| binding.name == name), "no binding {name}: {:?}", kernel.sets);
        }
        let push = UpdatePush { first_cell: first };
        self.device.dispatch_renderers(kernel, &self.variant, &named, bytemuck::bytes_of(&push), cells);
    }

    fn radiance(&self) -> Vec<f32> {
        self.radiance.read(0, self.bins).expect("read")
    }

    fn learned(&self) -> Vec<LearnedRadiance> {
        self.learned.read(0, self.bins).expect("read")
    }

    fn sums(&self) -> Vec<RadianceSum> {
        self.sums.read(0, self.bins).expect("read")
    }
}

fn sum_of(units: u64, target_count: u32) -> RadianceSum {
    RadianceSum { low: units as u32, high: (units >> 32) as u32, target_count, reserved: 0 }
}

fn value(sum: &RadianceSum) -> f64 {
    (f64::from(sum.high) * 4_294_967_296.0 + f64::from(sum.low)) * f64::from(LIMIT) / FIXED_POINT_UNITS
}

/// What a step may record: most bins a few targets, some none, one cell nothing at all and one bin millions.
fn step(numbers: &mut Numbers, bins: usize) -> Vec<RadianceSum> {
    let silent = bins / CELLS;
    let mut bin = |index: usize| {
        let count = if index == silent { 3_000_000 } else { (numbers.unit() * 6.0) as u32 };
        let mean = 10_f64.powf(numbers.between(-6.0, 0.0)) * FIXED_POINT_UNITS;
        let count = if index < silent { 0 } else { count };
        sum_of((mean * f64::from(count)) as u64, count)
    };
    (0..bins).map(&mut bin).collect()
}

fn close(a: f32, b: f64) -> bool {
    (f64::from(a) - b).abs() <= 1.0e-5 * b.abs()
}

/// Runs some steps on the device and in the twin at `twin_decay`; whether all means and weights agree.
fn agrees(decay: f32, directions: u32, twin_decay: f64) -> bool {
    let variant = Variant { decay, direction_resolution: directions, ..Variant::default() };
    let grid = Grid::new(variant);
    let mut numbers = Numbers::new(21);
    let mut learned = vec![twin::LearnedRadiance::default(); grid.bins];
    let mut all_close = true;
    for _ in 0..6 {
        let sums = step(&mut numbers, grid.bins);
        grid.update(&sums, 0, CELLS as u32);
        for (bin, sum) in learned.iter_mut().zip(&sums) {
            *bin = twin::learn(*bin, value(sum), f64::from(sum.target_count), twin_decay);
        }
        let ours = grid.learned();
        all_close &= ours.iter().zip(&learned).all(|(a, b)| close(a.mean, b.mean) && close(a.weight, b.weight));
        let means: Vec<f64> = ours.iter().map(|l| f64::from(l.mean)).collect();
        let floored: Vec<f64> =
            means.chunks(grid.bins / CELLS).flat_map(|cell| twin::floored(cell, f64::from(LIMIT))).collect();
        assert!(grid.radiance().iter().zip(&floored).all(|(&a, &b)| close(a, b)), "floors");
        assert!(grid.radiance().iter().all(|&l| l > 0.0), "no direction loses its support");
        assert!(grid.sums().iter().all(|s| *s == sum_of(0, 0)), "the sums start anew");
    }
    all_close
}

#[test]
fn without_decay_it_is_the_mean_of_all_targets() {
    let grid = Grid::new(Variant { decay: 1.0, ..Variant::default() });
    let mut numbers = Numbers::new(22);
    let mut total = vec![(0.0, 0.0); grid.bins];
    for _ in 0..8 {
        let sums = step(&mut numbers, grid.bins);
        grid.update(&sums, 0, CELLS as u32);
        total.iter_mut().zip(&sums).for_each(|(t, s)| *t = (t.0 + value(s), t.1 + f64::from(s.target_count)));
    }
    for (bin, (learned, (sum, count))) in grid.learned().iter().zip(total).enumerate() {
        let mean = if count > 0.0 { sum / count } else { 0.0 };
        assert!(
            close(learned.mean, mean) && close(learned.weight, count),
            "bin {bin}: {learned:?}, not {mean}, {count}"
        );
    }
}

#[test]
fn with_decay_old_targets_fade_geometrically() {
    // Closed form: sum of d^age sum over sum of d^age count.
    let decay = 0.75_f64;
    let grid = Grid::new(Variant { decay: decay as f32, ..Variant::default() });
    let mut numbers = Numbers::new(23);
    let steps: Vec<_> = (0..6).map(|_| step(&mut numbers, grid.bins)).collect();
    steps.iter().for_each(|sums| grid.update(sums, 0, CELLS as u32));
    for (bin, learned) in grid.learned().iter().enumerate() {
        let faded = |f: &dyn Fn(&RadianceSum) -> f64| -> f64 {
            steps.iter().rev().zip(0..).map(|(sums, age)| f(&sums[bin]) * decay.powi(age)).sum()
        };
        let (sum, count) = (faded(&value), faded(&|s| f64::from(s.target_count)));
        let mean = if count > 0.0 { sum / count } else { 0.0 };
        assert!(
            close(learned.mean, mean) && close(learned.weight, count),
            "bin {bin}: {learned:?}, not {mean}, {count}"
        );
    }
}

#[test]
fn every_step_is_the_twins() {
    for (decay, directions) in [(1.0, 16), (0.5, 16), (0.5, 8), (0.9, 32)] {
        assert!(agrees(decay, directions, f64::from(decay)), "decay {decay}, {directions} directions");
    }
    assert!(!agrees(0.5, 16, 0.5 * 1.05), "a twin that forgets 5 % less");
    assert!(!agrees(1.0, 16, 0.99), "a twin that forgets");
}

#[test]
fn a_cell_without_targets_is_uniform_and_other_cells_are_left_alone() {
    let grid = Grid::new(Variant::default());
    grid.update(&vec![sum_of(0, 0); grid.bins], 1, 2);
    let radiance = grid.radiance();
    let cell = grid.bins / CELLS;
    assert!(radiance[cell..3 * cell].iter().all(|&l| l == radiance[cell] && l > 0.0 && l < 1.0e-9));
    assert!(radiance[..cell].iter().chain(&radiance[3 * cell..]).all(|&l| l == 0.0));
    // One bright bin lifts all others of its cell, and of no other, to a share of the cell's mean.
    let mut sums = vec![sum_of(0, 0); grid.bins];
    sums[cell + 5] = sum_of(FIXED_POINT_UNITS as u64 * 10, 10);
    grid.update(&sums, 0, CELLS as u32);
    let radiance = grid.radiance();
    let floor = f64::from(LIMIT) / 256.0 / 64.0;
    assert!(close(radiance[cell + 5], f64::from(LIMIT)));
    assert!((cell..2 * cell).filter(|&bin| bin != cell + 5).all(|bin| close(radiance[bin], floor)));
    assert!(radiance[2 * cell..].iter().all(|&l| l < 1.0e-9));
}
