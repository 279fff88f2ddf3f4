// Light selection by what a cell has learned. The lights are divided into LIGHT_GROUPS groups, and every cell of the
// guide has learned how much light each group brings to its surfaces. A group is drawn by a descent through the cell's light
// tree: one node of sixteen weights, or a node of sixteen sums and sixteen nodes below it. Within a group, the lights have
// fixed probabilities in proportion to their power.
//
// The weights are small floats (small_floats.glsl). For any weights, the probability is exactly that of the draws.
#ifndef LIGHT_SELECTION_GLSL
#define LIGHT_SELECTION_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "guide/samplers/parts.glsl"
#include "guide/samplers/tree.glsl"
#include "math/small_floats.glsl"
#include "shared/guide.glsl"

// Whether cells learn which lights to draw. Otherwise all vertices draw lights in proportion to their power.
bool learns_lights() {
    return LIGHT_GROUPS != 0u;
}

bool has_two_light_levels() {
    return LIGHT_GROUPS != 16u;
}

uint group_nodes_per_cell() {
    if (has_two_light_levels()) return 1u + LIGHT_GROUPS / 16u;
    return 1u;
}

// Index among the radiance nodes of a node of a cell's group tree. The group trees follow the radiance trees of all cells.
uint group_node(uint cell, uint node) {
    return scene().cell_count * nodes_per_tree() + cell * group_nodes_per_cell() + node;
}

// Draws one of sixteen parts by the weights of a node, or keeps the given part. Returns the part's probability.
float choose_sixteenth(uint node, bool choose, inout uint part, inout vec2 u) {
    uvec2 at = uvec2(part % 4u, part / 4u);
    float probability = choose_part(unpack_weights_8(radiance_node(node)), choose, at, u);
    part = at.y * 4u + at.x;
    return probability;
}

// Descends to a group of lights: the one that `u` and, on the lower level, `u_lower` draw, or the given one. Returns the group's
// probability.
float descend_to_group(uint cell, bool choose, inout uint group, vec2 u, vec2 u_lower) {
    if (!has_two_light_levels()) return choose_sixteenth(group_node(cell, 0u), choose, group, u);
    uint upper = group / 16u;
    uint lower = group % 16u;
    float probability = choose_sixteenth(group_node(cell, 0u), choose, upper, u);
    probability *= choose_sixteenth(group_node(cell, 1u + upper), choose, lower, u_lower);
    group = upper * 16u + lower;
    return probability;
}

float group_probability(uint cell, uint group) {
    return descend_to_group(cell, false, group, vec2(0.0), vec2(0.0));
}

#endif
