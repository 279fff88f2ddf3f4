// The ray through one position of the film per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "camera.glsl"

layout(scalar, set = 0, binding = 10) readonly buffer Positions { vec2 positions[]; };
layout(scalar, set = 0, binding = 11) writeonly buffer CameraRays { Ray camera_rays[]; };

void main() {
    camera_rays[gl_GlobalInvocationID.x] = camera_ray(positions[gl_GlobalInvocationID.x]);
}
