// Measures the arithmetic throughput of a device: multiplications and additions in twelve independent chains.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/variant.glsl"

struct TestPush {
    uint rounds;  // one round is 192 operations: eight products and eight sums in each chain
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) writeonly buffer Results { float results[]; };

vec4 multiply_and_add(vec4 x) {
    return x * 0.9999 + 0.125;
}

vec4 eight_times(vec4 x) {
    x = multiply_and_add(multiply_and_add(multiply_and_add(multiply_and_add(x))));
    return multiply_and_add(multiply_and_add(multiply_and_add(multiply_and_add(x))));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    vec4 a = vec4(index) + vec4(0.0, 1.0, 2.0, 3.0), b = a + 4.0, c = a + 8.0;
    for (uint i = 0u; i < push.rounds; ++i) {
        a = eight_times(a);
        b = eight_times(b);
        c = eight_times(c);
    }
    results[index] = dot(a + b + c, vec4(1.0));
}
