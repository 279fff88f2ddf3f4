// Evaluates the random numbers of one given key per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "random/random.glsl"
#include "shared/variant.glsl"

struct DrawInput {
    uvec2 film_pixel;
    uint film_width;
    uint sample_index;
    uint first_of_set;
    uint seed;
    uint vertex;
    uint block;
};

struct DrawOutput {
    uvec4 bits;
    vec4 floats;
    float leftover;
    float stream[4];
    uvec4 camera;
};

layout(scalar, set = 0, binding = 0) readonly buffer DrawInputs { DrawInput draw_inputs[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer DrawOutputs { DrawOutput draw_outputs[]; };

void main() {
    DrawInput i = draw_inputs[gl_GlobalInvocationID.x];
    RandomKey key = random_key(i.film_pixel, i.film_width, i.sample_index, i.first_of_set, i.seed);
    DrawOutput o;
    o.bits = random_bits(key, i.vertex, i.block);
    o.floats = unit_floats(o.bits);
    o.leftover = leftover_float(o.bits);
    RandomStream stream = random_stream(key, i.vertex, i.block);
    for (uint k = 0u; k < 4u; ++k) o.stream[k] = next_random(stream);
    o.camera = camera_bits(key);
    draw_outputs[gl_GlobalInvocationID.x] = o;
}
