// Records of what camera rays meet first, which the host reads.
#ifndef FIRST_HIT_GLSL
#define FIRST_HIT_GLSL
#include "shared/enums.glsl"

// What a camera ray meets first.
struct FirstHitRecord {
    vec3 position;   // in world space
    uint primitive;  // NONE where the ray meets nothing
    vec3 opening;    // position of the same point of the surface where the shutter opens
    uint instance;   // NONE without one
    vec3 closing;    // and where it closes
    uint material;   // of the surface
    vec2 uv;         // texture coordinates
    vec2 reserved;   // unused
};

const FirstHitRecord NO_HIT = FirstHitRecord(vec3(0.0), NONE, vec3(0.0), NONE, vec3(0.0), NONE, vec2(0.0), vec2(0.0));

#endif
