//! Quadtrees on the device: samples (`glsl/include/guide/samplers/quadtree.glsl`) have the density of the twin, and
//! refined trees (`glsl/kernels/learn/refine_quadtrees.comp`) equal the twin's.

use std::f64::consts::PI;
use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{DVec2, DVec3, Vec3, dvec2};
use lodestar::generated::kernels::{
    REFINE_DRAFT, REFINE_MEASURE, REFINE_PLACE, REFINE_SETTLE, SAMPLER_QUADTREE, STORAGE_BUFFERS, Variant, test,
};
use lodestar::generated::layout::{RadianceSum, RefinePush, SceneConstants};
use lodestar::gpu::{Buffer, BufferKind, KernelSource};
use lodestar::settings::DirectionMap;
use support::device::{Device, GROUP};
use support::guide_cases::{Density, Drawn, PushedNormal};
use support::statistics::{Numbers, chi_square, mean_and_error, sidak, within_four_sigma};
use support::tier;
use support::twins::cosine::SphereGrid;
use support::twins::direction_map::{direction_bin, sphere_to_map};
use support::twins::quadtree::{COSINE_SHARE, Square};
use support::twins::radiance_grid::FIXED_POINT_UNITS;

/// Probability that any of the chi-square tests fails by chance.
const SIGNIFICANCE: f64 = 0.01;
const SAMPLES: usize = 1 << 19;
/// Cells of a histogram along each side.
const HISTOGRAM: u32 = 64;
/// Points along each side at which densities are evaluated: several in each of the finest squares here.
const FINE: u32 = 1024;
const MAPS: [DirectionMap; 2] = [DirectionMap::EqualArea, DirectionMap::Cylindrical];

/// Tree that follows a function of the unit square. Its shares are rounded as they are stored.
fn tree(value: &dyn Fn(DVec2) -> f64, levels: u32) -> Square {
    fn square(value: &dyn Fn(DVec2) -> f64, corner: DVec2, side: f64, levels: u32) -> Square {
        let quarter = |i: usize| corner + 0.5 * side * dvec2((i % 2) as f64, (i / 2) as f64);
        match levels {
            0 => Square::leaf(side * side * value(corner + 0.5 * side)),
            _ => Square::of(std::array::from_fn(|i| square(value, quarter(i), 0.5 * side, levels - 1))),
        }
    }
    let tree = square(value, DVec2::ZERO, 1.0, levels).refined();
    Square::of_words(&tree.words(), tree.flux)
}

fn trees() -> Vec<(&'static str, Square)> {
    let lobe = |at: DVec2| (-200.0 * (at - dvec2(0.62, 0.41)).length_squared()).exp() + 0.01;
    let spot = |at: DVec2| if (at - dvec2(0.3, 0.7)).length() < 0.02 { 1.0 } else { 1.0e-4 };
    let mut numbers = Numbers::new(8);
    let noise: Vec<f64> = (0..64).map(|_| 10_f64.powf(numbers.between(-2.0, 2.0))).collect();
    let noisy = move |at: DVec2| noise[(at.y * 8.0) as usize * 8 + (at.x * 8.0) as usize];
    vec![
        ("even", tree(&|_| 1.0, 1)),
        ("half", tree(&|at| f64::from(u8::from(at.x < 0.5)), 1)),
        ("lobe", tree(&lobe, 7)),
        ("spot", tree(&spot, 8)),
        ("noisy", tree(&noisy, 3)),
    ]
}

fn normals() -> [DVec3; 3] {
    [DVec3::Z, dvec3(0.3, -0.2, 0.9), dvec3(-0.6, 0.1, -0.7)]
}

/// Unit vector in the precision of the device.
fn dvec3(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z).normalize().as_vec3().as_dvec3()
}

/// Quadtree sampler on the device.
struct Descent {
    device: Device,
    variant: Variant,
    nodes: Arc<Buffer>,
    unused: Arc<Buffer>,
}

impl Descent {
    fn new(map: DirectionMap) -> Self {
        let device = Device::new();
        let variant = Variant { sampler: SAMPLER_QUADTREE, map: map as u32, ..Variant::default() };
        Self { nodes: device.storage("nodes", 1 << 20), unused: device.storage("unused", 256), device, variant }
    }

    fn fill(&self, tree: &Square) {
        self.nodes.upload(0, &tree.words()).expect("uploaded");
    }

