// BSDF share: the fraction of samples that the surface's own BSDF draws, for the samplers that descend. It is fixed, or
// the cell has learned it.
#ifndef BSDF_SHARE_GLSL
#define BSDF_SHARE_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "guide/samplers/sampler.glsl"
#include "math/direction_map.glsl"
#include "shared/guide.glsl"

// Numbers of a cell's shares: one for diffuse lobes, one for BSDFs that are guided as a whole.
const uint SHARE_OF_LOBES = 0u;
const uint SHARE_OF_WHOLES = 1u;

bool learns_share() {
    return LEARNS_SHARE;
}

uint share_index(uint cell, uint which) {
    return cell * SHARES_PER_CELL + which;
}

// Number of the bins of all cells, which shares follow in the radiance table and among the sums of a step. Kernels read it, so that
// scenes with other numbers of cells share them.
uint all_bin_count() {
    return scene().cell_count * direction_bin_count();
}

// Index in the radiance table of a word of a share. A share has four words: the share, the two sums that determine it, and the number of
// samples in the sums.
uint share_word(uint share, uint word) {
    return all_bin_count() + SHARE_WORDS * share + word;
}

float bsdf_share(uint cell, uint which) {
    if (learns_share()) return radiance(share_word(share_index(cell, which), 0u));
    if (is_quadtree()) return 0.5;
    return EPSILON > 0.0 ? EPSILON : 0.25;
}

#endif
