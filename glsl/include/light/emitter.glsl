// Emission of surfaces.
#ifndef EMITTER_GLSL
#define EMITTER_GLSL
#include "film/frame.glsl"
#include "geometry/surface.glsl"
#include "texture/pattern.glsl"

// Emitted radiance of a surface in direction `wo`. A surface emits on the side of its shading normal.
vec3 surface_emission(Surface s, vec3 wo) {
    if (s.emitter == NONE || dot(s.shading_normal, wo) <= 0.0) return vec3(0.0);
    EmitterRecord emitter = load_emitter(s.emitter);
    if (has_feature(FEATURE_TEXTURED_EMITTERS)) {
        uint index = emitter.texture_index;
        vec3 color = sample_pattern(index == NONE ? 0u : index, s.uv).rgb;
        if (index != NONE) emitter.radiance *= color;
    }
    return emitter.radiance;
}

#endif
