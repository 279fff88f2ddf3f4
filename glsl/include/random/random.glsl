// Random numbers without state. Each number is a hash of pixel, sample, vertex, block and seed, so that the order in
// which invocations run does not change any bit of the picture.
#ifndef RANDOM_GLSL
#define RANDOM_GLSL
#include "random/blue_noise.glsl"
#include "random/sobol.glsl"
#include "shared/variant.glsl"

// Part of a random number's key that is constant along a path.
struct RandomKey {
    uint pixel;  // index within the whole film
    uint sample_index;
    uint first_of_set;  // index of the first sample of the set; the samples of a set share one scrambling
    uint seed;
    // For PATTERN_BLUE_NOISE: the pixel's tile, and the pixel's position along the tile's curve.
    uint tile;
    uint reversed_place;
};

RandomKey random_key(uvec2 film_pixel, uint film_width, uint sample_index, uint first_of_set, uint seed) {
    uint pixel = film_pixel.y * film_width + film_pixel.x;
    return RandomKey(pixel, sample_index, first_of_set, seed, tile_of(film_pixel), reversed_place_in_tile(film_pixel));
}

// Block of random numbers. Each vertex may draw one block for each purpose.
const uint RANDOM_SCATTER = 0u;
const uint RANDOM_TRIES = 1u;
const uint RANDOM_MATERIAL = 2u;
const uint RANDOM_EMITTER = 3u;
const uint RANDOM_ENVIRONMENT = 4u;
const uint RANDOM_LEARNING = 5u;
const uint RANDOM_LIGHT = 6u;
const uint RANDOM_FLIGHT = 7u;
const uint RANDOM_SHADOW = 8u;
const uint RANDOM_TIME = 9u;

// Hash of four words (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// Float in [0, 1) from the upper 24 bits.
float unit_float(uint bits) {
    return float(bits >> 8u) * (1.0 / 16777216.0);
}

vec4 unit_floats(uvec4 bits) {
    return vec4(bits >> 8u) * (1.0 / 16777216.0);
}

// Another number in [0, 1), from the low bits that unit_floats leaves unused. They are the weakest bits of the hash:
// for keys from a small box, the low bits of a single word are measurably uneven. The multiplication by the golden
// ratio spreads the low bits of all four words over the result.
float leftover_float(uvec4 bits) {
    uvec4 low = bits & 0xffu;
    return unit_float((low.x | (low.y << 8u) | (low.z << 16u) | (low.w << 24u)) * 0x9e3779b9u);
}

// Bit of the key that separates the hash of a set from the hash of a sample.
const uint OF_SET = 0x80000000u;

// Four random words for a block of a vertex (vertex 0 is the camera). With PATTERN_SOBOL, the first two words and the
// last two words are each well distributed over the samples of a set. With PATTERN_BLUE_NOISE, they are well
// distributed over the pixels of a square, too.
uvec4 random_bits(RandomKey key, uint vertex, uint block) {
    uint place = (vertex << 16u) | block;
    uvec4 bits = pcg4d(uvec4(key.pixel, key.sample_index, place, key.seed));
    if (PATTERN == PATTERN_INDEPENDENT) return bits;
    uint shared_by = PATTERN == PATTERN_SOBOL ? key.pixel : key.tile;
    uvec4 of_set = pcg4d(uvec4(shared_by, key.first_of_set, place | OF_SET, key.seed));
    if (PATTERN == PATTERN_SOBOL) return (set_digits(key.sample_index, of_set) << 29u) | (bits >> 3u);
    return (tile_digits(key.reversed_place, key.sample_index - key.first_of_set, of_set) << 19u) | (bits >> 13u);
}

// Four random words for a block of a vertex, without a pattern. Nothing else may draw from the same block.
uvec4 plain_bits(RandomKey key, uint vertex, uint block) {
    return pcg4d(uvec4(key.pixel, key.sample_index, (vertex << 16u) | block, key.seed));
}

// Bit of the key that separates the hash of a sequence from the hash of a set.
const uint OF_SEQUENCE = 0x40000000u;

// Four random words for the camera ray. With PATTERN_SOBOL, the first two words and the last two words are each well
// distributed over all samples of a pixel, not only over a set. A guide learns from some of these samples before it
// guides others. This causes no bias: the expected contribution of a camera ray is the same whatever the guide has
// learned.
uvec4 camera_bits(RandomKey key) {
    if (PATTERN != PATTERN_SOBOL) return random_bits(key, 0u, RANDOM_SCATTER);
    uint number = key.sample_index;
    uint sequence = OF_SET | OF_SEQUENCE;
    if (ADAPTIVE) {
        // Each half of the samples has a sequence of its own, because the difference of the halves estimates the error.
        number = number / (2u * SET_SIZE) * SET_SIZE + number % SET_SIZE;
        sequence |= key.sample_index / SET_SIZE % 2u;
    }
    uvec4 of_sequence = pcg4d(uvec4(key.pixel, number >> 16u, sequence, key.seed));
    uvec4 bits = pcg4d(uvec4(key.pixel, key.sample_index, RANDOM_SCATTER, key.seed));
    return (sequence_digits(number & 0xffffu, of_sequence) << 16u) | (bits >> 16u);
}

// Stream of random numbers for a loop: xorshift (Marsaglia 2003), seeded by the hash.
struct RandomStream {
    uvec4 state;
};

RandomStream random_stream(RandomKey key, uint vertex, uint block) {
    // The lowest bit is set because xorshift must not start from all zeros.
    return RandomStream(random_bits(key, vertex, block) | uvec4(0u, 0u, 0u, 1u));
}

uint next_bits(inout RandomStream stream) {
    uvec4 s = stream.state;
    uint t = s.x ^ (s.x << 11u);
    stream.state = uvec4(s.yzw, (s.w ^ (s.w >> 19u)) ^ (t ^ (t >> 8u)));
    return stream.state.w;
}

float next_random(inout RandomStream stream) {
    return unit_float(next_bits(stream));
}

#endif
