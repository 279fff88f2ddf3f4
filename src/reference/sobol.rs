//! Twin of `glsl/include/sobol.glsl`, digit by digit.

/// Binary digits of a coordinate that a set of eight samples stratifies.
const DIGITS: u32 = 3;

/// The first three direction numbers of the first two dimensions of Sobol's sequence, as three binary digits each.
const DIRECTIONS: [[u32; 3]; 2] = [[0b100, 0b010, 0b001], [0b100, 0b110, 0b101]];

/// A coordinate of one of the first eight points of Sobol's sequence (Sobol' 1967), as three binary digits.
pub fn sobol_digits(index: u32, dimension: usize) -> u32 {
    (0..DIGITS).filter(|&bit| index >> bit & 1 == 1).fold(0, |x, bit| x ^ DIRECTIONS[dimension][bit as usize])
}

/// Owen's scrambling (1995) of three binary digits: a binary tree of random bits, of which the digits choose a path.
pub fn owen_scramble(x: u32, flips: u32) -> u32 {
    let (mut node, mut scrambled) = (1, 0);
    for digit in (0..DIGITS).rev().map(|place| x >> place & 1) {
        scrambled = scrambled << 1 | (digit ^ flips >> (node - 1) & 1);
        node = 2 * node + digit;
    }
    scrambled
}

/// The first three digits of four numbers of a sample; `bits` are those of its set.
pub fn set_digits(sample_index: u32, bits: [u32; 4]) -> [u32; 4] {
    let number = |pair: usize| owen_scramble(sample_index % 8, bits[pair] >> 18);
    [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(pair, dimension)| {
        let digits = sobol_digits(number(pair), dimension);
        owen_scramble(digits, bits[2 * pair + dimension] >> 25)
    })
}
