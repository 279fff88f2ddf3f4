//! Twin of `glsl/include/random/sobol.glsl`, digit by digit.

/// Number of samples in a set.
pub const SET_SIZE: u32 = 8;
/// Number of binary digits of a coordinate that a set of eight samples stratifies.
const DIGITS: u32 = 3;

/// First three direction numbers of the first two dimensions of Sobol's sequence, as three binary digits each.
const DIRECTIONS: [[u32; 3]; 2] = [[0b100, 0b010, 0b001], [0b100, 0b110, 0b101]];

/// Coordinate of one of the first eight points of Sobol's sequence (Sobol' 1967), as three binary digits.
pub fn sobol_digits(index: u32, dimension: usize) -> u32 {
    (0..DIGITS).filter(|&bit| index >> bit & 1 == 1).fold(0, |x, bit| x ^ DIRECTIONS[dimension][bit as usize])
}

/// Scrambling of three binary digits by Owen (1995): the digits choose a path through a binary tree of random bits.
pub fn owen_scramble(x: u32, flips: u32) -> u32 {
    let (mut node, mut scrambled) = (1, 0);
    for digit in (0..DIGITS).rev().map(|place| x >> place & 1) {
        scrambled = scrambled << 1 | (digit ^ flips >> (node - 1) & 1);
        node = 2 * node + digit;
    }
    scrambled
}

/// First three digits of four numbers of a sample. `bits` are the random bits of its set.
pub fn set_digits(sample_index: u32, bits: [u32; 4]) -> [u32; 4] {
    let number = |pair: usize| owen_scramble(sample_index % SET_SIZE, bits[pair] >> 18);
    [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(pair, dimension)| {
        let digits = sobol_digits(number(pair), dimension);
        owen_scramble(digits, bits[2 * pair + dimension] >> 25)
    })
}

/// Lowest `digits` binary digits of `x`, in reverse order.
pub fn reversed(x: u32, digits: u32) -> u32 {
    (0..digits).fold(0, |reversed, bit| reversed << 1 | (x >> bit & 1))
}

/// Scrambling by Owen with a hash (Laine and Karras 2011). The lowest bits of the result are the scrambled digits of
/// `x`, the most significant digit lowest.
pub fn hashed_owen_scramble(x: u32, digits: u32, seed: u32) -> u32 {
    let step = |x: u32, factor: u32| x ^ x.wrapping_mul(factor);
    let x = step(reversed(x, digits), 0x3d20_adea).wrapping_add(seed).wrapping_mul(seed >> 16 | 1);
    step(step(x, 0x0552_6c56), 0x53a2_2864)
}

/// First digits of a coordinate of a point of Sobol's sequence (Sobol' 1967).
pub fn sobol(number: u32, dimension: usize, digits: u32) -> u32 {
    let first = 1 << (digits - 1);
    let next = |v: &u32| Some(if dimension == 0 { v >> 1 } else { v ^ (v >> 1) });
    let directions = std::iter::successors(Some(first), next);
    (0..digits).zip(directions).filter(|(bit, _)| number >> bit & 1 == 1).fold(0, |x, (_, direction)| x ^ direction)
}

/// Number of digits of a coordinate that a sequence stratifies.
const SEQUENCE_DIGITS: u32 = 16;

/// First 16 digits of four numbers of a point of a sequence. `bits` are the random bits of the sequence.
pub fn sequence_digits(number: u32, bits: [u32; 4]) -> [u32; 4] {
    let scrambled = |x, seed| reversed(hashed_owen_scramble(x, SEQUENCE_DIGITS, seed), SEQUENCE_DIGITS);
    let other = scrambled(number, bits[2] >> 16 | bits[3] & 0xffff_0000);
    [0, 1, 2, 3].map(|k| {
        let number = if k < 2 { number } else { other };
        scrambled(sobol(number, k % 2, SEQUENCE_DIGITS), bits[k])
    })
}
