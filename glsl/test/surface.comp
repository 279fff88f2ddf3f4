// Finds the surface that a ray hits, and a ray that leaves the surface in the direction of the ray's origin. Each
// invocation handles one ray.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "geometry/surface.glsl"
#include "geometry/traverse.glsl"

struct SurfaceInput {
    Ray ray;
    uint any_hit;
};

struct SurfaceOutput {
    Surface surface;
    mat3 frame;
    Ray leaving;
    Hit hit;
};

layout(scalar, set = 0, binding = 0) readonly buffer SurfaceInputs { SurfaceInput surface_inputs[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer SurfaceOutputs { SurfaceOutput surface_outputs[]; };

void main() {
    Ray ray = surface_inputs[gl_GlobalInvocationID.x].ray;
    bool overrun = false;
    SurfaceOutput o;
    o.hit = traverse(ray, false, overrun);
    o.surface = Surface(vec3(0.0), 0.0, 0.0, vec3(0.0), vec3(0.0), NONE, NONE, vec2(0.0), vec3(0.0), vec3(0.0));
    o.frame = mat3(0.0);
    o.leaving = ray;
    if (o.hit.primitive != NONE) {
        o.surface = surface_at(ray, o.hit);
        o.frame = shading_frame(o.surface);
        o.leaving = leave_surface(o.surface, -ray.direction);
    }
    surface_outputs[gl_GlobalInvocationID.x] = o;
}
