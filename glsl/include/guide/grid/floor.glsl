// Floor of the sampled radiance: bins are sampled as if they held at least this radiance, so that every direction keeps
// a positive density.
#ifndef FLOOR_GLSL
#define FLOOR_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"

// Floor of a bin, as a share of the mean of its cell.
const float FLOOR_SHARE = 1.0 / 64.0;
// Absolute floor of a bin, as a share of the largest target. It makes a cell without radiance uniform.
const float FLOOR_ABSOLUTE = 1.0e-12;

// Floor of the bins of a cell whose estimates have the sum `sum`.
float least_radiance(float sum) {
    float cell_mean = sum / float(direction_bin_count());
    return max(cell_mean * FLOOR_SHARE, scene().target_limit * FLOOR_ABSOLUTE);
}

#endif
