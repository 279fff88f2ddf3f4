// Switch over the samplers that follow a guide.
#ifndef GUIDED_DIRECTION_GLSL
#define GUIDED_DIRECTION_GLSL
#include "guide/samplers/hemisphere_inversion.glsl"
#include "guide/samplers/product.glsl"
#include "guide/samplers/quadtree.glsl"
#include "guide/samplers/rejection_mix.glsl"
#include "guide/samplers/sphere_inversion.glsl"

// Samples a filled guide, for the samplers that mix with a uniform share. `choice` in [0, 1) selects the uniform share
// or the guide. The samplers that descend mix with the surface's own sampler instead; sample_descent serves them.
GuidedSample sample_guide(RandomKey key, uint vertex, float choice, Guide guide) {
    if (SAMPLER == SAMPLER_SPHERE_INVERSION) return sample_sphere_inversion(key, vertex, choice, guide);
    if (SAMPLER == SAMPLER_HEMISPHERE_INVERSION) return sample_hemisphere_inversion(key, vertex, choice, guide);
    return sample_rejection_mix(key, vertex, choice, guide);
}

// Samples a guide, for the samplers that descend. The result is `own`, a direction that the caller has drawn, with the
// probability `own_share`, and always where `follows` is false. The density is that of the descent.
GuidedSample sample_descent(vec4 u, Guide guide, bool follows, float own_share, vec3 own) {
    if (SAMPLER == SAMPLER_QUADTREE) return sample_quadtree(u, guide, follows, own_share, own);
    return sample_product(u, guide, follows, own_share, own);
}

// Density of the descent in a direction, per steradian.
float pdf_descent(Guide guide, vec3 wi) {
    return SAMPLER == SAMPLER_QUADTREE ? pdf_quadtree(guide, wi) : pdf_product(guide, wi);
}

// Density of `wi` under a guide, per steradian. For samplers that descend, it is the density of the mixture with the
// cosine.
float pdf_guide(Guide guide, vec3 wi) {
    if (SAMPLER == SAMPLER_SPHERE_INVERSION) return pdf_sphere_inversion(guide, wi);
    if (SAMPLER == SAMPLER_HEMISPHERE_INVERSION) return pdf_hemisphere_inversion(guide, wi);
    if (descends()) return product_density(guide, wi, pdf_descent(guide, wi));
    return pdf_rejection_mix(guide, wi);
}

#endif
