// Emission of surfaces.
#ifndef EMITTER_GLSL
#define EMITTER_GLSL
#include "film/frame.glsl"
#include "geometry/surface.glsl"
#include "texture/pattern.glsl"

// Share of the radiance that leaves in the direction `wo`. Between the borders of the cone and of its beam, it rises smoothly with the
// cosine, as in Blender.
float share_of_cone(ConeRecord cone, vec3 wo) {
    float x = clamp(dot(cone.slope, wo) + cone.offset, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

// Emitted radiance of a surface in direction `wo`. A surface emits on the side of its shading normal.
vec3 surface_emission(Surface s, vec3 wo) {
    if (s.emitter == NONE || dot(s.shading_normal, wo) <= 0.0) return vec3(0.0);
    EmitterRecord emitter = load_emitter(s.emitter);
    if (has_feature(FEATURE_TEXTURED_EMITTERS)) {
        uint index = emitter.texture_index;
        vec3 color = sample_pattern(index == NONE ? 0u : index, s.uv).rgb;
        if (index != NONE) emitter.radiance *= color;
    }
    if (has_feature(FEATURE_CONES) && scene().first_cone != NONE) emitter.radiance *= share_of_cone(load_cone(s.emitter), wo);
    return emitter.radiance;
}

#endif