    fn run<T: bytemuck::Pod>(&self, source: &KernelSource, n: DVec3, last: u32, count: usize) -> Vec<T> {
        let push = PushedNormal { normal: n.as_vec3().into(), seed_or_resolution: last };
        let out = self.device.storage("out", count * size_of::<T>());
        let kernel = self.device.kernel(source, &self.variant);
        let bindings = source.sets.iter().flat_map(|set| set.bindings);
        let scene = self.device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        let buffer = |name: &str| match name {
            "RadianceNodes" => &self.nodes,
            "DrawnSamples" | "Densities" => &out,
            "Scene" => &scene,
            _ => &self.unused,
        };
        let buffers: Vec<_> = bindings.map(|binding| buffer(binding.name)).collect();
        self.device.dispatch(&kernel, &buffers, bytemuck::bytes_of(&push), count as u32 / GROUP);
        out.read(0, count).expect("read")
    }
}

/// P-value of a histogram of the samples against the twin's density.
fn fit(tree: &Square, map: DirectionMap, cosines: &[f64], drawn: &[Drawn]) -> f64 {
    let mut masses = vec![0.0; (HISTOGRAM * HISTOGRAM) as usize];
    let side = f64::from(HISTOGRAM);
    for (corner, leaf_side, probability) in tree.leaves() {
        let cells = (leaf_side * side).max(1.0) as usize;
        let [x, y] = [corner.x, corner.y].map(|at| (at * side) as usize);
        for cell in 0..cells * cells {
            let at = (y + cell / cells) * HISTOGRAM as usize + x + cell % cells;
            masses[at] += (1.0 - COSINE_SHARE) * probability / (cells * cells) as f64;
        }
    }
    masses.iter_mut().zip(cosines).for_each(|(mass, cosine)| *mass += COSINE_SHARE * cosine / PI);
    let mut counts = vec![0; masses.len()];
    drawn.iter().for_each(|d| counts[direction_bin(map, d.direction(), HISTOGRAM) as usize] += 1);
    let expected: Vec<_> = masses.iter().map(|mass| mass * drawn.len() as f64).collect();
    chi_square(&counts, &expected)
}

/// Whether a direction is so near a border between squares that rounding may decide the square.
fn is_at_border(tree: &Square, map: DirectionMap, w: DVec3) -> bool {
    let at = 0.5 * sphere_to_map(map, w) + 0.5;
    let near = 2.0e-6;
    let moved = |x: f64, y: f64| tree.density(at + near * dvec2(x, y)) != tree.density(at);
    // Beyond the map's own border, the sphere continues elsewhere on the map.
    at.min_element() < near
        || at.max_element() > 1.0 - near
        || [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].iter().any(|&(x, y)| moved(x, y))
}

/// Samples follow their density. The quick tier has one normal.
#[test]
fn samples_follow_their_density() {
    let trees = trees();
    let level = sidak(SIGNIFICANCE, MAPS.len() * trees.len() * normals().len());
    for map in MAPS {
        let descent = Descent::new(map);
        let sphere = SphereGrid::new(map, 17 * HISTOGRAM);
        for (place, (name, tree)) in trees.iter().enumerate() {
            descent.fill(tree);
            for (seed, &n) in (0..).zip(tier::some_of(&normals(), 1)) {
                let title = format!("{map:?}, {name}, {} nodes, normal {seed}", tree.node_count());
                let drawn: Vec<Drawn> = descent.run(&test::GUIDED_DIRECTION, n, seed, SAMPLES);
                let cosines = sphere.cosine_integrals(HISTOGRAM, n);
                let p = fit(tree, map, &cosines, &drawn);
                println!("{title}: {p}");
                assert!(p > level, "{title}: chi-square {p}");
                let other = fit(&trees[(place + 1) % trees.len()].1, map, &cosines, &drawn);
                assert!(other < 1.0e-9, "{title}: the twin, another tree: {other}");
                check_samples(tree, map, n, &drawn, &title);
                check_densities(
                    tree,
                    map,
                    n,
                    &descent.run(&test::GUIDED_DENSITY, n, FINE, (FINE * FINE) as usize),
                    &title,
                );
            }
        }
    }
}

