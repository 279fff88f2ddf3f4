//! Claim: a step's update (`glsl/kernels/learn/update_radiance.comp`) is Eq. 7, the running mean of all targets with
//! geometric decay of old ones. No bin loses its support.

use std::sync::Arc;

use bytemuck::Zeroable;
use lodestar::generated::kernels::{STORAGE_BUFFERS, Variant};
use lodestar::generated::layout::{LearnedRadiance, RadianceSum, SceneConstants, UpdatePush};
use lodestar::gpu::{Buffer, BufferKind, KernelSource};
use support::device::Device;
use support::statistics::Numbers;
use support::twins::radiance_grid as twin;
use support::twins::radiance_grid::FIXED_POINT_UNITS;

use crate::evidence::Evidence;
use crate::rows::Scope;
use crate::subject::Subject;

const LIMIT: f32 = 32.0;
const CELLS: usize = 4;
const STEPS: usize = 6;
/// Decay of old targets, and bins along each side.
const CASES: [(f32, u32); 4] = [(1.0, 16), (0.5, 16), (0.75, 8), (0.9, 32)];

pub fn test(subject: &Subject, _: Scope, evidence: &mut Evidence) {
    for (decay, directions) in CASES {
        check_steps(subject, decay, directions, evidence);
    }
    check_silence(subject, evidence);
}

/// Grids of a few cells on the device.
struct Grid {
    device: Device,
    kernel: KernelSource,
    variant: Variant,
    radiance: Arc<Buffer>,
    learned: Arc<Buffer>,
    sums: Arc<Buffer>,
    scene: Arc<Buffer>,
    bins: usize,
}

impl Grid {
    fn new(subject: &Subject, variant: Variant) -> Self {
        let device = Device::new();
        let bins = CELLS * variant.direction_resolution.pow(2) as usize;
        let scene = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        scene.upload(0, &[SceneConstants { target_limit: LIMIT, ..SceneConstants::zeroed() }]).expect("uploaded");
        Self {
            radiance: device.storage("radiance", bins * size_of::<f32>()),
            learned: device.storage("learned", bins * size_of::<LearnedRadiance>()),
            sums: device.storage("sums", bins * size_of::<RadianceSum>()),
            kernel: subject.kernel(&STORAGE_BUFFERS.update_radiance),
            device,
            variant,
            scene,
            bins,
        }
    }

