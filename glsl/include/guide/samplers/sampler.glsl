// Questions about the sampler. No other file names SAMPLER: all ask these questions. The functions that draw for each sampler
// are chosen in guided_direction.glsl.
#ifndef SAMPLER_GLSL
#define SAMPLER_GLSL
#include "shared/variant.glsl"

// Whether a guide is learned and followed. Without one, all directions come from the BSDF.
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

// Whether the sampler is the paper's plain rejection, which takes the least uniform share.
bool is_plain_rejection() {
    return SAMPLER == SAMPLER_REJECTION;
}

// Samplers that draw by a descent: bit 1 << sampler for each. Their samples are mixed with the surface's own samples.
const uint DESCENDING_SAMPLERS = (1u << SAMPLER_PRODUCT) | (1u << SAMPLER_QUADTREE);

bool descends() {
    return (DESCENDING_SAMPLERS & (1u << SAMPLER)) != 0u;
}

#endif
