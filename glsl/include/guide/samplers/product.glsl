// The exact product sampler: learned radiance times cosine by a descent of fixed length, without rejection.
//
// The map of directions is cut into 4 x 4 blocks, those (with 32 or 64 bins a side) into 2 x 2 or 4 x 4 smaller ones, and
// these into 4 x 4 bins. What each block of the first level holds of the product for this cell and normal is memoized in the
// normalization grid; further down the weights of the cell's radiance and of the normal's cosine are multiplied on the way.
// With 16 bins a side, a bin's probability so is in proportion to its L times the integral of cos+(nb, w) over it, but for the
// rounding of weights to three bits; and whatever the weights are, the density is what samples are drawn from. It is mixed with
// a share e of the cosine about the true normal, see bsdf_share.glsl, so that it is positive wherever a surface can reflect:
//     pdf = (1 - e) * probability of the bin * bins per steradian + e cos+(n, w) / pi.
#ifndef PRODUCT_GLSL
#define PRODUCT_GLSL
#include "guide/samplers/guide.glsl"
#include "guide/samplers/parts.glsl"
#include "random/random.glsl"
#include "math/small_floats.glsl"
#include "guide/samplers/tree.glsl"

// Weights of a node's parts: the cell's radiance times the normal's cosine.
mat4 node_weights(Guide guide, uint node) {
    uint of_cell = guide.cell * nodes_per_tree() + node;
    uint of_normal = guide.normal_bin * nodes_per_tree() + node;
    return matrixCompMult(unpack_weights_8(radiance_node(of_cell)), unpack_weights_8(cosine_node(of_normal)));
}

// Goes down to a bin, which `u` chooses, or to the given one. Returns its probability.
float descend(Guide guide, bool choose, inout uvec2 bin, vec2 u) {
    uint below = DIRECTION_RESOLUTION / 4u;
    uvec2 at = bin / below;
    float probability = choose_part(unpack_weights_7(guide.record), choose, at, u);
    if (has_middle_level()) {
        uvec2 part = bin / 4u % middle_parts();
        mat4 weights = middle_weights(node_weights(guide, middle_node(at)));
        probability *= choose_part(weights, choose, part, u);
        at = at * middle_parts() + part;
    }
    uvec2 part = bin % 4u;
    probability *= choose_part(node_weights(guide, last_node(at)), choose, part, u);
    bin = at * 4u + part;
    return probability;
}

uvec2 bin_coordinates(uint bin) {
    return uvec2(bin % DIRECTION_RESOLUTION, bin / DIRECTION_RESOLUTION);
}

// Density of the descent in a bin that it reaches with this probability.
float descent_density(float probability) {
    return probability * bin_density();
}

// Density over a diffuse lobe: of the descent's and the share of the cosine.
float product_density(Guide guide, vec3 wi, float of_descent) {
    float of_cosine = max(dot(wi, guide.n), 0.0) * INV_PI;
    return mix(of_descent, of_cosine, guide.bsdf_share);
}

// A direction by descent, or with the probability `own_share`, and where `follows` is false, `own`, which the caller has drawn.
// With the descent's density of either. One flow for all: lanes that do not need a part of it would wait for it.
GuidedSample sample_product(vec4 u, Guide guide, bool follows, float own_share, vec3 own) {
    bool by_guide = follows && u.x >= own_share;
    u.x = min((u.x - own_share) / (1.0 - own_share), 1.0 - 1.0 / 16777216.0);
    uvec2 at = bin_coordinates(direction_bin(own));
    float density = descent_density(descend(guide, by_guide, at, u.xy));
    uint bin = at.y * DIRECTION_RESOLUTION + at.x;
    vec3 wi = by_guide ? map_to_sphere(bin_point(bin, DIRECTION_RESOLUTION, u.zw)) : own;
    return GuidedSample(wi, density, bin, bin_radiance(guide, bin), by_guide ? 1u : 0u, false);
}

// The descent's density of a direction.
float pdf_product(Guide guide, vec3 wi) {
    uvec2 at = bin_coordinates(direction_bin(wi));
    return descent_density(descend(guide, false, at, vec2(0.0)));
}

#endif
