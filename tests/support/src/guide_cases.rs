//! Cases for tests of the samplers that follow a guide: radiance tables, normals, kernels, and the probabilities that
//! the twin expects.

use std::sync::{Arc, OnceLock};

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3, dvec2};
use lodestar::encode::cosine_integrals::cosine_integrals;
use lodestar::generated::kernels::{Variant, test};
use lodestar::generated::layout::CosineIntegral;
use lodestar::gpu::{Buffer, Kernel, KernelSource};
use lodestar::math::direction_map::{bin_center, bin_point, representative_normal};
use lodestar::settings::{DirectionMap, Mix, Sampler};

use crate::device::{Cell, Device, GROUP};
use crate::statistics::{Numbers, chi_square, sphere};
use crate::twins::direction_map::{direction_bin, normal_bin};
use crate::twins::guide::Guide;
use crate::twins::normalization_entry::{
    NormalizationEntry, Rules, inversion_factors, normalizer_and_bound, product_factors, rejection_factors,
};

pub const DIRECTIONS: u32 = 16;
pub const NORMALS: u32 = 16;
/// Cells of a histogram along each side: four per direction bin.
const HISTOGRAM: u32 = 32;
/// Points along each side at which densities are evaluated.
const FINE: u32 = 1024;
/// Maximum number of samples that are drawn at once.
pub const MOST_SAMPLES: usize = 1 << 20;

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
pub struct PushedNormal {
    pub normal: [f32; 3],
    pub seed_or_resolution: u32,
}

/// Sampler with its constants.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    pub rules: Rules,
    pub map: DirectionMap,
}

impl Kind {
    pub const fn new(sampler: Sampler, max_tries: u32, min_uniform_share: f64) -> Self {
        let rules = Rules { sampler, mix: Mix::Density, epsilon: None, max_tries, min_uniform_share };
        Self { rules, map: DirectionMap::EqualArea }
    }

    pub const fn on_cylinder(self) -> Self {
        Self { map: DirectionMap::Cylindrical, ..self }
    }

    pub const fn mixing_acceptances(self) -> Self {
        Self { rules: Rules { mix: Mix::Acceptance, ..self.rules }, ..self }
    }

    pub const fn with_epsilon(self, epsilon: f64) -> Self {
        Self { rules: Rules { epsilon: Some(epsilon), ..self.rules }, ..self }
    }

    /// Constants of the kernels.
    pub fn variant(&self) -> Variant {
        variant(&self.rules, self.map)
    }

    /// Whether the sampler chooses a bin first, and then any direction in it, even one below the surface.
    pub fn chooses_bins(&self) -> bool {
        matches!(self.rules.sampler, Sampler::SphereInversion | Sampler::HemisphereInversion | Sampler::Product)
    }
}

/// Constants of the kernels for a sampler and a map.
pub fn variant(rules: &Rules, map: DirectionMap) -> Variant {
    Variant {
        sampler: rules.sampler as u32,
        mix: rules.mix as u32,
        epsilon: rules.epsilon.unwrap_or(0.0) as f32,
        max_tries: rules.max_tries,
        min_uniform_share: rules.min_uniform_share as f32,
        map: map as u32,
        ..Variant::default()
    }
}

/// Named radiance tables of a cell. Some put light next to the horizon of the representative normal `nb`.
pub fn tables(map: DirectionMap, nb: DVec3) -> Vec<(&'static str, Vec<f32>)> {
    let bins = DIRECTIONS * DIRECTIONS;
    let center = |bin: u32| bin_center(map, bin, DIRECTIONS);
    let height = |bin: &u32| center(*bin).dot(nb).abs();
    let at_horizon = (0..bins).min_by(|a, b| height(a).total_cmp(&height(b))).expect("a bin");
    let axis = (nb + 0.5 * nb.any_orthonormal_vector()).normalize();
    let lobe = |bin: u32| if center(bin).dot(axis) > 0.93 { 50.0 } else { 0.1 };
    let hot = |at: u32, base: f32, peak: f32| (0..bins).map(|bin| if bin == at { peak } else { base }).collect();
    let mut numbers = Numbers::new(31);
    let noisy = (0..bins).map(|_| 10_f64.powf(numbers.between(-3.0, 3.0)) as f32).collect();
    vec![
        ("flat", vec![1.0; bins as usize]),
        ("peaked", (0..bins).map(lobe).collect()),
        ("hot bin at the horizon", hot(at_horizon, 0.1, 1000.0)),
        ("noisy", noisy),
        ("all floor", vec![1.0e-30; bins as usize]),
        ("huge", hot(direction_bin(map, axis, DIRECTIONS), 1.0e28, 1.0e30)),
        ("all zero", vec![0.0; bins as usize]),
    ]
}

