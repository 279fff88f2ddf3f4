//! What the tests of the rejection sampler share: tables, normals, the kernels, and the mass that the twin expects.

use std::sync::{Arc, OnceLock};

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3, dvec2};
use lodestar::cosine_integrals::cosine_integrals;
use lodestar::gpu::{Buffer, Kernel};
use lodestar::kernels::{Variant, test};
use lodestar::reference::equal_area::{bin_center, bin_point, direction_bin};
use lodestar::reference::normalization_entry::{
    Limits, NormalizationEntry, normalization_factors, normalizer_and_bound,
};

use crate::device::{Cell, Device, GROUP};
use crate::statistics::{Numbers, chi_square, sphere};

pub const DIRECTIONS: u32 = 16;
pub const NORMALS: u32 = 16;
/// Histograms have four cells in every direction bin.
pub const HISTOGRAM: u32 = 32;
/// Densities are evaluated at this many points a side.
pub const FINE: u32 = 1024;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Drawn {
    pub wi: [f32; 3],
    pub pdf: f32,
    pub pdf_of_wi: f32,
    pub tries: u32,
    pub bin: u32,
    pub overrun: u32,
}

impl Drawn {
    pub fn direction(&self) -> DVec3 {
        Vec3::from(self.wi).as_dvec3().normalize()
    }
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Density {
    pub wi: [f32; 3],
    pub pdf: f32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct PushedNormal {
    normal: [f32; 3],
    normal_bin: u32,
    seed_or_resolution: u32,
}

/// Radiance of a cell, given a representative normal whose horizon may matter.
pub fn tables(nb: DVec3) -> Vec<(&'static str, Vec<f32>)> {
    let bins = DIRECTIONS * DIRECTIONS;
    let height = |bin: &u32| bin_center(*bin, DIRECTIONS).dot(nb).abs();
    let at_horizon = (0..bins).min_by(|a, b| height(a).total_cmp(&height(b))).expect("a bin");
    let axis = (nb + 0.5 * nb.any_orthonormal_vector()).normalize();
    let lobe = |bin: u32| if bin_center(bin, DIRECTIONS).dot(axis) > 0.93 { 50.0 } else { 0.1 };
    let hot = |at: u32, base: f32, peak: f32| (0..bins).map(|bin| if bin == at { peak } else { base }).collect();
    let mut numbers = Numbers::new(31);
    let noisy = (0..bins).map(|_| 10_f64.powf(numbers.between(-3.0, 3.0)) as f32).collect();
    vec![
        ("flat", vec![1.0; bins as usize]),
        ("peaked", (0..bins).map(lobe).collect()),
        ("hot bin at the horizon", hot(at_horizon, 0.1, 1000.0)),
        ("noisy", noisy),
        ("all floor", vec![1.0e-30; bins as usize]),
        ("huge", hot(direction_bin(axis, DIRECTIONS), 1.0e28, 1.0e30)),
    ]
}

/// A normal, the representative of its bin, and what the twin knows of the two, in cells of the histogram.
pub struct Setting {
    pub name: &'static str,
    pub n: DVec3,
    pub nb: DVec3,
    pub normal_bin: u32,
    cosines: Vec<f64>,
    visible: Vec<f64>,
    maxima: Vec<f64>,
}

/// Normals on centers of bins and between them.
pub fn settings() -> &'static [Setting] {
    static SETTINGS: OnceLock<Vec<Setting>> = OnceLock::new();
    SETTINGS.get_or_init(|| {
        vec![
            Setting::new("center of a bin", bin_center(89, NORMALS)),
            Setting::new("corner of a bin", bin_point(200, NORMALS, dvec2(0.002, 0.003))),
            Setting::new("up", DVec3::Z),
            Setting::new("down and aslant", DVec3::new(0.3, -0.2, -0.9)),
            Setting::new("sideways", DVec3::new(-1.0, 0.02, 0.01)),
        ]
    })
}

impl Setting {
    pub fn new(name: &'static str, n: DVec3) -> Self {
        // As the device gets it.
        let n = n.normalize().as_vec3().as_dvec3();
        let normal_bin = direction_bin(n, NORMALS);
        let nb = bin_center(normal_bin, NORMALS);
        static BOUNDS: OnceLock<Vec<f64>> = OnceLock::new();
        let bounds = BOUNDS.get_or_init(|| {
            cosine_integrals(DIRECTIONS, NORMALS).iter().map(|cosine| f64::from(cosine.maximum)).collect()
        });
        Self {
            name,
            n,
            nb,
            normal_bin,
            cosines: sphere().cosine_integrals(HISTOGRAM, nb),
            visible: sphere().visible(HISTOGRAM, n),
            maxima: bounds.iter().skip(normal_bin as usize).step_by((NORMALS * NORMALS) as usize).copied().collect(),
        }
    }

