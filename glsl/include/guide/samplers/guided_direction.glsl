// Switch over the samplers: the functions that find a guide's cell, draw from the guide and give its density.
#ifndef GUIDED_DIRECTION_GLSL
#define GUIDED_DIRECTION_GLSL
#include "guide/grid/cells.glsl"
#include "guide/samplers/hemisphere_inversion.glsl"
#include "guide/samplers/product.glsl"
#include "guide/samplers/quadtree.glsl"
#include "guide/samplers/rejection_mix.glsl"
#include "guide/samplers/sampler.glsl"
#include "guide/samplers/sphere_inversion.glsl"

// Guide's cell at a point: a cell of the grids, or the first node of the point's quadtree.
uint cell_at(vec3 position) {
    if (!uses_guide()) return 0u;
    return is_quadtree() ? quadtree_at(position) : grid_cell(position);
}

// Samples a filled guide, for the samplers that mix with a uniform share. `choice` in [0, 1) selects the uniform share
// or the guide. The samplers that descend mix with the surface's own sampler instead; sample_descent serves them.
GuidedSample sample_guide(RandomKey key, uint vertex, float choice, Guide guide) {
    if (is_sphere_inversion()) return sample_sphere_inversion(key, vertex, choice, guide);
    if (is_hemisphere_inversion()) return sample_hemisphere_inversion(key, vertex, choice, guide);
    return sample_rejection_mix(key, vertex, choice, guide);
}

// Samples a guide, for the samplers that descend. The result is `own`, a direction that the caller has drawn, with the
// probability `own_share`, and always where `follows` is false. The density is that of the descent.
GuidedSample sample_descent(vec4 u, Guide guide, bool follows, float own_share, vec3 own) {
    if (is_quadtree()) return sample_quadtree(u, guide, follows, own_share, own);
    return sample_product(u, guide, follows, own_share, own);
}

// Density of the descent in a direction, per steradian.
float pdf_descent(Guide guide, vec3 wi) {
    return is_quadtree() ? pdf_quadtree(guide, wi) : pdf_product(guide, wi);
}

// Density of `wi` under a guide, per steradian. For samplers that descend, it is the density of the mixture with the
// cosine.
float pdf_guide(Guide guide, vec3 wi) {
    if (is_sphere_inversion()) return pdf_sphere_inversion(guide, wi);
    if (is_hemisphere_inversion()) return pdf_hemisphere_inversion(guide, wi);
    if (descends()) return product_density(guide, wi, pdf_descent(guide, wi));
    return pdf_rejection_mix(guide, wi);
}

#endif