/// Normal, the representative normal of its bin, and integrals that the twin needs, per cell of the histogram.
pub struct Setting {
    pub name: &'static str,
    pub n: DVec3,
    pub nb: DVec3,
    pub normal_bin: u32,
    map: DirectionMap,
    cosines: Vec<f64>,
    visible: Vec<f64>,
    visible_to_guide: Vec<f64>,
    visible_cosines: Vec<f64>,
    integrals: Vec<f64>,
    /// The renderer's integrals. Their last digits decide how they are rounded to few bits.
    stored_integrals: Vec<f64>,
    maxima: Vec<f64>,
}

/// Settings with normals on centers of bins and between them.
pub fn settings(map: DirectionMap) -> &'static [Setting] {
    static SETTINGS: [OnceLock<Vec<Setting>>; 2] = [OnceLock::new(), OnceLock::new()];
    SETTINGS[map as usize].get_or_init(|| {
        let corner = bin_point(DirectionMap::EqualArea, 200, NORMALS, dvec2(0.002, 0.003));
        vec![
            Setting::new(map, "center of a bin", representative_normal(89, NORMALS)),
            Setting::new(map, "corner of a bin", corner),
            Setting::new(map, "up", DVec3::Z),
            Setting::new(map, "down and aslant", DVec3::new(0.3, -0.2, -0.9)),
            Setting::new(map, "sideways", DVec3::new(-1.0, 0.02, 0.01)),
        ]
    })
}

/// The renderer's integrals and upper bounds of the cosine, `[direction bin][normal bin]`.
fn stored(map: DirectionMap) -> &'static [CosineIntegral] {
    static STORED: [OnceLock<Vec<CosineIntegral>>; 2] = [OnceLock::new(), OnceLock::new()];
    STORED[map as usize].get_or_init(|| cosine_integrals(map, DIRECTIONS, NORMALS))
}

impl Setting {
    pub fn new(map: DirectionMap, name: &'static str, n: DVec3) -> Self {
        // The device gets the normal in single precision.
        let n = n.normalize().as_vec3().as_dvec3();
        let normal_bin = normal_bin(n, NORMALS);
        let nb = representative_normal(normal_bin, NORMALS);
        let normals = (NORMALS * NORMALS) as usize;
        let cosines = sphere(map).cosine_integrals(HISTOGRAM, nb);
        let mut integrals = vec![0.0; (DIRECTIONS * DIRECTIONS) as usize];
        cosines.iter().enumerate().for_each(|(cell, cosine)| integrals[bin_of_cell(cell)] += cosine);
        let of_normal = || stored(map).iter().skip(normal_bin as usize).step_by(normals);
        Self {
            name,
            n,
            nb,
            normal_bin,
            map,
            cosines,
            visible_cosines: sphere(map).cosine_integrals(HISTOGRAM, n),
            visible: sphere(map).visible(HISTOGRAM, n),
            visible_to_guide: sphere(map).visible(HISTOGRAM, nb),
            integrals,
            stored_integrals: of_normal().map(|cosine| f64::from(cosine.integral)).collect(),
            maxima: of_normal().map(|cosine| f64::from(cosine.maximum)).collect(),
        }
    }

    /// Normalizer and bound of a table, from integrals made independently of the renderer's.
    pub fn normalizer_and_bound(&self, table: &[f32]) -> (f64, f64) {
        normalizer_and_bound(table, &self.integrals, &self.maxima)
    }

    /// Factors of the sampler for a normalizer that is `off` times the right one.
    pub fn entry_off(&self, table: &[f32], rules: &Rules, off: f64) -> NormalizationEntry {
        let (normalizer, bound) = self.normalizer_and_bound(table);
        let total: f64 = table.iter().map(|&l| f64::from(l)).sum();
        match rules.sampler {
            Sampler::SphereInversion => inversion_factors(off * total, table.len(), rules),
            Sampler::HemisphereInversion => inversion_factors(off * normalizer, table.len(), rules),
            Sampler::Product => product_factors(rules),
            _ => rejection_factors(off * normalizer, bound, rules),
        }
    }

    pub fn entry(&self, table: &[f32], rules: &Rules) -> NormalizationEntry {
        self.entry_off(table, rules, 1.0)
    }

