// Blue-noise sampling (Ahmed and Wonka 2020): samples that are well distributed over the unit square within each pixel
// and also over squares of neighboring pixels, so that the errors of neighbors cancel. A set holds eight samples of
// every pixel of a tile. Its points are the beginning of the first two dimensions of Sobol's sequence, a (0,
// 2)-sequence: 2^n consecutive points that start at a multiple of 2^n form a net. The points are assigned to pixels
// along Morton's curve. The curve visits squares of pixels one after the other, and within each square its quarters.
#ifndef BLUE_NOISE_GLSL
#define BLUE_NOISE_GLSL
#include "random/sobol.glsl"

// Number of binary digits of a pixel's position along the curve through a tile of 32 x 32 pixels.
const uint PLACE_DIGITS = 10u;
// Number of binary digits of a sample's index within its set.
const uint POINT_DIGITS = PLACE_DIGITS + 3u;

uint tile_of(uvec2 film_pixel) {
    uvec2 tile = film_pixel >> (PLACE_DIGITS / 2u);
    return (tile.y << 16u) | tile.x;
}

// Position of a pixel along the Morton curve of its tile (Morton 1966), with reversed digits: the most significant
// digit is the lowest bit. The function interleaves the last five digits of both coordinates.
uint reversed_place_in_tile(uvec2 film_pixel) {
    uvec2 v = film_pixel & 31u;
    v = (v | (v << 4u)) & 0x0f0fu;
    v = (v | (v << 2u)) & 0x3333u;
    v = (v | (v << 1u)) & 0x5555u;
    return bitfieldReverse(v.x | (v.y << 1u)) >> (32u - PLACE_DIGITS);
}

// First POINT_DIGITS digits of four random numbers. `within_set` in [0, 8) is the sample's number among the pixel's
// samples of the set. `bits` are random and equal for the whole set.
uvec4 tile_digits(uint reversed_place, uint within_set, uvec4 bits) {
    uvec4 shuffled = hashed_owen_scramble(uvec4(reversed_place), (bits >> 16u) | (bits.yxwz & 0xffff0000u));
    uvec4 place = bitfieldReverse(shuffled) >> (32u - PLACE_DIGITS);
    // A pixel has eight consecutive points. Other bits of the hash choose their order, except that the first sample
    // always takes the point whose number is divisible by x^3 + x + 1 (as polynomials over GF(2)). These points of all
    // pixels form a (0, 2)-sequence, too, so that one sample per pixel is already blue noise.
    uvec4 sample_of_set = owen_scramble(uvec4(within_set), (shuffled >> 25u) & ~FLIPS_OF_ZERO);
    uvec4 point = place ^ (place << 1u) ^ (place << 3u) ^ sample_of_set;
    uvec4 scrambled = hashed_owen_scramble(reversed_sobol(point.xz), bits);
    return bitfieldReverse(scrambled) >> (32u - POINT_DIGITS);
}

#endif
