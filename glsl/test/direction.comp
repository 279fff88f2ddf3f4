// Evaluates bases, hemisphere sampling and the reconstruction filter for one input per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "film/camera.glsl"
#include "math/direction.glsl"

struct DirectionInput {
    vec3 n;
    vec2 u;
    float angle;
};

struct DirectionOutput {
    mat3 basis;
    vec3 cosine;
    float pdf;
    vec2 disk;
    vec2 sin_cos;
    vec2 filtered;
};

layout(scalar, set = 0, binding = 10) readonly buffer DirectionInputs { DirectionInput direction_inputs[]; };
layout(scalar, set = 0, binding = 11) writeonly buffer DirectionOutputs { DirectionOutput direction_outputs[]; };

void main() {
    DirectionInput i = direction_inputs[gl_GlobalInvocationID.x];
    DirectionOutput o;
    o.basis = basis_from_normal(i.n);
    o.cosine = sample_cosine_hemisphere(i.u);
    o.pdf = pdf_cosine_hemisphere(o.cosine.z);
    o.disk = concentric_disk(i.u);
    o.sin_cos = sin_cos_quarter(i.angle);
    o.filtered = sample_filter(i.u);
    direction_outputs[gl_GlobalInvocationID.x] = o;
}