    /// Ends a step that recorded `sums`, in `cells` cells from `first` on.
    fn update(&self, sums: &[RadianceSum], first: u32, cells: u32) {
        self.sums.upload(0, sums).expect("uploaded");
        let named = [
            ("RadianceTable", &self.radiance),
            ("LearnedTable", &self.learned),
            ("RadianceSums", &self.sums),
            ("Scene", &self.scene),
        ];
        for (name, _) in named {
            let mut bindings = self.kernel.sets.iter().flat_map(|set| set.bindings);
            assert!(bindings.any(|binding| binding.name == name), "no binding {name}: {:?}", self.kernel.sets);
        }
        let push = UpdatePush { first_cell: first, ends_step: 1 };
        self.device.dispatch_renderers(&self.kernel, &self.variant, &named, bytemuck::bytes_of(&push), cells);
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
    RadianceSum { low: units as u32, high: (units >> 32) as u32, target_count, flux: 0.0 }
}

fn value(sum: &RadianceSum) -> f64 {
    (f64::from(sum.high) * 4_294_967_296.0 + f64::from(sum.low)) * f64::from(LIMIT) / FIXED_POINT_UNITS
}

/// Sums of one step: most bins have a few targets, some have none, one cell has none at all, and one bin has millions.
fn step(numbers: &mut Numbers, bins: usize) -> Vec<RadianceSum> {
    let silent = bins / CELLS;
    let bin = |index: usize| {
        let count = if index == silent { 3_000_000 } else { (numbers.unit() * 6.0) as u32 };
        let mean = 10_f64.powf(numbers.between(-6.0, 0.0)) * FIXED_POINT_UNITS;
        let count = if index < silent { 0 } else { count };
        sum_of((mean * f64::from(count)) as u64, count)
    };
    (0..bins).map(bin).collect()
}

fn close(a: f32, b: f64) -> bool {
    (f64::from(a) - b).abs() <= 1.0e-5 * b.abs()
}

/// Whether a bin equals the closed form of Eq. 7 over all steps: the sum of decay^age times target sums, over the sum
/// of decay^age times counts.
fn is_faded_mean(learned: &LearnedRadiance, steps: &[Vec<RadianceSum>], bin: usize, decay: f64) -> bool {
    let faded = |f: &dyn Fn(&RadianceSum) -> f64| -> f64 {
        steps.iter().rev().zip(0..).map(|(sums, age)| f(&sums[bin]) * decay.powi(age)).sum()
    };
    let (sum, count) = (faded(&value), faded(&|s| f64::from(s.target_count)));
    close(learned.mean, if count > 0.0 { sum / count } else { 0.0 }) && close(learned.weight, count)
}

fn check_steps(subject: &Subject, decay: f32, directions: u32, evidence: &mut Evidence) {
    let case = format!("decay {decay}, {directions} directions a side");
    let grid = Grid::new(subject, Variant { decay, direction_resolution: directions, ..Variant::default() });
    let mut numbers = Numbers::new(subject.seed + 21);
    let steps: Vec<_> = (0..STEPS).map(|_| step(&mut numbers, grid.bins)).collect();
    for sums in &steps {
        grid.update(sums, 0, CELLS as u32);
        let means: Vec<f64> = grid.learned().iter().map(|l| f64::from(l.mean)).collect();
        let floored = means.chunks(grid.bins / CELLS).flat_map(|cell| twin::floored(cell, f64::from(LIMIT)));
        let is_floored = grid.radiance().iter().zip(floored).all(|(&a, b)| close(a, b) && a > 0.0);
        evidence.hold(format!("floor, {case}"), is_floored, || "a bin is not its mean lifted off zero".into());
        let is_empty = grid.sums().iter().all(|s| *s == sum_of(0, 0));
        evidence.hold(format!("sums, {case}"), is_empty, || "they do not start anew".into());
    }
    let learned = grid.learned();
    let wrong = |decay: f64| (0..grid.bins).filter(|&bin| !is_faded_mean(&learned[bin], &steps, bin, decay)).count();
    evidence
        .hold(format!("means, {case}"), wrong(decay.into()) == 0, || format!("{} bins differ", wrong(decay.into())));
    // The twin must fail: a decay that is 1 % smaller.
    assert!(wrong(0.99 * f64::from(decay)) > grid.bins / 4, "{case}: hardly a bin depends on the decay");
}

fn check_silence(subject: &Subject, evidence: &mut Evidence) {
    let grid = Grid::new(subject, Variant::default());
    let cell = grid.bins / CELLS;
    grid.update(&vec![sum_of(0, 0); grid.bins], 1, 2);
    let radiance = grid.radiance();
    let is_even = radiance[cell..3 * cell].iter().all(|&l| l == radiance[cell] && l > 0.0 && l < 1.0e-9);
    evidence.hold("a cell without targets", is_even, || "it is not uniform".into());
    let is_untouched = radiance[..cell].iter().chain(&radiance[3 * cell..]).all(|&l| l == 0.0);
    evidence.hold("other cells", is_untouched, || "they are changed".into());
    // One bright bin lifts all others of its cell, and of no other cell, to a share of the cell's mean.
    let mut sums = vec![sum_of(0, 0); grid.bins];
    sums[cell + 5] = sum_of(FIXED_POINT_UNITS as u64 * 10, 10);
    grid.update(&sums, 0, CELLS as u32);
    let radiance = grid.radiance();
    let floor = f64::from(LIMIT) / 256.0 / 64.0;
    let is_lifted = close(radiance[cell + 5], f64::from(LIMIT))
        && (cell..2 * cell).filter(|&bin| bin != cell + 5).all(|bin| close(radiance[bin], floor))
        && radiance[2 * cell..].iter().all(|&l| l < 1.0e-9);
    evidence.hold("a single bright bin", is_lifted, || "it does not lift its own cell alone".into());
}
