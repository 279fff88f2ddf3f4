// Records of the refinement of quadtrees (refine_quadtrees.comp).
#ifndef QUADTREE_REFINEMENT_GLSL
#define QUADTREE_REFINEMENT_GLSL
#include "math/constants.glsl"
#include "guide/samplers/quadtree_nodes.glsl"
#include "guide/grid/radiance_grid.glsl"

// Share of a tree's flux above which a square of directions gets a node.
const float FLUX_SHARE = 0.01;
// Number of targets above which a leaf of the spatial tree is split: LEAF_TARGETS times sqrt(2^k) in iteration k.
const float LEAF_TARGETS = 1000.0;
// Maximum number of levels that one refinement adds to a leaf.
const uint MOST_SPLITS = 12u;

// Leaf of the spatial tree.
struct Leaf {
    uint spatial_node;
    uint level;
    uint first;  // first node of its quadtree
    uint last;   // last node of its quadtree, relative to the first
};

// Plan of a refinement for a leaf.
struct Plan {
    uint nodes;   // number of nodes of its new quadtree
    uint splits;  // number of levels into which the leaf is split
    uint leaf;    // index of the first leaf that replaces it
    uint first;   // first node of the first new quadtree; the new quadtrees are equal
};

// Node of a new quadtree that is not finished yet.
struct Draft {
    uint origin;  // node of the old quadtree for the same square, or NONE
    float flux;
    uint level;
};

Leaf leaf_of(uvec4 words) {
    return Leaf(words.x, words.y, words.z, words.w);
}

uvec4 leaf_words(Leaf leaf) {
    return uvec4(leaf.spatial_node, leaf.level, leaf.first, leaf.last);
}

uint leaf_count() {
    return radiance_node(leaf_count_place()).x + 1u;
}

Plan plan_of(uint leaf) {
    uvec4 words = radiance_node(plan_place(leaf));
    return Plan(words.x, words.y, words.z, words.w);
}

void store_plan(uint leaf, Plan plan) {
    store_radiance_node(plan_place(leaf), uvec4(plan.nodes, plan.splits, plan.leaf, plan.first));
}

Draft draft_of(uint node) {
    uvec4 words = radiance_node(draft_place(node));
    return Draft(words.x, uintBitsToFloat(words.y), words.z);
}

void store_draft(uint node, Draft draft) {
    store_radiance_node(draft_place(node), uvec4(draft.origin, floatBitsToUint(draft.flux), draft.level, 0u));
}

void store_spatial_node(uint node, uint value) {
    store_radiance_word(spatial_place(node), node & 3u, value);
}

vec4 flux_of_quarters(uint node) {
    uint first = 4u * node;
    return vec4(quarter_flux(first), quarter_flux(first + 1u), quarter_flux(first + 2u), quarter_flux(first + 3u));
}

float sum_of_quarters(vec4 flux) {
    return (flux.x + flux.y) + (flux.z + flux.w);
}

#endif
