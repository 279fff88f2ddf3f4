// Traces one ray per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef RAY_QUERIES
#extension GL_EXT_ray_query : require
#endif
#include "geometry/traverse.glsl"

struct TraceInput {
    Ray ray;
    uint any_hit;
};

struct TraceOutput {
    Hit hit;
    uint overrun;
};

layout(scalar, set = 0, binding = 0) readonly buffer TraceInputs { TraceInput trace_inputs[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer TraceOutputs { TraceOutput trace_outputs[]; };

void main() {
    TraceInput i = trace_inputs[gl_GlobalInvocationID.x];
    bool overrun = false;
    Hit hit = traverse(i.ray, i.any_hit != 0u, overrun);
    trace_outputs[gl_GlobalInvocationID.x] = TraceOutput(hit, overrun ? 1u : 0u);
}
