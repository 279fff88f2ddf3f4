// What the grids know about the directions at a point, and what a sampler makes of it.
#ifndef GUIDE_GLSL
#define GUIDE_GLSL
#include "guide/samplers/bsdf_share.glsl"
#include "math/direction_map.glsl"
#include "guide/normalization/normalization_grid.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "math/small_floats.glsl"

struct Guide {
    uint cell;  // of the grids; with quadtrees, the first node of a tree
    uint normal_bin;
    vec3 nb;  // representative normal of that bin
    vec3 n;   // the true normal
    uvec4 record;  // what the normalization grid holds here, or the quadtree's first node; all zeros: there is no guide yet
    NormalizationEntry entry;  // the same, of the samplers whose record is one
    float bsdf_share;  // what the surface's own scattering function keeps, of the samplers that descend
};

struct GuidedSample {
    vec3 wi;
    float pdf;      // per steradian; of no meaning where `wi` lies below the surface
    uint bin;       // direction bin that `wi` lies in, or what stands for it in a quadtree
    float radiance; // L of that bin
    uint tries;
    bool overrun;   // the driver ended the loop before it came to its end
};

const NormalizationEntry NO_ENTRY = NormalizationEntry(0.0, 0.0, 0.0, 0.0);
const Guide NO_GUIDE = Guide(0u, 0u, vec3(0.0), vec3(0.0), uvec4(0u), NO_ENTRY, 1.0);

// Bit 1 << sampler of those that draw by a descent, which is mixed with the surface's own samples.
const uint DESCENDING_SAMPLERS = (1u << SAMPLER_PRODUCT) | (1u << SAMPLER_QUADTREE);

bool descends() {
    return (DESCENDING_SAMPLERS & (1u << SAMPLER)) != 0u;
}

// `which` of the cell's shares is the surface's.
Guide guide_of(uint cell, vec3 n, uint which) {
    float share = bsdf_share(cell, which);
    if (SAMPLER == SAMPLER_QUADTREE) return Guide(cell, 0u, n, n, radiance_node(cell), NO_ENTRY, share);
    uint bin = normal_bin(n);
    uvec4 record = normalization_record(normalization_index(cell, bin));
    return Guide(cell, bin, representative_normal(bin), n, record, entry_of(record), share);
}

bool is_filled(Guide guide) {
    return any(notEqual(guide.record, uvec4(0u)));
}

// Asks for a guide here from the next update on. Quadtrees are all kept.
void mark_guide(Guide guide) {
    if (SAMPLER != SAMPLER_QUADTREE) mark_entry(normalization_index(guide.cell, guide.normal_bin));
}

float bin_radiance(Guide guide, uint bin) {
    return radiance(radiance_index(guide.cell, bin));
}

// Mean of L over the hemisphere, which the product sampler's records hold as irradiance.
float mean_radiance(Guide guide) {
    return INV_PI * unpack_scalar(guide.record);
}

// Density of the uniform share: there is none below the surface.
float uniform_density(Guide guide, vec3 wi) {
    return dot(wi, guide.n) > 0.0 ? guide.entry.uniform_density : 0.0;
}

#endif
