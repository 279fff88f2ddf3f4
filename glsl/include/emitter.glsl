// What surfaces emit.
#ifndef EMITTER_GLSL
#define EMITTER_GLSL
#include "frame.glsl"
#include "surface.glsl"

// Emission of a surface in direction `wo`: from the side its shading normal points to.
vec3 surface_emission(Surface s, vec3 wo) {
    if (s.emitter == NONE || dot(s.shading_normal, wo) <= 0.0) return vec3(0.0);
    return uintBitsToFloat(fetch_emitter_texel(s.emitter).xyz);
}

#endif
