// Evaluates the map of directions and its bins in both directions, for one point of the square and one direction per
// invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "math/direction_map.glsl"

struct MapInput {
    vec2 p;
    vec3 w;
    uint bin;
};

struct MapOutput {
    vec3 w_of_p;
    vec2 p_of_w;
    vec2 antipode_of_p;
    vec3 w_of_antipode;
    vec2 p_of_w_of_p;
    vec3 center;
    uint bin_of_p;
    uint bin_of_w;
    uint bin_of_center;
};

layout(scalar, set = 0, binding = 0) readonly buffer MapInputs { MapInput map_inputs[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer MapOutputs { MapOutput map_outputs[]; };

void main() {
    MapInput i = map_inputs[gl_GlobalInvocationID.x];
    MapOutput o;
    o.w_of_p = map_to_sphere(i.p);
    o.p_of_w = sphere_to_map(i.w);
    o.antipode_of_p = map_antipode(i.p);
    o.w_of_antipode = map_to_sphere(o.antipode_of_p);
    o.p_of_w_of_p = sphere_to_map(o.w_of_p);
    o.center = bin_center(i.bin);
    o.bin_of_p = square_bin(i.p, DIRECTION_RESOLUTION);
    o.bin_of_w = direction_bin(i.w);
    o.bin_of_center = direction_bin(o.center);
    map_outputs[gl_GlobalInvocationID.x] = o;
}