/// Fails unless each sample has the density of its direction, and the samples estimate the projected solid angle.
fn check_samples(tree: &Square, map: DirectionMap, n: DVec3, drawn: &[Drawn], title: &str) {
    for d in drawn.iter().step_by(16).filter(|d| !is_at_border(tree, map, d.direction())) {
        let twin = tree.pdf(map, n, d.direction());
        assert!((f64::from(d.pdf) - twin).abs() < 1.0e-4 * twin + 3.0e-7, "{title}: {d:?}, not {twin}");
        assert!((d.pdf_of_wi - d.pdf).abs() < 1.0e-4 * d.pdf + 3.0e-7, "{title}: {d:?}");
    }
    let weight = |d: &Drawn| d.direction().dot(n).max(0.0) / f64::from(d.pdf);
    let projected = mean_and_error(drawn.iter().map(weight));
    assert!(within_four_sigma(projected, PI), "{title}: {projected:?}");
}

fn check_densities(tree: &Square, map: DirectionMap, n: DVec3, densities: &[Density], title: &str) {
    let mean = densities.iter().map(|d| f64::from(d.pdf)).sum::<f64>() / densities.len() as f64;
    assert!((4.0 * PI * mean - 1.0).abs() < 1.0e-4, "{title}: the integral is {}", 4.0 * PI * mean);
    for d in densities.iter().step_by(61) {
        let w = Vec3::from(d.wi).as_dvec3();
        if !is_at_border(tree, map, w) {
            let twin = tree.pdf(map, n, w);
            assert!((f64::from(d.pdf) - twin).abs() < 1.0e-4 * twin + 3.0e-7, "{title}: {}, not {twin} at {w}", d.pdf);
        }
    }
}

const LIMIT: f32 = 32.0;

/// Quadtrees on the device, with up to `grid^3 * directions^2` nodes.
struct Forest {
    device: Device,
    variant: Variant,
    nodes: Arc<Buffer>,
    sums: Arc<Buffer>,
    scene: Arc<Buffer>,
    limit: usize,
}

/// Leaf of the spatial tree: its level, and the nodes of its quadtree.
struct Leaf {
    level: u32,
    first: usize,
    words: Vec<[u32; 4]>,
}

impl Forest {
    fn new(grid_resolution: u32, direction_resolution: u32) -> Self {
        let device = Device::new();
        let sampler = SAMPLER_QUADTREE;
        let limit = (grid_resolution.pow(3) * direction_resolution.pow(2)) as usize;
        let scene = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        scene.upload(0, &[SceneConstants { target_limit: LIMIT, ..SceneConstants::zeroed() }]).expect("uploaded");
        Self {
            nodes: device.storage("nodes", 4 * limit * 16),
            sums: device.storage("sums", 4 * limit * size_of::<RadianceSum>()),
            variant: Variant { sampler, quadtree_nodes: limit as u32, direction_resolution, ..Variant::default() },
            device,
            scene,
            limit,
        }
    }

    fn leaf_limit(&self) -> usize {
        self.limit / 8
    }

    fn refine(&self, iteration: u32) {
        let named = [("RadianceNodes", &self.nodes), ("RadianceSums", &self.sums), ("Scene", &self.scene)];
        let groups = (self.leaf_limit() as u32).div_ceil(GROUP);
        for (stage, groups) in [(REFINE_MEASURE, groups), (REFINE_PLACE, 1), (REFINE_DRAFT, groups), (REFINE_SETTLE, 7)]
        {
            let push = RefinePush { stage, iteration };
            let kernel = &STORAGE_BUFFERS.refine_quadtrees;
            self.device.dispatch_renderers(kernel, &self.variant, &named, bytemuck::bytes_of(&push), groups);
        }
    }

    /// Lets every quarter without a node of its own learn `count` targets.
    fn teach(&self, count: u32) {
        let mut sums = vec![RadianceSum::zeroed(); 4 * self.limit];
        for leaf in self.leaves() {
            for (node, words) in leaf.words.iter().enumerate() {
                for quarter in (0..4).filter(|quarter| words[3] >> quarter & 1 == 0) {
                    let units = (learned(node, quarter) / f64::from(LIMIT) * FIXED_POINT_UNITS) as u64;
                    let (low, high) = (units as u32, (units >> 32) as u32);
                    let sum = RadianceSum { low, high, target_count: count, flux: 0.0 };
                    sums[4 * (leaf.first + node) + quarter] = sum;
                }
            }
        }
        self.sums.upload(0, &sums).expect("uploaded");
    }

