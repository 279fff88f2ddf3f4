// Memory layout of the trees that product.glsl descends: one tree per cell and one per normal bin. The trees start
// below the 4 x 4 blocks of the map. A tree holds first the nodes of the middle level, if there is one: a node per
// block. Then it holds the nodes of the last level: a node per 4 x 4 bins. The weights of a node's sixteen parts are
// 8-bit floats.
#ifndef TREE_GLSL
#define TREE_GLSL
#include "shared/variant.glsl"

bool has_middle_level() {
    return DIRECTION_RESOLUTION != 16u;
}

// Number of last-level nodes along each side of a middle-level node.
uint middle_parts() {
    return DIRECTION_RESOLUTION / 16u;
}

// Number of last-level nodes along each side of the map.
uint last_level_side() {
    return DIRECTION_RESOLUTION / 4u;
}

uint middle_node_count() {
    return has_middle_level() ? 16u : 0u;
}

uint nodes_per_tree() {
    return middle_node_count() + last_level_side() * last_level_side();
}

// Weights of a node of the middle level. A node with only 2 x 2 parts uses the first 2 x 2 weights.
mat4 middle_weights(mat4 weights) {
    if (middle_parts() != 2u) return weights;
    return mat4(vec4(weights[0].xy, 0.0, 0.0), vec4(weights[1].xy, 0.0, 0.0), vec4(0.0), vec4(0.0));
}

uint middle_node(uvec2 at) {
    return at.y * 4u + at.x;
}

uint last_node(uvec2 at) {
    return middle_node_count() + at.y * last_level_side() + at.x;
}

#endif
