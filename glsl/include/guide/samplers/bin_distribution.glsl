// Cumulative distribution that sphere_inversion.glsl inverts: a prefix sum over a cell's bins, computed by one
// workgroup.
#ifndef BIN_DISTRIBUTION_GLSL
#define BIN_DISTRIBUTION_GLSL
#include "guide/grid/radiance_grid.glsl"

shared float lane_radiance[WORKGROUP_SIZE];

// Sum of the radiance of all lanes before this one (x) and of all lanes (y). All lanes add in the same order, so that
// the bins of a lane never begin before those of the preceding lane end.
vec2 sums_over_lanes(float own) {
    lane_radiance[gl_LocalInvocationIndex] = own;
    barrier();
    vec2 sums = vec2(0.0);
    for (uint lane = 0u; lane < WORKGROUP_SIZE; ++lane) {
        if (lane < gl_LocalInvocationIndex) sums.x += lane_radiance[lane];
        sums.y += lane_radiance[lane];
    }
    return sums;
}

// Stores the ends of all bins of a cell. Returns the sum of the radiance of the cell's bins.
float store_bin_ends(uint cell) {
    uint bins_per_lane = (direction_bin_count() + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    uint first = min(gl_LocalInvocationIndex * bins_per_lane, direction_bin_count());
    uint last = min(first + bins_per_lane, direction_bin_count());
    float own = 0.0;
    for (uint bin = first; bin < last; ++bin) own += radiance(radiance_index(cell, bin));
    vec2 sums = sums_over_lanes(own);
    float total = sums.y;
    float sum = sums.x;
    float most = sums.x + own;
    for (uint bin = first; bin < last; ++bin) {
        sum = bin + 1u == last ? most : min(sum + radiance(radiance_index(cell, bin)), most);
        float share = total > 0.0 ? min(sum / total, 1.0) : 1.0;
        // The last bin ends at SHARE_UNITS exactly, however the device rounds the quotient.
        bool is_last = bin + 1u == direction_bin_count();
        store_bin_end(radiance_index(cell, bin), is_last ? SHARE_UNITS : uint(share * float(SHARE_UNITS)));
    }
    return total;
}

#endif
