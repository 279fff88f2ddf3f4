// Computes the camera ray for one film position and one point of the lens's square per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "film/camera.glsl"

layout(scalar, set = 0, binding = 10) readonly buffer Positions { vec4 positions[]; };
layout(scalar, set = 0, binding = 11) writeonly buffer CameraRays { Ray camera_rays[]; };

vec4[3] camera_rows() {
    return scene().world_from_camera;
}

void main() {
    vec4 position = positions[gl_GlobalInvocationID.x];
    camera_rays[gl_GlobalInvocationID.x] = camera_ray(position.xy, position.zw);
}
