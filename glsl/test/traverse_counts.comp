// Traces one ray per invocation as traverse.comp does, and counts the nodes and primitives that it fetches.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "geometry/bvh.glsl"

struct TraceCounts {
    uint nodes;
    uint primitives;
    uint overrun;
};

TraceCounts counts;

uvec4 count_node(uint node, uint texel) {
    if (texel == 0u) ++counts.nodes;
    return fetch_node(node, texel);
}

PrimitiveRecord count_primitive(uint primitive) {
    ++counts.primitives;
    return load_primitive(primitive);
}

// The two macros make traverse.glsl fetch through the counting functions above.
#define fetch_node count_node
#define load_primitive count_primitive
#include "geometry/traverse.glsl"

struct TraceInput {
    Ray ray;
    uint any_hit;
};

layout(scalar, set = 0, binding = 0) readonly buffer TraceInputs { TraceInput trace_inputs[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer TraceOutputs { TraceCounts trace_outputs[]; };

void main() {
    TraceInput i = trace_inputs[gl_GlobalInvocationID.x];
    counts = TraceCounts(0u, 0u, 0u);
    bool overrun = false;
    traverse(i.ray, i.any_hit != 0u, overrun);
    counts.overrun = overrun ? 1u : 0u;
    trace_outputs[gl_GlobalInvocationID.x] = counts;
}
