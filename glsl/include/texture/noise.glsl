// Perlin's noise of 2002 with the permutation of his reference, as pbrt-v4 has it, and the sums of octaves of it.
#ifndef NOISE_GLSL
#define NOISE_GLSL
#include "film/frame.glsl"
#include "shared/records.glsl"

// Entry `i` modulo 256 of the permutation, whose bytes begin at the word `table`.
uint permuted(uint table, uint i) {
    return (texel_word(table + ((i & 255u) >> 2u)) >> (8u * (i & 3u))) & 255u;
}

// Dot product of a lattice point's gradient, one of twelve, with the vector `d` from the point.
float lattice_gradient(uint entry, vec3 d) {
    uint h = entry & 15u;
    bool is_twelfth = h == 12u || h == 13u;
    float u = h < 8u || is_twelfth ? d.x : d.y;
    float v = h < 4u || is_twelfth ? d.y : d.z;
    return ((h & 1u) != 0u ? -u : u) + ((h & 2u) != 0u ? -v : v);
}

// Noise at a point, in [-1, 1], with the period 256 along each axis.
float perlin_noise(uint table, vec3 p) {
    vec3 cell = floor(p);
    vec3 d = p - cell;
    uvec3 i = uvec3(clamp(cell - 256.0 * floor(cell / 256.0), vec3(0.0), vec3(255.0)));
    uint x0 = permuted(table, i.x), x1 = permuted(table, i.x + 1u);
    uvec4 xy = uvec4(permuted(table, x0 + i.y), permuted(table, x1 + i.y), permuted(table, x0 + i.y + 1u),
                     permuted(table, x1 + i.y + 1u)) + i.z;
    vec4 lower = vec4(lattice_gradient(permuted(table, xy.x), d),
                     lattice_gradient(permuted(table, xy.y), d - vec3(1.0, 0.0, 0.0)),
                     lattice_gradient(permuted(table, xy.z), d - vec3(0.0, 1.0, 0.0)),
                     lattice_gradient(permuted(table, xy.w), d - vec3(1.0, 1.0, 0.0)));
    d.z -= 1.0;
    vec4 upper = vec4(lattice_gradient(permuted(table, xy.x + 1u), d),
                    lattice_gradient(permuted(table, xy.y + 1u), d - vec3(1.0, 0.0, 0.0)),
                    lattice_gradient(permuted(table, xy.z + 1u), d - vec3(0.0, 1.0, 0.0)),
                    lattice_gradient(permuted(table, xy.w + 1u), d - vec3(1.0, 1.0, 0.0)));
    d.z += 1.0;
    vec3 weight = d * d * d * (d * (d * 6.0 - 15.0) + 10.0);
    vec4 values = mix(lower, upper, weight.z);
    vec2 rows = mix(values.xz, values.yw, weight.x);
    return mix(rows.x, rows.y, weight.y);
}

// Sum of octaves of noise. Each has 1.99 times the frequency of the one before, and `roughness` times its amplitude. With
// `absolute`, the sum is that of absolute values, plus the mean of the octaves that are left out.
float octaves_of_noise(uint table, vec3 p, uint octaves, float roughness, bool absolute) {
    float sum = 0.0;
    float amplitude = 1.0;
    bool more = octaves > 0u;
    for (uint i = 0u; i < MAX_OCTAVES && more; ++i) {
        float value = perlin_noise(table, p);
        if (more) {
            sum += amplitude * (absolute ? abs(value) : value);
            amplitude *= roughness;
        }
        p *= 1.99;
        more = i + 1u < octaves;
        if (!more) break;
    }
    return absolute ? sum + 0.2 * amplitude : sum;
}

// Whether a point of the plane lies in a dot. Half of the cells of the unit grid have one, of radius 0.35 at a place of its own.
bool is_in_dot(uint table, vec2 st) {
    vec2 cell = floor(st + 0.5);
    bool has_dot = perlin_noise(table, vec3(cell + 0.5, 0.5)) > 0.0;
    vec2 shift = vec2(perlin_noise(table, vec3(cell + vec2(1.5, 2.8), 0.5)),
                      perlin_noise(table, vec3(cell + vec2(4.5, 9.8), 0.5)));
    vec2 from_center = st - cell - 0.15 * shift;
    return has_dot && dot(from_center, from_center) < 0.35 * 0.35;
}

#endif
