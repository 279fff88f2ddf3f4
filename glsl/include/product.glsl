// The exact product sampler: learned radiance times cosine by a descent of fixed length, without rejection.
//
// The map of directions is cut into 4 x 4 blocks, those (with 32 or 64 bins a side) into 2 x 2 or 4 x 4 smaller ones, and
// these into 4 x 4 bins. What each block of the first level holds of the product for this cell and normal is memoized in the
// normalization grid; further down the weights of the cell's radiance and of the normal's cosine are multiplied on the way.
// With 16 bins a side, a bin's probability so is in proportion to its L times the integral of cos+(nb, w) over it, but for the
// rounding of weights to three bits; and whatever the weights are, the density is what samples are drawn from. It is mixed with
// a share e of the cosine about the true normal, so that it is positive wherever a surface can reflect:
//     pdf = (1 - e) * probability of the bin * bins per steradian + e cos+(n, w) / pi.
#ifndef PRODUCT_GLSL
#define PRODUCT_GLSL
#include "guide.glsl"
#include "parts.glsl"
#include "random.glsl"
#include "small_floats.glsl"
#include "tree.glsl"

float cosine_share() {
    return EPSILON > 0.0 ? EPSILON : 0.25;
}

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

// In proportion to the cosine: a point on the unit sphere around the tip of the normal.
vec3 cosine_about(vec3 n, vec2 u) {
    vec3 w = n + square_to_sphere(2.0 * u - 1.0);
    float length2 = dot(w, w);
    return length2 > 1.0e-8 ? w * inversesqrt(length2) : n;
}

float product_density(Guide guide, vec3 wi, float probability) {
    float e = cosine_share();
    return (1.0 - e) * probability * bin_density() + e * max(dot(wi, guide.n), 0.0) * INV_PI;
}

GuidedSample sample_product(RandomKey key, uint vertex, float choice, Guide guide) {
    vec4 u = unit_floats(random_bits(key, vertex, RANDOM_TRIES));
    bool by_cosine = choice < cosine_share();
    vec3 wi = guide.n;
    uint bin = 0u;
    if (by_cosine) {
        wi = cosine_about(guide.n, u.xy);
        bin = direction_bin(wi);
    }
    uvec2 at = bin_coordinates(bin);
    float probability = descend(guide, !by_cosine, at, u.xy);
    bin = at.y * DIRECTION_RESOLUTION + at.x;
    if (!by_cosine) wi = map_to_sphere(bin_point(bin, DIRECTION_RESOLUTION, u.zw));
    return GuidedSample(wi, product_density(guide, wi, probability), bin, bin_radiance(guide, bin), 1u, false);
}

float pdf_product(Guide guide, vec3 wi) {
    uvec2 at = bin_coordinates(direction_bin(wi));
    return product_density(guide, wi, descend(guide, false, at, vec2(0.0)));
}

#endif
