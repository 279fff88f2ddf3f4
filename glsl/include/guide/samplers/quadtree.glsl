// The sampler of Mueller, Gross and Novak 2017, "Practical Path Guiding for Efficient Light-Transport Simulation": a binary
// tree of the scene's space, and in each of its leaves a quadtree of directions, whose squares are drawn in proportion to the
// flux that has arrived through them, whatever the normal. It is mixed with the cosine, or a whole scattering function, half
// and half: one-sample multiple importance sampling.
#ifndef QUADTREE_GLSL
#define QUADTREE_GLSL
#include "film/frame.glsl"
#include "guide/samplers/guide.glsl"
#include "guide/samplers/quadtree_nodes.glsl"
#include "random/random.glsl"

uint spatial_node(uint node) {
    return radiance_node(spatial_place(node))[node & 3u];
}

// First node of the quadtree of a point of the scene. The tree halves the least cube from the scene's lower corner that holds
// it, along the x-, y- and z-axis in turn.
uint quadtree_at(vec3 position) {
    // There is one cell, which is all of the scene.
    vec3 per_unit = scene().cells_per_unit;
    vec3 p = (position - scene().bounds_min) * min(per_unit.x, min(per_unit.y, per_unit.z));
    p = clamp(p, vec3(0.0), vec3(1.0 - 1.0 / 16777216.0));
    uint node = spatial_node(0u);
    for (uint level = 0u; is_split(node) && level < SPATIAL_LEVELS; ++level) {
        float twice = 2.0 * p.x;
        node = spatial_node((node & ~SPATIAL_SPLIT) + uint(twice));
        p = vec3(p.yz, fract(twice));
    }
    return node;
}

// A square of the map that has no node.
struct QuadtreeLeaf {
    uint quarter;  // its index among the quarters of all nodes
    vec2 corner;   // of the unit square
    float side;
    float density; // over the unit square
};

// Takes the upper of two halves, or the lower with the probability `share`: as `u` chooses, or where `at` lies. Multiplies
// `density` by the probability over that of even halves; what is left of `u` serves for the next choice.
bool takes_upper(bool choose, float share, float at, inout float u, inout float density) {
    bool upper = choose ? u >= share : at >= 0.5;
    float probability = upper ? 1.0 - share : share;
    u = min((upper ? u - share : u) / max(probability, 1.0e-30), 1.0 - 1.0 / 16777216.0);
    density *= 2.0 * probability;
    return upper;
}

// One of a node's quarters, likewise; makes `leaf` its square.
uint take_quarter(QuadtreeNode node, bool choose, inout vec2 at, inout vec2 u, inout QuadtreeLeaf leaf) {
    bool upper = takes_upper(choose, node.shares.x, at.y, u.y, leaf.density);
    bool right = takes_upper(choose, upper ? node.shares.z : node.shares.y, at.x, u.x, leaf.density);
    leaf.side *= 0.5;
    leaf.corner += leaf.side * vec2(right, upper);
    at = fract(2.0 * at);
    return (upper ? 2u : 0u) + (right ? 1u : 0u);
}

// Goes down to a leaf: the one that `u` chooses, or the one that holds the point `at` of the unit square.
QuadtreeLeaf descend_quadtree(Guide guide, bool choose, vec2 at, vec2 u) {
    QuadtreeLeaf leaf = QuadtreeLeaf(0u, vec2(0.0), 1.0, 1.0);
    QuadtreeNode node = quadtree_node_of(guide.record);
    uint place = guide.cell;
    uint quarter = take_quarter(node, choose, at, u, leaf);
    for (uint level = 1u; has_node(node.links, quarter) && level < QUADTREE_LEVELS; ++level) {
        place = guide.cell + linked_node(node.links, quarter);
        node = quadtree_node_of(radiance_node(place));
        quarter = take_quarter(node, choose, at, u, leaf);
    }
    leaf.quarter = 4u * place + quarter;
    return leaf;
}

// A direction's point of the unit square.
vec2 square_of(vec3 wi) {
    return clamp(0.5 * sphere_to_map(wi) + 0.5, vec2(0.0), vec2(1.0 - 1.0 / 16777216.0));
}

// Per steradian.
float quadtree_density(QuadtreeLeaf leaf) {
    return leaf.density * (0.5 * INV_TWO_PI);
}

// A direction by descent, or with the probability `own_share`, and where `follows` is false, `own`, which the caller has drawn.
// With the descent's density of either; `bin` is the quarter that learns.
GuidedSample sample_quadtree(vec4 u, Guide guide, bool follows, float own_share, vec3 own) {
    bool by_guide = follows && u.x >= own_share;
    u.x = min((u.x - own_share) / (1.0 - own_share), 1.0 - 1.0 / 16777216.0);
    QuadtreeLeaf leaf = descend_quadtree(guide, by_guide, square_of(own), u.xy);
    vec3 wi = by_guide ? map_to_sphere(2.0 * (leaf.corner + leaf.side * u.zw) - 1.0) : own;
    return GuidedSample(wi, quadtree_density(leaf), leaf.quarter, 0.0, by_guide ? 1u : 0u, false);
}

// The descent's density of a direction.
float pdf_quadtree(Guide guide, vec3 wi) {
    return quadtree_density(descend_quadtree(guide, false, square_of(wi), vec2(0.0)));
}

#endif
