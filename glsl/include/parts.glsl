// One of 4 x 4 parts of a square, chosen by weight or given.
#ifndef PARTS_GLSL
#define PARTS_GLSL

float component(vec4 v, uint i) {
    vec2 pair = i < 2u ? v.xy : v.zw;
    return (i & 1u) == 0u ? pair.x : pair.y;
}

float sum_of(vec4 v) {
    return (v.x + v.y) + (v.z + v.w);
}

// One of four by weight. What is left of `u` in [0, 1) is uniform again.
uint choose_of_four(vec4 weights, inout float u) {
    vec3 ends = vec3(weights.x, weights.x + weights.y, 0.0);
    ends.z = ends.y + weights.z;
    float t = u * sum_of(weights);
    uint chosen = (t >= ends.x ? 1u : 0u) + (t >= ends.y ? 1u : 0u) + (t >= ends.z ? 1u : 0u);
    float start = chosen == 0u ? 0.0 : component(vec4(ends, 0.0), chosen - 1u);
    u = clamp((t - start) / component(weights, chosen), 0.0, 1.0 - 1.0 / 16777216.0);
    return chosen;
}

// Column and row of a part: where `choose` holds, by weights[row][column], the column first; else as they are given. Returns
// the part's share of the weights.
float choose_part(mat4 weights, bool choose, inout uvec2 part, inout vec2 u) {
    vec4 columns = (weights[0] + weights[1]) + (weights[2] + weights[3]);
    if (choose) part.x = choose_of_four(columns, u.x);
    uint x = part.x;
    vec4 rows = vec4(component(weights[0], x), component(weights[1], x), component(weights[2], x), component(weights[3], x));
    if (choose) part.y = choose_of_four(rows, u.y);
    return component(rows, part.y) / sum_of(columns);
}

#endif
