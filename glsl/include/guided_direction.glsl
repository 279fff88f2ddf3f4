// The switch over the samplers that follow a guide.
#ifndef GUIDED_DIRECTION_GLSL
#define GUIDED_DIRECTION_GLSL
#include "hemisphere_inversion.glsl"
#include "product.glsl"
#include "rejection_mix.glsl"
#include "sphere_inversion.glsl"

// A direction from a filled guide, of the samplers that are mixed with a uniform share; `choice` in [0, 1) chooses between the
// two. `product` is mixed with the surface's own sampler instead.
GuidedSample sample_guide(RandomKey key, uint vertex, float choice, Guide guide) {
    if (SAMPLER == SAMPLER_SPHERE_INVERSION) return sample_sphere_inversion(key, vertex, choice, guide);
    if (SAMPLER == SAMPLER_HEMISPHERE_INVERSION) return sample_hemisphere_inversion(key, vertex, choice, guide);
    return sample_rejection_mix(key, vertex, choice, guide);
}

// Density of `wi` under sample_guide.
float pdf_guide(Guide guide, vec3 wi) {
    if (SAMPLER == SAMPLER_SPHERE_INVERSION) return pdf_sphere_inversion(guide, wi);
    if (SAMPLER == SAMPLER_HEMISPHERE_INVERSION) return pdf_hemisphere_inversion(guide, wi);
    if (SAMPLER == SAMPLER_PRODUCT) return pdf_product(guide, wi);
    return pdf_rejection_mix(guide, wi);
}

#endif
