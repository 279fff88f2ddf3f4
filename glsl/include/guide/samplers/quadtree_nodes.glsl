// Layout of the spatial tree and its quadtrees (Mueller, Gross and Novak 2017), all in the nodes of set 2, each four words:
//     quadtree nodes | leaves of the spatial tree | nodes of the spatial tree, four to four words | number of leaves - 1
// and then the same anew, into which a refinement builds, with a plan for every leaf in place of the spatial tree's nodes.
// Zeros all over are a spatial tree of one leaf, whose quadtree has one node and has learned nothing.
#ifndef QUADTREE_NODES_GLSL
#define QUADTREE_NODES_GLSL
#include "shared/guide.glsl"
#include "shared/variant.glsl"

// Most levels of nodes of a quadtree: the finest square has a side of 2^-12 of the map's.
const uint QUADTREE_LEVELS = 12u;
// Most levels of the spatial tree: as many as single precision tells apart.
const uint SPATIAL_LEVELS = 60u;

uint leaf_limit() {
    return QUADTREE_NODES / NODES_PER_LEAF;
}

uint leaf_place(uint leaf) {
    return QUADTREE_NODES + leaf;
}

// Of four nodes of the spatial tree.
uint spatial_place(uint node) {
    return QUADTREE_NODES + leaf_limit() + node / 4u;
}

uint leaf_count_place() {
    return spatial_place(2u * leaf_limit() + 3u);
}

// Where a refinement builds a node.
uint draft_place(uint node) {
    return leaf_count_place() + 1u + node;
}

uint draft_leaf_place(uint leaf) {
    return draft_place(QUADTREE_NODES + leaf);
}

uint plan_place(uint leaf) {
    return draft_place(QUADTREE_NODES + leaf_limit() + leaf);
}

uint draft_leaf_count_place() {
    return draft_place(QUADTREE_NODES + 2u * leaf_limit());
}

// A node of the spatial tree: its two halves stand side by side from here on; or the first node of a leaf's quadtree.
const uint SPATIAL_SPLIT = 0x80000000u;

bool is_split(uint spatial_node) {
    return (spatial_node & SPATIAL_SPLIT) != 0u;
}

// A node of a quadtree, of a square of the map of directions. All zeros where nothing has been learned.
struct QuadtreeNode {
    vec3 shares;  // of the lower half in all; of the left quarter in the lower half, and in the upper
    uint links;   // to the nodes of its quarters
};

// Links: a bit for each quarter that has a node, in the order lower left, lower right, upper left, upper right; a bit that is
// set; four of the node's level; and above them the first of the nodes, which follow each other, counted from the tree's first.
const uint LEARNED_LINK = 16u;
const uint LEVEL_SHIFT = 5u;
const uint LEVEL_MASK = 15u;
const uint FIRST_LINK_SHIFT = 9u;

QuadtreeNode quadtree_node_of(uvec4 words) {
    return QuadtreeNode(uintBitsToFloat(words.xyz), words.w);
}

bool has_node(uint links, uint quarter) {
    return (links >> quarter & 1u) != 0u;
}

// The quarter's node, counted from the tree's first.
uint linked_node(uint links, uint quarter) {
    return (links >> FIRST_LINK_SHIFT) + uint(bitCount(links & ((1u << quarter) - 1u)));
}

uint level_of(uint links) {
    return links >> LEVEL_SHIFT & LEVEL_MASK;
}

uint links_to(uint first, uint level, uint quarters) {
    return first << FIRST_LINK_SHIFT | level << LEVEL_SHIFT | LEARNED_LINK | quarters;
}

// The share of `part` in both.
float share_of(float part, float other) {
    float sum = part + other;
    return sum > 0.0 ? part / sum : 0.5;
}

// The node of a square whose quarters have that flux; zeros where they have none.
uvec4 quadtree_words(vec4 flux, uint links) {
    float lower = flux.x + flux.y;
    float upper = flux.z + flux.w;
    vec3 shares = vec3(share_of(lower, upper), share_of(flux.x, flux.y), share_of(flux.z, flux.w));
    return lower + upper > 0.0 ? uvec4(floatBitsToUint(shares), links) : uvec4(0u);
}

#endif
