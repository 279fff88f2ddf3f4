// Measures the random-read throughput of a device: fetches whole nodes at addresses that do not depend on earlier
// reads.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "geometry/bvh.glsl"
#include "shared/variant.glsl"

struct TestPush {
    uint rounds;  // one round fetches one node
    uint node_count;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) writeonly buffer Results { uint results[]; };

void main() {
    uint state = gl_GlobalInvocationID.x * 0x9e3779b9u + 1u;
    uvec4 sum = uvec4(0u);
    for (uint i = 0u; i < push.rounds; ++i) {
        state = state * 1664525u + 1013904223u;
        uint node = min(uint(float(state >> 8u) / 16777216.0 * float(push.node_count)), push.node_count - 1u);
        sum ^= fetch_node(node, 0u) ^ fetch_node(node, 1u) ^ fetch_node(node, 2u);
        sum ^= fetch_node(node, 3u) ^ fetch_node(node, 4u);
    }
    results[gl_GlobalInvocationID.x] = sum.x ^ sum.y ^ sum.z ^ sum.w;
}
