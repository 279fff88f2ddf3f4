// Says how noisy each tile of a film page is: a workgroup per tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "halves.glsl"

struct JudgePush {
    uint first_tile;  // of the first workgroup, within the film page
};
layout(push_constant, scalar) uniform Push { JudgePush push; };

shared float variance_of_pixel[TILE_PIXELS];
shared float radiance_of_pixel[TILE_PIXELS];

void load_pixels(uint first_pixel) {
    for (uint i = gl_LocalInvocationIndex; i < TILE_PIXELS; i += WORKGROUP_SIZE) {
        FilmRadiance radiance = load_film_radiance(first_pixel + i);
        variance_of_pixel[i] = variance_by_halves(radiance, load_half(first_pixel + i));
        radiance_of_pixel[i] = mean_rgb(radiance.mean);
    }
}

// Relative to the pixel, or to the mean of its tile where that is more: the edge of a lamp is measured by its own light.
float squared_error(uint i, float radiance_of_tile) {
    float radiance = max(radiance_of_pixel[i], radiance_of_tile);
    return variance_of_pixel[i] == 0.0 ? 0.0 : variance_of_pixel[i] / (radiance * radiance);
}

void main() {
    uint tile = push.first_tile + gl_WorkGroupID.x;
    load_pixels(tile * TILE_PIXELS);
    barrier();
    // By one, one after the other: sums depend on their order.
    if (gl_LocalInvocationIndex == 0u) {
        float radiance = 0.0;
        for (uint i = 0u; i < TILE_PIXELS; ++i) radiance += radiance_of_pixel[i];
        float error = 0.0;
        for (uint i = 0u; i < TILE_PIXELS; ++i) error += squared_error(i, radiance / float(TILE_PIXELS));
        store_tile_noise(tile, error, radiance);
    }
}
