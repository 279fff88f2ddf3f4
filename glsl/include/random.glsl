// Random numbers without state: a hash of (pixel, sample, vertex and block, seed), so that no order of work changes a bit.
#ifndef RANDOM_GLSL
#define RANDOM_GLSL

// What does not change along a path.
struct RandomKey {
    uint pixel;  // index within the whole film
    uint sample_index;
    uint seed;
};

// Blocks of four numbers that a vertex may draw; tries of a rejection loop use RANDOM_TRIES, RANDOM_TRIES + 1, ...
const uint RANDOM_SCATTER = 0u;
const uint RANDOM_RECORD = 1u;
const uint RANDOM_TRIES = 2u;

// Jarzynski and Olano 2020, "Hash Functions for GPU Rendering".
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

// The upper 24 bits as a float in [0, 1).
vec4 unit_floats(uvec4 bits) {
    return vec4(bits >> 8u) * (1.0 / 16777216.0);
}

// Four numbers in [0, 1) for `block` of vertex `vertex` (0 is the camera).
vec4 random4(RandomKey key, uint vertex, uint block) {
    return unit_floats(pcg4d(uvec4(key.pixel, key.sample_index, (vertex << 16u) | block, key.seed)));
}

#endif
