// Measures the noise of each tile of a film page. One workgroup handles one tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "film/halves.glsl"

// Push constants: tiles of the dispatch.
struct JudgePush {
    uint first_tile;  // tile of the first workgroup, within the film page
};
layout(push_constant, scalar) uniform Push { JudgePush push; };

shared vec3 error_of_pixel[TILE_PIXELS];
shared float radiance_of_pixel[TILE_PIXELS];
shared float radiance_of_halves[TILE_PIXELS];  // the smaller mean of the two halves
shared uint is_sampled[TILE_PIXELS];  // 0 outside the window

void load_pixels(uint first_pixel) {
    for (uint i = gl_LocalInvocationIndex; i < TILE_PIXELS; i += WORKGROUP_SIZE) {
        FilmRadiance radiance = load_film_radiance(first_pixel + i);
        FilmHalf first = load_half(first_pixel + i);
        FilmHalf other = other_half(radiance, first);
        error_of_pixel[i] = error_by_halves(first, other);
        radiance_of_pixel[i] = mean_rgb(radiance.mean);
        radiance_of_halves[i] = min(mean_rgb(first.mean), mean_rgb(other.mean));
        is_sampled[i] = min(radiance.sample_count, 1u);
    }
}

// Squared error of a pixel relative to its radiance, or to the mean radiance of the tile if that is larger. The smaller
// mean of the two halves stands for the pixel's radiance. The edge of a lamp is thus measured relative to its own
// light, but a single bright sample, which only one half has, is not measured relative to itself.
float squared_error(uint i, float radiance_of_tile) {
    if (error_of_pixel[i] == vec3(0.0)) return 0.0;
    vec3 error = error_of_pixel[i] / max(radiance_of_halves[i], radiance_of_tile);
    return mean_rgb(error * error);
}

void main() {
    uint tile = push.first_tile + gl_WorkGroupID.x;
    load_pixels(tile * TILE_PIXELS);
    barrier();
    // One invocation adds all numbers in order, because a sum of floats depends on the order.
    if (gl_LocalInvocationIndex == 0u) {
        float radiance = 0.0;
        uint pixels = 0u;
        for (uint i = 0u; i < TILE_PIXELS; ++i) {
            radiance += radiance_of_pixel[i];
            pixels += is_sampled[i];
        }
        float error = 0.0;
        for (uint i = 0u; i < TILE_PIXELS; ++i) error += squared_error(i, radiance / float(max(pixels, 1u)));
        store_tile_noise(tile, error, radiance);
    }
}
