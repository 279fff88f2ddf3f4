// Layout of the trees that product.glsl descends, one per cell and one per normal bin. Below the 4 x 4 blocks of the map, a
// tree has the nodes of its middle level, if it has one, a node per block; then the last level's, a node per 4 x 4 bins. The
// weights of a node's parts are sixteen 8-bit floats.
#ifndef TREE_GLSL
#define TREE_GLSL
#include "shared/variant.glsl"

bool has_middle_level() {
    return DIRECTION_RESOLUTION != 16u;
}

// Nodes of the last level along each side of a node of the middle level.
uint middle_parts() {
    return DIRECTION_RESOLUTION / 16u;
}

// Nodes of the last level along each side of the map.
uint last_level_side() {
    return DIRECTION_RESOLUTION / 4u;
}

uint middle_node_count() {
    return has_middle_level() ? 16u : 0u;
}

uint nodes_per_tree() {
    return middle_node_count() + last_level_side() * last_level_side();
}

// The weights of a node of the middle level: where it has 2 x 2 parts only, of those.
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
