// Environment: radiance from infinitely far away, and sampling of directions towards it. An environment map is a
// latitude-longitude image as in Mitsuba: the texel centers are spread over the azimuth, the first and the last row are
// the poles.
#ifndef ENVIRONMENT_GLSL
#define ENVIRONMENT_GLSL
#include "math/equal_area.glsl"
#include "film/frame.glsl"
#include "random/random.glsl"

// Coordinates of a direction on the map, each in [0, 1): the azimuth from -z towards +x, and the angle from +y.
vec2 environment_coordinates(vec3 direction) {
    vec4 rows[3] = scene().environment_from_world;
    vec3 d = vec3(dot(rows[0].xyz, direction), dot(rows[1].xyz, direction), dot(rows[2].xyz, direction));
    return vec2(fract(turns_of(vec2(-d.z, d.x))), 2.0 * turns_of(vec2(d.y, length(d.xz))));
}

vec3 environment_direction(vec2 coordinates) {
    vec2 azimuth = sin_cos_turn(coordinates.x);
    vec2 polar = sin_cos_turn(0.5 * coordinates.y);
    vec3 d = vec3(polar.x * azimuth.x, polar.y, -polar.x * azimuth.y);
    vec4 rows[3] = scene().environment_from_world;
    return d.x * rows[0].xyz + d.y * rows[1].xyz + d.z * rows[2].xyz;
}

// Color of a texel. Each group of four words of the emitter buffer holds two texels as halves.
vec3 environment_texel(uint x, uint y) {
    uint index = y * scene().environment_size.x + x;
    uvec4 pair = fetch_emitter_texel(scene().first_environment_texel + (index >> 1u));
    uvec2 words = (index & 1u) == 0u ? pair.xy : pair.zw;
    return vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
}

// Bilinear interpolation of the map.
vec3 environment_map(vec2 coordinates) {
    uvec2 size = scene().environment_size;
    vec2 at = coordinates * vec2(float(size.x), float(size.y - 1u)) - vec2(0.5, 0.0);
    if (at.x < 0.0) at.x += float(size.x);
    uint x0 = min(uint(at.x), size.x - 1u);
    uint x1 = x0 + 1u == size.x ? 0u : x0 + 1u;
    uint y0 = min(uint(at.y), size.y - 2u);
    vec2 share = clamp(at - vec2(float(x0), float(y0)), 0.0, 1.0);
    vec3 upper = mix(environment_texel(x0, y0), environment_texel(x1, y0), share.x);
    vec3 lower = mix(environment_texel(x0, y0 + 1u), environment_texel(x1, y0 + 1u), share.x);
    return mix(upper, lower, share.y);
}

vec3 environment_radiance(vec3 direction) {
    if (ENVIRONMENT == ENVIRONMENT_NONE) return vec3(0.0);
    if (ENVIRONMENT == ENVIRONMENT_CONSTANT) return scene().environment;
    return scene().environment * environment_map(environment_coordinates(direction));
}

// Density of a direction on the map, per steradian, given the probability of its block. All blocks are equal in size in
// coordinates.
float environment_density(float probability, float polar) {
    uvec2 blocks = scene().environment_blocks;
    float sine = max(sin_cos_turn(0.5 * polar).x, 1.0e-7);
    return probability * float(blocks.x * blocks.y) * INV_TWO_PI * INV_PI / sine;
}

// Probability of the block that contains the coordinates. It is the last word of the block's entry, after threshold and
// alias.
float environment_block_probability(vec2 coordinates) {
    uvec2 blocks = scene().environment_blocks;
    uvec2 at = min(uvec2(coordinates * vec2(blocks)), blocks - 1u);
    return uintBitsToFloat(fetch_emitter_texel(scene().first_environment_block + at.y * blocks.x + at.x).w);
}

struct EnvironmentSample {
    vec3 wi;
    float pdf;  // per steradian
};

// Samples a direction towards the environment. A constant environment is sampled uniformly over the sphere. For a map,
// the alias table draws a block, and the coordinates are uniform in the block.
EnvironmentSample sample_environment(uvec4 bits) {
    if (ENVIRONMENT != ENVIRONMENT_MAP) {
        return EnvironmentSample(square_to_sphere(2.0 * unit_floats(bits).zw - 1.0), 0.5 * INV_TWO_PI);
    }
    uvec2 blocks = scene().environment_blocks;
    uint block, rest;
    umulExtended(bits.x, blocks.x * blocks.y, block, rest);
    uvec4 entry = fetch_emitter_texel(scene().first_environment_block + block);
    if (bits.y >= entry.x) {
        block = entry.y;
        entry = fetch_emitter_texel(scene().first_environment_block + block);
    }
    vec2 corner = vec2(float(block % blocks.x), float(block / blocks.x));
    vec2 coordinates = (corner + unit_floats(bits).zw) / vec2(blocks);
    float pdf = environment_density(uintBitsToFloat(entry.w), coordinates.y);
    return EnvironmentSample(environment_direction(coordinates), pdf);
}

float pdf_environment(vec3 direction) {
    if (ENVIRONMENT != ENVIRONMENT_MAP) return 0.5 * INV_TWO_PI;
    vec2 coordinates = environment_coordinates(direction);
    return environment_density(environment_block_probability(coordinates), coordinates.y);
}

#endif
