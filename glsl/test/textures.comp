// Looks up a texture at one point per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "geometry/bvh.glsl"
#include "texture/textures.glsl"

struct TextureInput {
    uint index;
    vec2 uv;
    vec3 position;
    vec3 normal;
    vec3 shading_normal;
    vec3 incoming;
    vec3 dp_du;
    vec3 dp_dv;
};

struct TextureOutput {
    vec4 color;
    vec2 gradient;
};

layout(scalar, set = 0, binding = 20) readonly buffer TextureInputs { TextureInput texture_inputs[]; };
layout(scalar, set = 0, binding = 21) writeonly buffer TextureOutputs { TextureOutput texture_outputs[]; };

void main() {
    TextureInput i = texture_inputs[gl_GlobalInvocationID.x];
    TexturePoint at = TexturePoint(i.uv, i.position, i.normal, i.shading_normal, i.incoming);
    texture_outputs[gl_GlobalInvocationID.x] =
        TextureOutput(sample_texture(i.index, at), height_gradient(i.index, at, i.dp_du, i.dp_dv));
}
