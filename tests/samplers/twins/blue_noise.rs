//! Twin of `glsl/include/random/blue_noise.glsl`, tested against known results.

use support::twins::blue_noise::{SIDE, place_in_tile, tile_of};
use support::twins::sobol::{sobol, sobol_digits};

#[test]
fn three_digits_are_those_of_sets_of_eight() {
    for (number, dimension) in (0..8).flat_map(|number| [(number, 0), (number, 1)]) {
        assert_eq!(sobol(number, dimension, 3), sobol_digits(number, dimension));
    }
}

#[test]
fn the_curve_goes_through_every_pixel_of_a_tile() {
    let mut places: Vec<_> = (0..SIDE * SIDE).map(|at| place_in_tile([at % SIDE, at / SIDE])).collect();
    assert_eq!(places[..3], [0, 1, 4]);
    places.sort_unstable();
    assert!(places.into_iter().eq(0..SIDE * SIDE));
    assert_eq!([tile_of([31, 31]), tile_of([32, 0]), tile_of([0, 32])], [0, 1, 1 << 16]);
}
