// Measures the memory bandwidth of a device: copies words from one buffer to another, neighboring words side by side.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/variant.glsl"

struct TestPush {
    uint rounds;  // number of words that each invocation copies
    uint stride;  // distance of these words: the number of invocations
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) readonly buffer From { uint from_words[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer To { uint to_words[]; };

void main() {
    for (uint i = 0u; i < push.rounds; ++i) {
        uint index = i * push.stride + gl_GlobalInvocationID.x;
        to_words[index] = from_words[index];
    }
}
