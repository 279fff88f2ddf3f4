// Samples that cover unit squares evenly also over squares of pixels, so that what one pixel errs its neighbors make up for:
// blue noise (Ahmed and Wonka 2020). A set holds eight samples of every pixel of a tile: the beginning of the first two dimensions
// of Sobol's sequence, a (0, 2)-sequence, of which every stretch of 2^n points, from a multiple of 2^n on, is a net. They are dealt
// out along Morton's curve, which goes through squares of pixels, one after the other, and through their quarters likewise.
#ifndef BLUE_NOISE_GLSL
#define BLUE_NOISE_GLSL
#include "random/sobol.glsl"

// Binary digits of the place of a pixel along the curve through a tile of 32 x 32.
const uint PLACE_DIGITS = 10u;
// Those of the place of a sample among all of a set.
const uint POINT_DIGITS = PLACE_DIGITS + 3u;

uint tile_of(uvec2 film_pixel) {
    uvec2 tile = film_pixel >> (PLACE_DIGITS / 2u);
    return (tile.y << 16u) | tile.x;
}

// The first five digits of both coordinates in turns (Morton 1966), the most significant as the lowest bit.
uint reversed_place_in_tile(uvec2 film_pixel) {
    uvec2 v = film_pixel & 31u;
    v = (v | (v << 4u)) & 0x0f0fu;
    v = (v | (v << 2u)) & 0x3333u;
    v = (v | (v << 1u)) & 0x5555u;
    return bitfieldReverse(v.x | (v.y << 1u)) >> (32u - PLACE_DIGITS);
}

// The first digits of four numbers of a pixel's sample in [0, 8) of its set; `bits` are random and the same for all of a set.
uvec4 tile_digits(uint reversed_place, uint within_set, uvec4 bits) {
    uvec4 shuffled = hashed_owen_scramble(uvec4(reversed_place), (bits >> 16u) | (bits.yxwz & 0xffff0000u));
    uvec4 place = bitfieldReverse(shuffled) >> (32u - PLACE_DIGITS);
    // A pixel has eight points in a row, in an order that other bits of the hash choose. But the first has the number that
    // x^3 + x + 1 divides (in polynomials over GF(2)): such points of all pixels are a (0, 2)-sequence, too, so that one sample a
    // pixel is blue noise already.
    uvec4 sample_of_set = owen_scramble(uvec4(within_set), (shuffled >> 25u) & ~FLIPS_OF_ZERO);
    uvec4 point = place ^ (place << 1u) ^ (place << 3u) ^ sample_of_set;
    uvec4 scrambled = hashed_owen_scramble(reversed_sobol(point.xz), bits);
    return bitfieldReverse(scrambled) >> (32u - POINT_DIGITS);
}

#endif
