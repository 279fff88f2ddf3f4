// Computes the frame that a bump map or normal map tilts, for one surface per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "geometry/relief.glsl"
#include "shared/variant.glsl"

struct ReliefInput {
    vec3 dp_du;
    vec3 dp_dv;
    vec3 geometric_normal;
    vec2 gradient;
    vec3 color;
    uint is_bump;
    vec3 wo;
    vec3 wi;
};

struct ReliefOutput {
    mat3 frame;
    vec3 wo;  // in the tilted frame
    vec3 wi;
    float shadowing;
    vec3 raised;  // the normal that the color encodes, as raised for `wo`
};

layout(scalar, set = 0, binding = 10) readonly buffer ReliefInputs { ReliefInput relief_inputs[]; };
layout(scalar, set = 0, binding = 11) writeonly buffer ReliefOutputs { ReliefOutput relief_outputs[]; };

void main() {
    ReliefInput i = relief_inputs[gl_GlobalInvocationID.x];
    vec3 bumped = bump_normal(i.dp_du, i.dp_dv, i.gradient, i.geometric_normal);
    ReliefOutput o;
    o.frame = relief_frame(i.is_bump != 0u ? bumped : mapped_normal(i.color), i.wo);
    o.wo = i.wo * o.frame;
    o.wi = i.wi * o.frame;
    o.shadowing = relief_shadowing(upright_in(o.frame), o.wi);
    vec3 surface_normal = vec3(0.0, 0.0, i.wo.z < 0.0 ? -1.0 : 1.0);
    o.raised = raised_normal(normalize(mapped_normal(i.color)), surface_normal, i.wo);
    relief_outputs[gl_GlobalInvocationID.x] = o;
}
