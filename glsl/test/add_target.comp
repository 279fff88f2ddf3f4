// Adds given targets to the sums of given bins. Each invocation handles every n-th target, n being the number of
// invocations.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/grid/radiance_grid.glsl"

struct TargetInput {
    uint index;
    float target;
    float u;
};

struct TestPush {
    uint target_count;
    float target_limit;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) readonly buffer TargetInputs { TargetInput target_inputs[]; };

void main() {
    uint stride = WORKGROUP_SIZE * gl_NumWorkGroups.x;
    for (uint i = gl_GlobalInvocationID.x; i < push.target_count; i += stride) {
        TargetInput t = target_inputs[i];
        add_target(t.index, fixed_point(t.target, push.target_limit, t.u));
    }
}