    /// Twin of the sampler, with these factors.
    pub fn guide<'a>(&'a self, table: &'a [f32], rules: &'a Rules, entry: NormalizationEntry) -> Guide<'a> {
        let (nb, n) = (self.nb, self.n);
        let is_product = rules.sampler == Sampler::Product;
        let integrals = if is_product { &self.stored_integrals } else { &self.integrals };
        Guide { rules, map: self.map, radiance: table, integrals, nb, n, entry }
    }

    /// Probability of every cell of the histogram.
    fn masses(&self, guide: &Guide) -> Vec<f64> {
        let solid_angle = 4.0 * std::f64::consts::PI / f64::from(HISTOGRAM * HISTOGRAM);
        let densities: Vec<_> = (0..self.integrals.len()).map(|bin| guide.bin_density(bin)).collect();
        let mass = |cell: usize| {
            let density = densities[bin_of_cell(cell)];
            density.times_cosine * self.cosines[cell]
                + density.constant * solid_angle
                + density.above * self.visible_to_guide[cell]
                + guide.entry.uniform_density * self.visible[cell]
                + guide.cosine_share() * self.visible_cosines[cell] / std::f64::consts::PI
        };
        (0..self.cosines.len()).map(mass).collect()
    }

    /// Number of samples in every cell of the histogram, and the number that the twin's density expects.
    pub fn histogram(&self, drawn: &[Drawn], guide: &Guide) -> (Vec<u64>, Vec<f64>) {
        let mut counts = vec![0; (HISTOGRAM * HISTOGRAM) as usize];
        drawn.iter().for_each(|d| counts[direction_bin(self.map, d.direction(), HISTOGRAM) as usize] += 1);
        (counts, self.masses(guide).iter().map(|mass| mass * drawn.len() as f64).collect())
    }

    /// P-value of a chi-square test of samples against the twin's density.
    pub fn fit(&self, drawn: &[Drawn], guide: &Guide) -> f64 {
        let (counts, expected) = self.histogram(drawn, guide);
        chi_square(&counts, &expected)
    }
}

fn bin_of_cell(cell: usize) -> usize {
    let (side, ratio) = (HISTOGRAM as usize, (HISTOGRAM / DIRECTIONS) as usize);
    (cell / side / ratio) * DIRECTIONS as usize + cell % side / ratio
}

/// Kernels that a guide is tested with.
pub struct GuideKernels {
    pub normalize: KernelSource,
    pub draw: KernelSource,
    pub density: KernelSource,
    /// Invocations per workgroup of these kernels.
    pub group: u32,
}

impl GuideKernels {
    pub fn built_in() -> Self {
        Self {
            normalize: test::NORMALIZE_CELL.clone(),
            draw: test::GUIDED_DIRECTION.clone(),
            density: test::GUIDED_DENSITY.clone(),
            group: GROUP,
        }
    }
}

/// Sampler on the device.
pub struct Guided {
    device: Device,
    group: u32,
    pub cell: Cell,
    draw: Kernel,
    density: Kernel,
    drawn: Arc<Buffer>,
    densities: Arc<Buffer>,
}

impl Guided {
    pub fn new(kind: Kind) -> Self {
        Self::with(kind, &GuideKernels::built_in())
    }

    pub fn with(kind: Kind, kernels: &GuideKernels) -> Self {
        let device = Device::new();
        let sphere = kind.rules.sampler == Sampler::SphereInversion;
        let normal_resolution = if sphere { 1 } else { NORMALS };
        let workgroup_size = kernels.group;
        let variant = Variant { normal_resolution, workgroup_size, ..kind.variant() };
        Self {
            group: kernels.group,
            cell: Cell::normalized_by(&device, &variant, &kernels.normalize),
            draw: device.kernel(&kernels.draw, &variant),
            density: device.kernel(&kernels.density, &variant),
            drawn: device.storage("drawn", MOST_SAMPLES * size_of::<Drawn>()),
            densities: device.storage("densities", (FINE * FINE) as usize * size_of::<Density>()),
            device,
        }
    }

    pub fn fill(&self, table: &[f32]) {
        self.cell.fill(&self.device, table);
    }

    pub fn draw(&self, setting: &Setting, seed: u32, count: usize) -> Vec<Drawn> {
        self.run(&self.draw, ("DrawnSamples", &self.drawn), setting, seed, count);
        self.drawn.read(0, count).expect("read")
    }

    /// Density at a point in every bin of a fine map.
    pub fn densities(&self, setting: &Setting) -> Vec<Density> {
        let count = (FINE * FINE) as usize;
        self.run(&self.density, ("Densities", &self.densities), setting, FINE, count);
        self.densities.read(0, count).expect("read")
    }

    fn run(&self, kernel: &Kernel, out: (&str, &Arc<Buffer>), setting: &Setting, last: u32, count: usize) {
        let push = PushedNormal { normal: setting.n.as_vec3().into(), seed_or_resolution: last };
        let groups = count as u32 / self.group;
        self.device.dispatch_named(kernel, &self.cell.named(out), bytemuck::bytes_of(&push), groups);
    }
}
