// Draws a light as seen from a point, and evaluates what a ray hits in that direction and in a given one. Each
// invocation handles one point.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "light/light.glsl"
#include "geometry/traverse.glsl"

struct LightInput {
    vec3 from;
    vec3 direction;
};

// Result of a ray: the radiance that it meets, and the density, per steradian, with which sample_light draws its
// direction.
struct Met {
    vec3 radiance;
    float pdf;
};

struct LightOutput {
    vec3 wi;
    vec3 target;
    vec3 radiance;
    float pdf;
    uint infinite;
    uint delta;
    Met along_wi;
    Met along_direction;
};

struct TestPush {
    uint seed;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 20) readonly buffer LightInputs { LightInput light_inputs[]; };
layout(scalar, set = 0, binding = 21) writeonly buffer LightOutputs { LightOutput light_outputs[]; };

Met meet(vec3 from, vec3 direction) {
    bool overrun = false;
    Ray ray = Ray(from, direction, MAX_DISTANCE);
    Hit hit = traverse(ray, false, overrun);
    if (hit.primitive == NONE) return Met(environment_radiance(direction), pdf_light_at_environment(direction, 0u));
    Surface s = surface_at(ray, hit);
    return Met(surface_emission(s, -direction), pdf_light_at_surface(hit.primitive, hit.instance, s, from, 0u));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    LightInput i = light_inputs[index];
    RandomKey key = random_key(uvec2(index, 0u), 0u, 0u, 0u, push.seed);
    LightSample s = sample_light(key, 1u, i.from, choose_light(key, 1u, 0u));
    light_outputs[index] = LightOutput(s.wi, s.target, s.radiance, s.pdf, s.infinite ? 1u : 0u, s.delta ? 1u : 0u,
                                       meet(i.from, s.wi), meet(i.from, i.direction));
}
