//! Twin of `glsl/include/random/random.glsl`, tested against known results.

use support::twins::random::{RandomStream, leftover_float, next_random, unit_float};

#[test]
fn xorshift_is_marsaglias() {
    let mut stream = RandomStream { state: [123_456_789, 362_436_069, 521_288_629, 88_675_123] };
    next_random(&mut stream);
    assert_eq!(stream.state[3], 3_701_687_786);
}

#[test]
fn no_bit_of_a_word_is_used_twice() {
    assert!(leftover_float([0xff, 0, 0, 0]) > 0.0);
    assert_eq!(leftover_float([!0xff; 4]), 0.0);
    assert_eq!(unit_float(0xff), 0.0);
}
