//! Twin of `glsl/include/random/random.glsl`. Its words are equal, and so are its floats, which have 24 bits.

use super::blue_noise::{tile_digits, tile_of};
use super::sobol::{SET_SIZE, sequence_digits, set_digits};

/// Constants of a path: `RandomKey` in GLSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RandomKey {
    /// Index of the pixel within the whole film.
    pub pixel: u32,
    /// Index of the sample within the pixel.
    pub sample_index: u32,
    /// Set of samples that are well distributed together with this one.
    pub set: SampleSet,
    /// Seed of the render.
    pub seed: u32,
}

/// Set of samples that share a scrambling. The numbers are the index of its first sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleSet {
    /// Only this sample.
    Alone,
    /// Samples of the pixel.
    OfPixel(u32),
    /// Samples of all pixels of a tile: the tile that holds this pixel of the film.
    OfTile(u32, [u32; 2]),
}

/// Hash `pcg4d` (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
pub fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let v = v.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let v = mix_words(v).map(|x| x ^ (x >> 16));
    mix_words(v)
}

fn mix_words([mut x, mut y, mut z, mut w]: [u32; 4]) -> [u32; 4] {
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

/// Number in [0, 1) from the upper 24 bits.
pub fn unit_float(bits: u32) -> f64 {
    f64::from(bits >> 8) / f64::from(1 << 24)
}

/// Extra number from the lowest bytes of all words.
pub fn leftover_float(bits: [u32; 4]) -> f64 {
    let low = u32::from_le_bytes(bits.map(|word| word as u8));
    unit_float(low.wrapping_mul(0x9e37_79b9))
}

/// Four random words for a block of a vertex.
pub fn random_bits(key: RandomKey, vertex: u32, block: u32) -> [u32; 4] {
    let place = vertex << 16 | block;
    let bits = pcg4d([key.pixel, key.sample_index, place, key.seed]);
    let of_set = |shared_by, first| pcg4d([shared_by, first, place | 1 << 31, key.seed]);
    let (digits, count) = match key.set {
        SampleSet::Alone => return bits,
        SampleSet::OfPixel(first) => (set_digits(key.sample_index, of_set(key.pixel, first)), 3),
        SampleSet::OfTile(first, film_pixel) => {
            let within_set = key.sample_index.wrapping_sub(first);
            (tile_digits(film_pixel, within_set, of_set(tile_of(film_pixel), first)), 13)
        }
    };
    [0, 1, 2, 3].map(|k| digits[k] << (32 - count) | bits[k] >> count)
}

/// Four random words for the camera's ray. For sets of a pixel, all samples share one sequence, or each half of them
/// has one.
pub fn camera_bits(key: RandomKey, halves: bool) -> [u32; 4] {
    if !matches!(key.set, SampleSet::OfPixel(_)) {
        return random_bits(key, 0, 0);
    }
    let (set, within_set) = (key.sample_index / SET_SIZE, key.sample_index % SET_SIZE);
    let (half, number) = if halves { (set % 2, set / 2 * SET_SIZE + within_set) } else { (0, key.sample_index) };
    let of_sequence = pcg4d([key.pixel, number >> 16, 3 << 30 | half, key.seed]);
    let bits = pcg4d([key.pixel, key.sample_index, 0, key.seed]);
    let digits = sequence_digits(number & 0xffff, of_sequence);
    [0, 1, 2, 3].map(|k| digits[k] << 16 | bits[k] >> 16)
}

/// Random stream: Marsaglia's xorshift of four words (2003).
#[derive(Debug, Clone, Copy)]
pub struct RandomStream {
    /// Words of the stream, the newest last.
    pub state: [u32; 4],
}

/// Stream that starts from the hash of its key.
pub fn random_stream(key: RandomKey, vertex: u32, block: u32) -> RandomStream {
    let [x, y, z, w] = random_bits(key, vertex, block);
    RandomStream { state: [x, y, z, w | 1] }
}

/// The stream's next number in [0, 1).
pub fn next_random(stream: &mut RandomStream) -> f64 {
    let [x, y, z, w] = stream.state;
    let t = x ^ (x << 11);
    let next = w ^ (w >> 19) ^ t ^ (t >> 8);
    stream.state = [y, z, w, next];
    unit_float(next)
}
