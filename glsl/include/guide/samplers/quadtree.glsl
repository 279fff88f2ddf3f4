// Sampler quadtree of Mueller, Gross and Novak 2017, "Practical Path Guiding for Efficient Light-Transport Simulation".
// A binary tree divides the scene's space. Each leaf has a quadtree of directions, whose squares are drawn in
// proportion to the flux that has arrived through them, regardless of the normal. The sampler is mixed half and half
// with the cosine or with a whole BSDF, by one-sample multiple importance sampling.
#ifndef QUADTREE_GLSL
#define QUADTREE_GLSL
#include "film/frame.glsl"
#include "guide/samplers/guide.glsl"
#include "guide/samplers/quadtree_nodes.glsl"
#include "random/random.glsl"

uint spatial_node(uint node) {
    return radiance_node(spatial_place(node))[node & 3u];
}

// First node of the quadtree for a point of the scene. The binary tree halves, along x, y and z in turn, the smallest
// cube that starts at the scene's lower corner and contains the scene.
uint quadtree_at(vec3 position) {
    // The quadtree sampler uses a grid of one cell, so cells_per_unit is the inverse of the scene's extent.
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

// Leaf of a quadtree: a square of the map that has no node.
struct QuadtreeLeaf {
    uint quarter;  // index among the quarters of all nodes
    vec2 corner;   // position in the unit square
    float side;
    float density; // density with respect to the area of the unit square
};

// Selects the upper of two halves, or the lower one with the probability `share`. Where `choose` holds, `u` decides;
// otherwise the position `at` does. Multiplies `density` by the half's probability over 1/2. Rescales `u` for the next
// choice.
bool takes_upper(bool choose, float share, float at, inout float u, inout float density) {
    bool upper = choose ? u >= share : at >= 0.5;
    float probability = upper ? 1.0 - share : share;
    u = min((upper ? u - share : u) / max(probability, 1.0e-30), 1.0 - 1.0 / 16777216.0);
    density *= 2.0 * probability;
    return upper;
}

// Selects one of a node's quarters in the same way, and makes `leaf` the quarter's square.
uint take_quarter(QuadtreeNode node, bool choose, inout vec2 at, inout vec2 u, inout QuadtreeLeaf leaf) {
    bool upper = takes_upper(choose, node.shares.x, at.y, u.y, leaf.density);
    bool right = takes_upper(choose, upper ? node.shares.z : node.shares.y, at.x, u.x, leaf.density);
    leaf.side *= 0.5;
    leaf.corner += leaf.side * vec2(right, upper);
    at = fract(2.0 * at);
    return (upper ? 2u : 0u) + (right ? 1u : 0u);
}

// Descends to a leaf: the one that `u` draws, or the one that contains the point `at` of the unit square.
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

// Point of the unit square for a direction.
vec2 square_of(vec3 wi) {
    return clamp(0.5 * sphere_to_map(wi) + 0.5, vec2(0.0), vec2(1.0 - 1.0 / 16777216.0));
}

// Density in a leaf, per steradian.
float quadtree_density(QuadtreeLeaf leaf) {
    return leaf.density * (0.5 * INV_TWO_PI);
}

// Samples by descent. The result is `own`, a direction that the caller has drawn, with the probability `own_share`, and
// always where `follows` is false. The density is that of the descent for either direction. `bin` is the quarter that
// learns.
GuidedSample sample_quadtree(vec4 u, Guide guide, bool follows, float own_share, vec3 own) {
    bool by_guide = follows && u.x >= own_share;
    u.x = min((u.x - own_share) / (1.0 - own_share), 1.0 - 1.0 / 16777216.0);
    QuadtreeLeaf leaf = descend_quadtree(guide, by_guide, square_of(own), u.xy);
    vec3 wi = by_guide ? map_to_sphere(2.0 * (leaf.corner + leaf.side * u.zw) - 1.0) : own;
    return GuidedSample(wi, quadtree_density(leaf), leaf.quarter, 0.0, by_guide ? 1u : 0u, false);
}

// Density of the descent in a direction, per steradian.
float pdf_quadtree(Guide guide, vec3 wi) {
    return quadtree_density(descend_quadtree(guide, false, square_of(wi), vec2(0.0)));
}

#endif
