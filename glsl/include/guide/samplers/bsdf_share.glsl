// The share of samples that a surface's own scattering function keeps where a guide descends (the BSDF sampling fraction): fixed,
// or what the cell has learned.
#ifndef BSDF_SHARE_GLSL
#define BSDF_SHARE_GLSL
#include "guide/grid/radiance_grid.glsl"
#include "shared/guide.glsl"

// A cell's shares: of diffuse lobes, and of scattering functions that are guided as a whole.
const uint SHARE_OF_LOBES = 0u;
const uint SHARE_OF_WHOLES = 1u;

bool learns_share() {
    return SHARES_AT != 0u;
}

uint share_index(uint cell, uint which) {
    return cell * SHARES_PER_CELL + which;
}

// In the table of radiance, after the bins of all cells: the share, two sums that it is learned from, and the number of samples
// in these.
uint share_word(uint share, uint word) {
    return SHARES_AT + SHARE_WORDS * share + word;
}

float bsdf_share(uint cell, uint which) {
    if (learns_share()) return radiance(share_word(share_index(cell, which), 0u));
    if (SAMPLER == SAMPLER_QUADTREE) return 0.5;
    return EPSILON > 0.0 ? EPSILON : 0.25;
}

#endif
