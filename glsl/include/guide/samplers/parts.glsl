// Selection of one of the 4 x 4 parts of a square, by weight or by position.
//
// The code selects by mix(), because nested conditional expressions become branches. SwiftShader's compiler used tens
// of gigabytes of memory for those branches.
#ifndef PARTS_GLSL
#define PARTS_GLSL

float component(vec4 v, uint i) {
    vec2 pair = mix(v.xy, v.zw, bvec2((i & 2u) != 0u));
    return mix(pair.x, pair.y, (i & 1u) != 0u);
}

float sum_of(vec4 v) {
    return (v.x + v.y) + (v.z + v.w);
}

// Selects one of four by weight. `u` in [0, 1) is rescaled, so that it is uniform again.
uint choose_of_four(vec4 weights, float sum, inout float u) {
    float end0 = weights.x;
    float end1 = end0 + weights.y;
    float end2 = end1 + weights.z;
    float t = u * sum;
    bool past0 = t >= end0;
    bool past1 = t >= end1;
    bool past2 = t >= end2;
    float start = mix(mix(mix(0.0, end0, past0), end1, past1), end2, past2);
    float weight = mix(mix(mix(weights.x, weights.y, past0), weights.z, past1), weights.w, past2);
    u = clamp((t - start) / weight, 0.0, 1.0 - 1.0 / 16777216.0);
    return uint(past0) + uint(past1) + uint(past2);
}

// Column and row of a part. Where `choose` holds, they are drawn by weights[row][column], the column first; otherwise
// `part` remains as given. Returns the part's share of the weights.
float choose_part(mat4 weights, bool choose, inout uvec2 part, inout vec2 u) {
    vec4 columns = (weights[0] + weights[1]) + (weights[2] + weights[3]);
    float sum = sum_of(columns);
    uint chosen_x = choose_of_four(columns, sum, u.x);
    uint x = choose ? chosen_x : part.x;
    vec4 rows = vec4(component(weights[0], x), component(weights[1], x), component(weights[2], x), component(weights[3], x));
    uint chosen_y = choose_of_four(rows, sum_of(rows), u.y);
    part = uvec2(x, choose ? chosen_y : part.y);
    return component(rows, part.y) / sum;
}

#endif
