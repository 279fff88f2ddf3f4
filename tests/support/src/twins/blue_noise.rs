//! Twin of `glsl/include/random/blue_noise.glsl`, digit by digit.

use super::sobol::{hashed_owen_scramble, owen_scramble, reversed, sobol};

/// Pixels along a side of a tile.
pub const SIDE: u32 = 32;
/// Number of binary digits of a pixel's place along the curve through its tile.
const PLACE_DIGITS: u32 = 10;
/// Number of binary digits of a set's points.
const POINT_DIGITS: u32 = 13;
/// Polynomial x^3 + x + 1 over GF(2).
const POLYNOMIAL: u32 = 0b1011;

/// Number that identifies the tile of a pixel.
pub fn tile_of([x, y]: [u32; 2]) -> u32 {
    ((y / SIDE) << 16) | (x / SIDE)
}

/// Place of a pixel along Morton's curve (1966) through its tile.
pub fn place_in_tile([x, y]: [u32; 2]) -> u32 {
    (0..PLACE_DIGITS / 2).fold(0, |place, bit| place | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1))
}

/// Product of polynomials over GF(2).
fn product(a: u32, b: u32) -> u32 {
    (0..u32::BITS).filter(|bit| a >> bit & 1 == 1).fold(0, |sum, bit| sum ^ (b << bit))
}

/// First 13 digits of four numbers of the sample at `within_set`, its place in its pixel's part of a set. `bits` are
/// the random bits of the set.
pub fn tile_digits(film_pixel: [u32; 2], within_set: u32, bits: [u32; 4]) -> [u32; 4] {
    let number = |pair: usize| {
        let [mine, other] = [bits[2 * pair], bits[2 * pair + 1]];
        let hash = hashed_owen_scramble(place_in_tile(film_pixel), PLACE_DIGITS, mine >> 16 | other & 0xffff_0000);
        // Of the seven bits, 0, 1 and 3 are those that the digits of 0 meet.
        let sample = owen_scramble(within_set, (hash >> 25) & 0b111_0100);
        product(reversed(hash, PLACE_DIGITS), POLYNOMIAL) ^ sample
    };
    [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(pair, dimension)| {
        let x = sobol(number(pair), dimension, POINT_DIGITS);
        reversed(hashed_owen_scramble(x, POINT_DIGITS, bits[2 * pair + dimension]), POINT_DIGITS)
    })
}