    fn leaves(&self) -> Vec<Leaf> {
        let spatial = (2 * self.leaf_limit()).div_ceil(4);
        let words: Vec<[u32; 4]> = self.nodes.read(0, self.limit + self.leaf_limit() + spatial + 1).expect("read");
        let count = words.last().expect("a count")[0] as usize + 1;
        let of = |[_, level, first, last]: [u32; 4]| {
            let first = first as usize;
            Leaf { level, first, words: words[first..=first + last as usize].to_vec() }
        };
        words[self.limit..self.limit + count].iter().map(|&words| of(words)).collect()
    }
}

/// Radiance that a quarter of a node learns, if the quarter has no node of its own.
fn learned(at: usize, quarter: usize) -> f64 {
    let hash = (at * 4 + quarter).wrapping_mul(2_654_435_761) >> 7 & 1023;
    (hash as f64 / 128.0).exp2() / 64.0
}

/// Tree with the fluxes that it has learned in place of its old ones.
fn taught(words: &[[u32; 4]], node: usize) -> Square {
    let links = words[node][3];
    Square::of(std::array::from_fn(|quarter| {
        let below = (links >> 9) + (links & ((1 << quarter) - 1)).count_ones();
        match links >> quarter & 1 {
            0 => Square::leaf(learned(node, quarter)),
            _ => taught(words, below as usize),
        }
    }))
}

/// Trees are refined as their twins are, in four iterations. In one of them, the spatial tree grows.
#[test]
fn trees_are_refined_as_their_twins_are() {
    let forest = Forest::new(8, 16);
    for (iteration, count) in [(0, 10), (1, 500), (2, 1), (3, 0)] {
        let before = forest.leaves();
        forest.teach(count);
        let twins: Vec<_> = before.iter().map(|leaf| taught(&leaf.words, 0).refined()).collect();
        forest.refine(iteration);
        let after = forest.leaves();
        let copies = after.len() / before.len();
        println!("iteration {iteration}: {} leaves, {} nodes", after.len(), twins[0].node_count());
        assert_eq!(copies > 1, count == 500, "{} leaves became {}", before.len(), after.len());
        for (at, leaf) in after.iter().enumerate() {
            let twin = &twins[at / copies];
            assert_eq!(leaf.level, before[at / copies].level + copies.ilog2());
            assert_eq!(leaf.words.len(), twin.node_count(), "leaf {at}");
            let found = Square::of_words(&leaf.words, twin.flux);
            assert!(twin.is_near(&found, 1.0e-5), "leaf {at} is not its twin");
            let old = Square::of_words(&before[at / copies].words, twin.flux);
            assert!(!twin.is_near(&old, 1.0e-3), "the twin: leaf {at} is what it was");
        }
        let sums: Vec<RadianceSum> = forest.sums.read(0, 4 * forest.limit).expect("read");
        assert!(sums.iter().all(|sum| (sum.low, sum.high, sum.target_count) == (0, 0, 0)), "sums do not start anew");
    }
}

/// Trees never overlap, and nodes and leaves never exceed their room, whatever is learned.
#[test]
fn there_are_no_more_nodes_than_there_is_room_for() {
    for (grid, directions) in [(1, 4), (2, 8), (3, 16)] {
        let forest = Forest::new(grid, directions);
        for iteration in 0..6 {
            forest.teach(1 << 20);
            forest.refine(iteration);
            let leaves = forest.leaves();
            let mut ranges: Vec<_> = leaves.iter().map(|leaf| leaf.first..leaf.first + leaf.words.len()).collect();
            ranges.sort_by_key(|range| range.start);
            assert!(ranges.windows(2).all(|pair| pair[0].end <= pair[1].start), "trees overlap");
            let nodes: usize = ranges.iter().map(ExactSizeIterator::len).sum();
            println!("room for {}: {} leaves, {nodes} nodes", forest.limit, leaves.len());
            assert!(nodes <= forest.limit && leaves.len() <= forest.leaf_limit());
            assert!(leaves.iter().all(|leaf| leaf.words[0][3] != 0), "a tree has learned nothing");
        }
    }
}

/// Trees without light stay unused, however many paths have passed.
#[test]
fn without_flux_there_is_no_guide() {
    let forest = Forest::new(2, 16);
    let dark = RadianceSum { target_count: 100_000, ..RadianceSum::zeroed() };
    for iteration in 0..2 {
        forest.sums.upload(0, &[dark]).expect("uploaded");
        forest.refine(iteration);
    }
    let leaves = forest.leaves();
    assert!(leaves.len() > 1 && leaves.iter().all(|leaf| leaf.words == [[0; 4]]));
}
