// Memory layout of the spatial tree and its quadtrees (Mueller, Gross and Novak 2017). All data lie in the nodes of set
// 2, each of four words, in this order:
//     quadtree nodes | leaves of the spatial tree | nodes of the spatial tree, four to four words | number of leaves - 1
// A second copy of this layout follows, in which a refinement builds. It has a plan for each leaf in place of the
// spatial tree's nodes. A buffer of zeros is a spatial tree with one leaf, whose quadtree has one node and has learned
// nothing.
#ifndef QUADTREE_NODES_GLSL
#define QUADTREE_NODES_GLSL
#include "shared/guide.glsl"
#include "shared/variant.glsl"

// Maximum number of levels of a quadtree. The smallest square has a side of 2^-12 of the map's side.
const uint QUADTREE_LEVELS = 12u;
// Maximum number of levels of the spatial tree. Single precision does not resolve more.
const uint SPATIAL_LEVELS = 60u;

uint leaf_limit() {
    return QUADTREE_NODES / NODES_PER_LEAF;
}

uint leaf_place(uint leaf) {
    return QUADTREE_NODES + leaf;
}

// Index of the four words that hold a node of the spatial tree, together with three other nodes.
uint spatial_place(uint node) {
    return QUADTREE_NODES + leaf_limit() + node / 4u;
}

uint leaf_count_place() {
    return spatial_place(2u * leaf_limit() + 3u);
}

// Index at which a refinement builds a node.
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

// Flag in a node of the spatial tree. If it is set, the other bits are the index of the first of two neighboring child
// nodes. Otherwise the node is the index of the first node of a leaf's quadtree.
const uint SPATIAL_SPLIT = 0x80000000u;

bool is_split(uint spatial_node) {
    return (spatial_node & SPATIAL_SPLIT) != 0u;
}

// Node of a quadtree, for a square of the map of directions. It is all zeros where nothing has been learned.
struct QuadtreeNode {
    vec3 shares;  // share of the lower half; share of the left quarter in the lower half, and in the upper half
    uint links;   // links to the nodes of the quarters
};

// Layout of the links, from the lowest bit: four bits that say which quarters have a node, in the order lower left,
// lower right, upper left, upper right; a bit that is always set; four bits for the node's level; and in the remaining
// bits the index of the first child node, relative to the tree's first node. The child nodes are consecutive.
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

// Index of a quarter's node, relative to the tree's first node.
uint linked_node(uint links, uint quarter) {
    return (links >> FIRST_LINK_SHIFT) + uint(bitCount(links & ((1u << quarter) - 1u)));
}

uint level_of(uint links) {
    return links >> LEVEL_SHIFT & LEVEL_MASK;
}

uint links_to(uint first, uint level, uint quarters) {
    return first << FIRST_LINK_SHIFT | level << LEVEL_SHIFT | LEARNED_LINK | quarters;
}

// Share of `part` in the sum of both; 1/2 if the sum is 0.
float share_of(float part, float other) {
    float sum = part + other;
    return sum > 0.0 ? part / sum : 0.5;
}

// Words of the node of a square whose quarters have this flux; zeros if there is no flux.
uvec4 quadtree_words(vec4 flux, uint links) {
    float lower = flux.x + flux.y;
    float upper = flux.z + flux.w;
    vec3 shares = vec3(share_of(lower, upper), share_of(flux.x, flux.y), share_of(flux.z, flux.w));
    return lower + upper > 0.0 ? uvec4(floatBitsToUint(shares), links) : uvec4(0u);
}

#endif
