//! Random numbers of `glsl/include/random/random.glsl`, `glsl/include/random/sobol.glsl` and
//! `glsl/include/random/blue_noise.glsl`.

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use lodestar::generated::kernels::{PATTERN_BLUE_NOISE, PATTERN_INDEPENDENT, PATTERN_SOBOL, Variant, test};
use support::device::Device;
use support::statistics::{pair_uniformity, sidak, uniformity};
use support::twins::random as twin;
use support::twins::random::{RandomKey, SampleSet};

/// Probability that any of the chi-square tests of one test function fails by chance.
const SIGNIFICANCE: f64 = 0.01;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct DrawInput {
    film_pixel: [u32; 2],
    film_width: u32,
    sample_index: u32,
    first_of_set: u32,
    seed: u32,
    vertex: u32,
    block: u32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct DrawOutput {
    bits: [u32; 4],
    floats: [f32; 4],
    leftover: f32,
    stream: [f32; 4],
    camera: [u32; 4],
}

impl DrawOutput {
    /// Four numbers of the camera's ray.
    fn camera_numbers(&self) -> [f64; 4] {
        self.camera.map(twin::unit_float)
    }

    /// All numbers of a key.
    fn numbers(&self) -> [f64; 9] {
        let [a, b, c, d] = self.floats;
        let [e, f, g, h] = self.stream;
        [a, b, c, d, self.leftover, e, f, g, h].map(f64::from)
    }
}

impl DrawInput {
    fn pixel(&self) -> u32 {
        self.film_pixel[1] * self.film_width + self.film_pixel[0]
    }
}

/// Width of the film that the box of keys lies on, in pixels.
const FILM_WIDTH: u32 = 8;

/// Extents of a box of keys: pixel, sample, seed, vertex, block.
const BOX: [u32; 5] = [64, 16, 4, 8, 2];

/// All keys of the box. The last of its coordinates changes fastest.
fn keys(first: [u32; 5]) -> Vec<DrawInput> {
    let count: u32 = BOX.iter().product();
    let key = |mut index: u32| {
        let mut key = [0; 5];
        for axis in (0..5).rev() {
            key[axis] = first[axis] + index % BOX[axis];
            index /= BOX[axis];
        }
        let [pixel, sample_index, seed, vertex, block] = key;
        let film_pixel = [pixel % FILM_WIDTH, pixel / FILM_WIDTH];
        let first_of_set = sample_index - sample_index % 8;
        DrawInput { film_pixel, film_width: FILM_WIDTH, sample_index, first_of_set, seed, vertex, block }
    };
    (0..count).map(key).collect()
}

/// All keys of the box, with every pixel in a tile of its own.
fn keys_of_tiles(first: [u32; 5]) -> Vec<DrawInput> {
    let apart = |i: DrawInput| DrawInput { film_pixel: i.film_pixel.map(|x| x << 5), film_width: FILM_WIDTH << 5, ..i };
    keys(first).into_iter().map(apart).collect()
}

const PATTERNS: [u32; 3] = [PATTERN_INDEPENDENT, PATTERN_SOBOL, PATTERN_BLUE_NOISE];
/// Patterns with sets of samples.
const SETS: [u32; 2] = [PATTERN_SOBOL, PATTERN_BLUE_NOISE];

fn draw(pattern: u32, inputs: &[DrawInput]) -> Vec<DrawOutput> {
    draw_by(&Variant { pattern, ..Variant::default() }, inputs)
}

fn draw_by(variant: &Variant, inputs: &[DrawInput]) -> Vec<DrawOutput> {
    Device::new().map(&test::RANDOM, variant, inputs)
}

fn of_twin(&Variant { pattern, adaptive, .. }: &Variant, i: &DrawInput) -> DrawOutput {
    let set = match pattern {
        PATTERN_INDEPENDENT => SampleSet::Alone,
        PATTERN_SOBOL => SampleSet::OfPixel(i.first_of_set),
        _ => SampleSet::OfTile(i.first_of_set, i.film_pixel),
    };
    let key = RandomKey { pixel: i.pixel(), sample_index: i.sample_index, set, seed: i.seed };
    let bits = twin::random_bits(key, i.vertex, i.block);
    let mut stream = twin::random_stream(key, i.vertex, i.block);
    DrawOutput {
        bits,
        floats: bits.map(|b| twin::unit_float(b) as f32),
        leftover: twin::leftover_float(bits) as f32,
        stream: [(); 4].map(|()| twin::next_random(&mut stream) as f32),
        camera: twin::camera_bits(key, adaptive),
    }
}

#[test]
fn every_bit_is_the_twins() {
    let mut inputs = keys([0; 5]);
    // More keys lie far out on every axis, where products wrap around.
    inputs.extend(keys([u32::MAX - 63, 1 << 20, 0xdead_beef, 1000, 1]));
    for (pattern, adaptive) in PATTERNS.into_iter().flat_map(|pattern| [(pattern, false), (pattern, true)]) {
        let variant = Variant { pattern, adaptive, ..Variant::default() };
        for (i, o) in inputs.iter().zip(draw_by(&variant, &inputs)) {
            assert_eq!(o, of_twin(&variant, i), "{i:?}");
            assert!(o.numbers().iter().all(|x| (0.0..1.0).contains(x)), "{o:?}");
        }
    }
}

#[test]
fn numbers_are_uniform() {
    let level = sidak(SIGNIFICANCE, 3 * 9);
    for (pattern, k) in PATTERNS.into_iter().flat_map(|pattern| (0..9).map(move |k| (pattern, k))) {
        let outputs = draw(pattern, &keys_of_tiles([0; 5]));
        let p = uniformity(outputs.iter().map(|o| o.numbers()[k]), 256);
        assert!(p > level, "pattern {pattern}, number {k}: {p}");
        let tampered = uniformity(outputs.iter().map(|o| o.numbers()[k].powf(1.05)), 256);
        assert!(tampered < level, "pattern {pattern}, number {k} of the twin: {tampered}");
    }
}

/// Pairs of number `a` of a key and number `b` of the next key along `axis`.
fn neighbors(numbers: &[[f64; 9]], axis: usize, a: usize, b: usize) -> Vec<(f64, f64)> {
    let stride: usize = BOX[axis + 1..].iter().map(|&extent| extent as usize).product();
    let has_next = |index: usize| index / stride % (BOX[axis] as usize) + 1 < BOX[axis] as usize;
    let indices = (0..numbers.len()).filter(|&index| has_next(index));
    indices.map(|index| (numbers[index][a], numbers[index + stride][b])).collect()
}

#[test]
fn neighboring_keys_are_independent() {
    let inputs = keys([100, 0, 0, 0, 0]);
    let numbers: Vec<_> = draw(PATTERN_INDEPENDENT, &inputs).iter().map(DrawOutput::numbers).collect();
    // The twin must fail: the cheapest hash that passes the test of uniformity. Its neighbors are not independent.
    let weak = inputs.iter().map(|i| {
        let mixed =
            i.pixel().wrapping_mul(0x9e37_79b9) ^ (i.sample_index + 16 * (i.vertex + 8 * i.seed) + 512 * i.block) << 22;
        [twin::unit_float(mixed); 9]
    });
    let weak: Vec<_> = weak.collect();
    let level = sidak(SIGNIFICANCE, 5 * 9 * 2);
    for axis in 0..5 {
        for a in 0..9 {
            for b in [a, (a + 1) % 9] {
                let p = pair_uniformity(neighbors(&numbers, axis, a, b), 16);
                assert!(p > level, "axis {axis}, numbers {a} and {b}: {p}");
            }
        }
        assert!(pair_uniformity(neighbors(&weak, axis, 0, 0), 16) < level, "axis {axis} of the twin");
    }
}

#[test]
fn numbers_of_one_key_are_independent() {
    let numbers: Vec<_> = draw(PATTERN_INDEPENDENT, &keys([7, 0, 0, 0, 0])).iter().map(DrawOutput::numbers).collect();
    let level = sidak(SIGNIFICANCE, 36);
    for a in 0..9 {
        for b in a + 1..9 {
            let p = pair_uniformity(numbers.iter().map(|n| (n[a], n[b])), 16);
            assert!(p > level, "numbers {a} and {b}: {p}");
        }
    }
    // The twin must fail: a second number that depends on the first. Each is uniform, the pair is not.
    let leaning = |n: &[f64; 9]| (n[5], if n[6] < 0.05 { n[5] } else { n[6] });
    assert!(pair_uniformity(numbers.iter().map(leaning), 16) < level);
}

/// Numbers of the samples of each set, one set per (pixel, set, seed, vertex, block). No two sets share a tile.
fn sets(pattern: u32) -> Vec<[[f64; 9]; 8]> {
    let (inputs, mut sets) = (keys_of_tiles([3, 0, 0, 0, 0]), BTreeMap::new());
    for (i, o) in inputs.iter().zip(draw(pattern, &inputs)) {
        let place = (i.film_pixel, i.first_of_set, i.seed, i.vertex, i.block);
        sets.entry(place).or_insert_with(|| [[0.0; 9]; 8])[i.sample_index as usize % 8] = o.numbers();
    }
    sets.into_values().collect()
}

/// Whether the points form a net: each rectangle of 1/2^k by 2^k/n, for every k, holds one of the n points. The number
/// n is a power of two.
fn is_net(points: &[(f64, f64)]) -> bool {
    let count = points.len();
    (0..=count.ilog2()).all(|k| {
        let (columns, rows) = (1 << k, count >> k);
        let cell = |&(x, y): &(f64, f64)| (x * columns as f64) as usize + ((y * rows as f64) as usize) * columns;
        points.iter().map(cell).collect::<HashSet<_>>().len() == count
    })
}

#[test]
fn sets_are_nets_of_eight_points() {
    let nets = |pattern: u32, a: usize, b: usize| {
        let sets = sets(pattern);
        let count = sets.iter().filter(|set| is_net(&set.map(|n| (n[a], n[b])))).count();
        count as f64 / sets.len() as f64
    };
    for pattern in SETS {
        assert_eq!((nets(pattern, 0, 1), nets(pattern, 2, 3)), (1.0, 1.0), "{pattern}");
        // The twin must fail: numbers of two nets rarely form a net.
        assert!(nets(pattern, 0, 2) < 0.2 && nets(pattern, 1, 3) < 0.2, "{pattern}");
    }
    assert!(nets(PATTERN_INDEPENDENT, 0, 1) < 0.2);
}

/// Numbers of the camera rays of these samples, for each of `pixels` pixels.
fn camera_rays(adaptive: bool, pixels: u32, samples: Range<u32>) -> Vec<Vec<[f64; 4]>> {
    let key = |pixel: u32, sample_index: u32| DrawInput {
        film_pixel: [pixel % FILM_WIDTH, pixel / FILM_WIDTH],
        film_width: FILM_WIDTH,
        sample_index,
        first_of_set: sample_index - sample_index % 8,
        seed: 1,
        vertex: 0,
        block: 0,
    };
    let keys = (0..pixels).flat_map(|pixel| samples.clone().map(move |index| key(pixel, index)));
    let variant = Variant { pattern: PATTERN_SOBOL, adaptive, ..Variant::default() };
    let outputs = draw_by(&variant, &keys.collect::<Vec<_>>());
    outputs.chunks(samples.len()).map(|of_pixel| of_pixel.iter().map(DrawOutput::camera_numbers).collect()).collect()
}

fn is_net_of(points: &[[f64; 4]], a: usize, b: usize) -> bool {
    is_net(&points.iter().map(|n| (n[a], n[b])).collect::<Vec<_>>())
}

#[test]
fn stretches_of_camera_rays_are_nets() {
    // Nets are also tested where one sequence ends and the next begins.
    for points in [0..1024, (1 << 16) - 512..(1 << 16) + 512].map(|samples| camera_rays(false, 4, samples)).concat() {
        for length in (0..10).map(|digits| 1 << digits) {
            for stretch in points.chunks(length) {
                assert!(is_net_of(stretch, 0, 1) && is_net_of(stretch, 2, 3), "{length}");
            }
        }
        // The twins must fail: points that begin elsewhere, and numbers of two nets.
        assert!(!is_net_of(&points[8..72], 0, 1) && !is_net_of(&points[..64], 0, 2));
    }
}

#[test]
fn halves_have_camera_rays_of_their_own() {
    let rays = camera_rays(true, 64, 0..128);
    let half = |points: &[[f64; 4]], which: usize| {
        points.chunks(8).skip(which).step_by(2).flatten().copied().collect::<Vec<_>>()
    };
    for points in &rays {
        for which in [0, 1] {
            let half = half(points, which);
            assert!(half.len() == 64 && is_net_of(&half, 0, 1) && is_net_of(&half, 2, 3));
        }
        assert!(!is_net_of(points, 0, 1));
    }
    // The two halves are independent.
    let level = sidak(SIGNIFICANCE, 4);
    for k in 0..4 {
        let pairs = rays.iter().flat_map(|points| (0..8).map(move |i| (points[i][k], points[8 + i][k])));
        assert!(pair_uniformity(pairs, 4) > level, "number {k}");
    }
    let of_one = camera_rays(false, 64, 0..128);
    assert!(
        pair_uniformity(of_one.iter().flat_map(|points| (0..8).map(move |i| (points[i][0], points[8 + i][0]))), 4)
            < level
    );
}

/// Numbers of a camera ray are independent of each other, and of the numbers at the first surface, over pixels. They
/// are as independent as without a sequence.
#[test]
fn the_numbers_of_a_camera_ray_are_independent_whatever_its_place() {
    let level = sidak(SIGNIFICANCE, 8 * 10);
    for place in [0, 1, 2, 3, 5, 8, 100, 1000] {
        let pixel = |pixel: u32| DrawInput {
            film_pixel: [pixel % 256, pixel / 256],
            film_width: 256,
            sample_index: place,
            first_of_set: place - place % 8,
            seed: 1,
            vertex: 1,
            block: 0,
        };
        let outputs = draw(PATTERN_SOBOL, &(0..1 << 14).map(pixel).collect::<Vec<_>>());
        let numbers: Vec<[f64; 5]> = outputs
            .iter()
            .map(|o| {
                let [a, b, c, d] = o.camera_numbers();
                [a, b, c, d, o.numbers()[0]]
            })
            .collect();
        for (a, b) in (0..5).flat_map(|a| (a + 1..5).map(move |b| (a, b))) {
            let p = pair_uniformity(numbers.iter().map(|n| (n[a], n[b])), 16);
            assert!(p > level, "place {place}, numbers {a} and {b}: {p}");
        }
        assert!(pair_uniformity(numbers.iter().map(|n| (n[0] / 2.0, n[1])), 16) < level);
    }
}

/// Numbers of one sample per set, chosen by its place, are as independent as without sets.
#[test]
fn the_numbers_of_a_sample_are_independent_whatever_its_place_in_a_set() {
    let level = sidak(SIGNIFICANCE, 2 * 8 * 36);
    for pattern in SETS {
        let sets = sets(pattern);
        for place in 0..8 {
            for (a, b) in (0..9).flat_map(|a| (a + 1..9).map(move |b| (a, b))) {
                let p = pair_uniformity(sets.iter().map(|set| (set[place][a], set[place][b])), 16);
                assert!(p > level, "{pattern}: place {place}, numbers {a} and {b}: {p}");
            }
        }
        // The twin must fail: without shuffling, a sample's place determines its stratum.
        let unshuffled = sets.iter().map(|set| (set[0][0] / 2.0, set[0][1]));
        assert!(pair_uniformity(unshuffled, 16) < level, "{pattern}");
    }
}

#[test]
fn sets_of_neighboring_keys_are_independent() {
    let inputs = keys_of_tiles([100, 0, 0, 0, 0]);
    let level = sidak(SIGNIFICANCE, 2 * 4 * 9 * 2);
    for pattern in SETS {
        let numbers: Vec<_> = draw(pattern, &inputs).iter().map(DrawOutput::numbers).collect();
        // All axes except the sample's are tested.
        for axis in [0, 2, 3, 4] {
            for (a, b) in (0..9).flat_map(|a| [(a, a), (a, (a + 1) % 9)]) {
                let p = pair_uniformity(neighbors(&numbers, axis, a, b), 16);
                assert!(p > level, "{pattern}: axis {axis}, numbers {a} and {b}: {p}");
            }
        }
        let of_set = |n: &[f64; 9]| (n[0], (n[0] + 0.01).fract());
        assert!(pair_uniformity(numbers.iter().map(of_set), 16) < level, "{pattern}");
    }
}

/// Numbers of these samples for all pixels of a square, at one vertex.
fn square(pattern: u32, side: u32, samples: Range<u32>) -> Vec<[f64; 9]> {
    // Each square lies within one tile.
    let corner = [3 * side, 5 * side];
    let key = |at: u32, sample_index| DrawInput {
        film_pixel: [corner[0] + at % side, corner[1] + at / side],
        film_width: 1000,
        sample_index,
        first_of_set: 8,
        seed: 1,
        vertex: 2,
        block: 0,
    };
    let inputs: Vec<_> = (0..side * side).flat_map(|at| samples.clone().map(move |index| key(at, index))).collect();
    draw(pattern, &inputs).iter().map(DrawOutput::numbers).collect()
}

#[test]
fn squares_of_pixels_share_a_net() {
    for side in [2, 4, 8, 16, 32] {
        let is_net = |pattern, samples: Range<u32>, a: usize, b: usize| {
            is_net(&square(pattern, side, samples).iter().map(|n| (n[a], n[b])).collect::<Vec<_>>())
        };
        // All samples of a set form a net, and so does the first sample of every pixel.
        for samples in [8..16, 8..9] {
            for (a, b) in [(0, 1), (2, 3)] {
                assert!(is_net(PATTERN_BLUE_NOISE, samples.clone(), a, b), "{side}: {samples:?}, {a} and {b}");
                assert!(!is_net(PATTERN_SOBOL, samples.clone(), a, b), "{side}: {samples:?}, {a} and {b}");
            }
            // Four numbers of two nets often form a net by chance.
            let is_mixed_net = samples.len() as u32 * side > 2 && is_net(PATTERN_BLUE_NOISE, samples.clone(), 0, 2);
            assert!(!is_mixed_net, "{side}: {samples:?}");
        }
    }
}

/// The nets of a tile are independent: its pixels take points of two nets in unrelated orders.
#[test]
fn the_nets_of_a_tile_are_independent() {
    let numbers = square(PATTERN_BLUE_NOISE, 32, 8..16);
    let level = sidak(SIGNIFICANCE, 4);
    for (a, b) in [(0, 2), (0, 3), (1, 2), (1, 3)] {
        let p = pair_uniformity(numbers.iter().map(|n| (n[a], n[b])), 16);
        assert!(p > level, "numbers {a} and {b}: {p}");
    }
    // The twin must fail: with equal orders, points of two nets lie on few lines.
    assert!(pair_uniformity(numbers.iter().map(|n| (n[0], (3.0 * n[0]).fract())), 16) < level);
}

#[test]
fn a_long_stream_is_uniform_in_pairs_and_along_itself() {
    // One stream is read as the rejection loop reads it, three numbers at a time.
    let mut stream = twin::random_stream(RandomKey { pixel: 3, sample_index: 5, set: SampleSet::Alone, seed: 1 }, 2, 1);
    let values: Vec<f64> = (0..3 << 17).map(|_| twin::next_random(&mut stream)).collect();
    let level = sidak(SIGNIFICANCE, 5);
    assert!(uniformity(values.iter().copied(), 256) > level);
    for lag in 1..=4 {
        let p = pair_uniformity(values.iter().copied().zip(values[lag..].iter().copied()).step_by(2), 32);
        assert!(p > level, "lag {lag}: {p}");
    }
}
