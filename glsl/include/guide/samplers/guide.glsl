// Guide at a point: the records of the grids for its cell and normal, and the samples that a sampler draws from them.
#ifndef GUIDE_GLSL
#define GUIDE_GLSL
#include "guide/samplers/bsdf_share.glsl"
#include "guide/samplers/sampler.glsl"
#include "math/direction_map.glsl"
#include "guide/normalization/normalization_grid.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "math/small_floats.glsl"

struct Guide {
    uint cell;  // cell of the grids; with quadtrees, the first node of a tree
    uint normal_bin;
    vec3 nb;  // representative normal of that bin
    vec3 n;   // true normal
    uvec4 record;  // record of the normalization grid, or first node of the quadtree; all zeros: no guide yet
    NormalizationEntry entry;  // the record as an entry, for samplers whose records are entries
    float bsdf_share;  // fraction of samples that the surface's own BSDF draws, for samplers that descend
};

struct GuidedSample {
    vec3 wi;
    float pdf;      // per steradian; undefined where `wi` lies below the surface
    uint bin;       // direction bin of `wi`, or quarter of a quadtree's node
    float radiance; // L of that bin
    uint tries;
    bool overrun;   // whether the driver ended the loop early
};

const NormalizationEntry NO_ENTRY = NormalizationEntry(0.0, 0.0, 0.0, 0.0);
const Guide NO_GUIDE = Guide(0u, 0u, vec3(0.0), vec3(0.0), uvec4(0u), NO_ENTRY, 1.0);

// Guide for a cell and a normal. `which` selects the cell's BSDF share.
Guide guide_of(uint cell, vec3 n, uint which) {
    float share = bsdf_share(cell, which);
    if (is_quadtree()) return Guide(cell, 0u, n, n, radiance_node(cell), NO_ENTRY, share);
    uint bin = normal_bin(n);
    uvec4 record = normalization_record(normalization_index(cell, bin));
    return Guide(cell, bin, representative_normal(bin), n, record, normalization_entry_of(record), share);
}

bool is_filled(Guide guide) {
    return any(notEqual(guide.record, uvec4(0u)));
}

// Requests a guide here from the next update on. Quadtrees need no request, because all of them are kept.
void mark_guide(Guide guide) {
    if (!is_quadtree()) mark_entry(normalization_index(guide.cell, guide.normal_bin));
}

float bin_radiance(Guide guide, uint bin) {
    return radiance(radiance_index(guide.cell, bin));
}

// Mean of L over the hemisphere, weighted by the cosine. The product sampler's records hold it as irradiance.
float mean_radiance(Guide guide) {
    return INV_PI * unpack_scalar(guide.record);
}

// Density of the uniform share, per steradian; zero below the surface.
float uniform_density(Guide guide, vec3 wi) {
    return dot(wi, guide.n) > 0.0 ? guide.entry.uniform_density : 0.0;
}

#endif
