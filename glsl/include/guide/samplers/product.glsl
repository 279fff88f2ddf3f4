// Sampler product: learned radiance times cosine, sampled exactly by a descent of fixed length, without rejection.
//
// The map of directions is divided into 4 x 4 blocks. With 32 or 64 bins per side, each block is divided into 2 x 2 or
// 4 x 4 smaller blocks. The last blocks are divided into 4 x 4 bins. The normalization grid memoizes the product's
// integral over each block of the first level, for a cell and a normal. On the levels below, the descent multiplies the
// weights of the cell's radiance and of the normal's cosine.
//
// With 16 bins per side, the probability of a bin is proportional to its L times the integral of cos+(nb, w) over it,
// up to the rounding of weights to three bits. For any weights, the density is exactly that of the samples. The descent
// is mixed with a share e of the cosine about the true normal (see bsdf_share.glsl), so that the density is positive
// wherever a surface can reflect:
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

// Descends to a bin: the one that `u` draws, or the given one. Returns the bin's probability.
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

// Density of the descent in a bin with this probability, per steradian.
float descent_density(float probability) {
    return probability * bin_density();
}

// Density over a diffuse lobe, per steradian: the descent's density mixed with the cosine's.
float product_density(Guide guide, vec3 wi, float of_descent) {
    float of_cosine = max(dot(wi, guide.n), 0.0) * INV_PI;
    return mix(of_descent, of_cosine, guide.bsdf_share);
}

// Samples by descent. The result is `own`, a direction that the caller has drawn, with the probability `own_share`, and
// always where `follows` is false. The density is that of the descent for either direction. All lanes take the same
// path through the code: lanes that could skip a part would wait for the others.
GuidedSample sample_product(vec4 u, Guide guide, bool follows, float own_share, vec3 own) {
    bool by_guide = follows && u.x >= own_share;
    u.x = min((u.x - own_share) / (1.0 - own_share), 1.0 - 1.0 / 16777216.0);
    uvec2 at = bin_coordinates(direction_bin(own));
    float density = descent_density(descend(guide, by_guide, at, u.xy));
    uint bin = at.y * DIRECTION_RESOLUTION + at.x;
    vec3 wi = by_guide ? map_to_sphere(bin_point(bin, DIRECTION_RESOLUTION, u.zw)) : own;
    return GuidedSample(wi, density, bin, bin_radiance(guide, bin), by_guide ? 1u : 0u, false);
}

// Density of the descent in a direction, per steradian.
float pdf_product(Guide guide, vec3 wi) {
    uvec2 at = bin_coordinates(direction_bin(wi));
    return descent_density(descend(guide, false, at, vec2(0.0)));
}

#endif
