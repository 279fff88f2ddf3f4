// Emission of surfaces.
#ifndef EMITTER_GLSL
#define EMITTER_GLSL
#include "film/frame.glsl"
#include "geometry/surface.glsl"
#include "texture/textures.glsl"

// Emitted radiance of a surface in direction `wo`. A surface emits on the side of its shading normal.
vec3 surface_emission(Surface s, vec3 wo) {
    if (s.emitter == NONE || dot(s.shading_normal, wo) <= 0.0) return vec3(0.0);
    uvec4 record = fetch_emitter_texel(s.emitter);
    vec3 radiance = uintBitsToFloat(record.xyz);
    if (has_feature(FEATURE_TEXTURED_EMITTERS)) {
        vec3 color = sample_texture(record.w == NONE ? 0u : record.w, s.uv).rgb;
        if (record.w != NONE) radiance *= color;
    }
    return radiance;
}

#endif
