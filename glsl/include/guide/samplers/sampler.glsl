// The samplers: what tells one from another. This file alone names SAMPLER; all others ask its questions. Which function draws
// for which sampler stands in guided_direction.glsl.
#ifndef SAMPLER_GLSL
#define SAMPLER_GLSL
#include "shared/variant.glsl"

// A guide is learned and followed. Without one, all directions come from the BSDF.
bool uses_guide() {
    return SAMPLER != SAMPLER_BSDF;
}

bool is_product() {
    return SAMPLER == SAMPLER_PRODUCT;
}

bool is_quadtree() {
    return SAMPLER == SAMPLER_QUADTREE;
}

bool is_sphere_inversion() {
    return SAMPLER == SAMPLER_SPHERE_INVERSION;
}

bool is_hemisphere_inversion() {
    return SAMPLER == SAMPLER_HEMISPHERE_INVERSION;
}

// The paper's plain rejection, which takes the least uniform share.
bool is_plain_rejection() {
    return SAMPLER == SAMPLER_REJECTION;
}

// Bit 1 << sampler of those that draw by a descent, which is mixed with the surface's own samples.
const uint DESCENDING_SAMPLERS = (1u << SAMPLER_PRODUCT) | (1u << SAMPLER_QUADTREE);

bool descends() {
    return (DESCENDING_SAMPLERS & (1u << SAMPLER)) != 0u;
}

#endif