    /// Normalizer and bound of a table, the integrals made independently of the renderer's.
    pub fn normalizer_and_bound(&self, table: &[f32]) -> (f64, f64) {
        let mut integrals = vec![0.0; table.len()];
        self.cosines.iter().enumerate().for_each(|(cell, cosine)| integrals[bin_of_cell(cell)] += cosine);
        normalizer_and_bound(table, &integrals, &self.maxima)
    }

    pub fn entry(&self, table: &[f32], limits: Limits) -> NormalizationEntry {
        let (normalizer, bound) = self.normalizer_and_bound(table);
        normalization_factors(normalizer, bound, limits)
    }

    /// Probability of every cell of the histogram.
    fn masses(&self, table: &[f32], entry: &NormalizationEntry) -> Vec<f64> {
        let cells = self.cosines.iter().zip(&self.visible).enumerate();
        let mass = |(cell, (cosine, visible)): (usize, (&f64, &f64))| {
            entry.guide_scale * f64::from(table[bin_of_cell(cell)]) * cosine + entry.uniform_density * visible
        };
        cells.map(mass).collect()
    }

    /// Chi-square of samples against the density that `entry` stands for.
    pub fn fit(&self, drawn: &[Drawn], table: &[f32], entry: &NormalizationEntry) -> f64 {
        let mut counts = vec![0; (HISTOGRAM * HISTOGRAM) as usize];
        drawn.iter().for_each(|d| counts[direction_bin(d.direction(), HISTOGRAM) as usize] += 1);
        let expected: Vec<f64> = self.masses(table, entry).iter().map(|mass| mass * drawn.len() as f64).collect();
        chi_square(&counts, &expected)
    }
}

fn bin_of_cell(cell: usize) -> usize {
    let (side, ratio) = (HISTOGRAM as usize, (HISTOGRAM / DIRECTIONS) as usize);
    (cell / side / ratio) * DIRECTIONS as usize + cell % side / ratio
}

/// The sampler on the device, for one choice of constants.
pub struct Rejection {
    device: Device,
    pub cell: Cell,
    draw: Kernel,
    density: Kernel,
    drawn: Arc<Buffer>,
    densities: Arc<Buffer>,
    pub limits: Limits,
}

pub const MOST_SAMPLES: usize = 1 << 20;

impl Rejection {
    pub fn new(max_tries: u32, min_uniform_share: f32) -> Self {
        let device = Device::new();
        let variant = Variant { max_tries, min_uniform_share, ..Variant::default() };
        Self {
            cell: Cell::new(&device, &variant),
            draw: device.kernel(&test::REJECTION_MIX, &variant),
            density: device.kernel(&test::REJECTION_MIX_PDF, &variant),
            drawn: device.storage("drawn", MOST_SAMPLES * size_of::<Drawn>()),
            densities: device.storage("densities", (FINE * FINE) as usize * size_of::<Density>()),
            device,
            limits: Limits { max_tries, min_uniform_share: f64::from(min_uniform_share) },
        }
    }

    pub fn fill(&self, table: &[f32]) {
        self.cell.fill(&self.device, table);
    }

    pub fn draw(&self, setting: &Setting, seed: u32, count: usize) -> Vec<Drawn> {
        self.run(&self.draw, &self.drawn, setting, seed, count);
        self.drawn.read(0, count).expect("read")
    }

    /// The density somewhere in every bin of a fine map.
    pub fn densities(&self, setting: &Setting) -> Vec<Density> {
        let count = (FINE * FINE) as usize;
        self.run(&self.density, &self.densities, setting, FINE, count);
        self.densities.read(0, count).expect("read")
    }

    fn run(&self, kernel: &Kernel, out: &Arc<Buffer>, setting: &Setting, last: u32, count: usize) {
        let normal = setting.n.as_vec3().into();
        let push = PushedNormal { normal, normal_bin: setting.normal_bin, seed_or_resolution: last };
        let buffers = [out, &self.cell.radiance, &self.cell.entries];
        self.device.dispatch(kernel, &buffers, bytemuck::bytes_of(&push), count as u32 / GROUP);
    }
}
