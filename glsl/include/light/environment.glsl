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

// Block that contains the coordinates.
uvec2 environment_block(vec2 coordinates) {
    uvec2 blocks = scene().environment_blocks;
    return min(uvec2(coordinates * vec2(blocks)), blocks - 1u);
}

// Probability of a block among those of its patch.
float environment_block_probability(uvec2 at) {
    return block_probability(at.y * scene().environment_blocks.x + at.x);
}

struct EnvironmentSample {
    vec3 wi;
    float pdf;  // per steradian
};

// Patches along each side of the environment. Where cells learn which lights to draw, each patch is a light of its own.
uint environment_patches() {
    if (LIGHT_GROUPS != 0u) return ENVIRONMENT_PATCHES;
    return 1u;
}

// Samples a direction towards a patch of the environment. The patches of a constant environment are those of the equal-area
// square, sampled uniformly. For a map, the alias table of the patch draws a block, and the coordinates are uniform in the block.
EnvironmentSample sample_environment(uvec4 bits, uint patch_index) {
    uint side = environment_patches();
    uvec2 at = uvec2(patch_index % side, patch_index / side);
    if (ENVIRONMENT != ENVIRONMENT_MAP) {
        vec2 place = (vec2(at) + unit_floats(bits).zw) / float(side);
        return EnvironmentSample(square_to_sphere(2.0 * place - 1.0), 0.5 * INV_TWO_PI * float(side * side));
    }
    uvec2 blocks = scene().environment_blocks;
    uvec2 first = (at * blocks + side - 1u) / side;
    uvec2 size = ((at + 1u) * blocks + side - 1u) / side - first;
    uint block, rest;
    umulExtended(bits.x, size.x * size.y, block, rest);
    block = (first.y + block / size.x) * blocks.x + first.x + block % size.x;
    BlockRecord entry = load_block(block);
    if (bits.y >= entry.threshold) {
        block = entry.alias;
        entry = load_block(block);
    }
    vec2 corner = vec2(float(block % blocks.x), float(block / blocks.x));
    vec2 coordinates = (corner + unit_floats(bits).zw) / vec2(blocks);
    float pdf = environment_density(entry.probability, coordinates.y);
    return EnvironmentSample(environment_direction(coordinates), pdf);
}

// Density of a direction within the patch of the environment that it points to.
struct EnvironmentDensity {
    float pdf;  // per steradian
    uint patch_index;
};

EnvironmentDensity pdf_environment(vec3 direction) {
    uint side = environment_patches();
    if (ENVIRONMENT != ENVIRONMENT_MAP) {
        if (side == 1u) return EnvironmentDensity(0.5 * INV_TWO_PI, 0u);
        uvec2 at = min(uvec2((0.5 + 0.5 * sphere_to_square(direction)) * float(side)), side - 1u);
        return EnvironmentDensity(0.5 * INV_TWO_PI * float(side * side), at.y * side + at.x);
    }
    vec2 coordinates = environment_coordinates(direction);
    uvec2 block = environment_block(coordinates);
    uvec2 at = block * side / scene().environment_blocks;
    float probability = environment_block_probability(block);
    return EnvironmentDensity(environment_density(probability, coordinates.y), at.y * side + at.x);
}

#endif
