// The pixels that a dispatch samples.
#ifndef SLICE_GLSL
#define SLICE_GLSL
#include "film/frame.glsl"
#include "film/halves.glsl"
#include "shared/film.glsl"

// What a dispatch's samples count for beside those before them.
struct SampleWeights {
    float of_sample;
    float lost_weight;   // by how much the sum of the weights of samples before falls short of their number
    float lost_samples;  // the same of the number of samples of one weight whose mean has the variance of theirs
};

// A slice of a film page and its next samples.
struct PathTracePush {
    uint first_workgroup;    // of the slice, among those of the page's tiles that are sampled
    uint workgroup_count;
    uint workgroup_stride;   // coprime to the count: spreads neighbors over a device that deals out contiguous halves
    uint page_first_pixel;   // pixels (in tile order) before this film page
    SampleWeights weights;
    uint first_sample;
    uint sample_count;
    uint first_of_sets;      // sample; no set of samples reaches back beyond it
};

// Tiles of pixels, row by row, and pixels within a tile likewise.
uvec2 tile_order_pixel(uint index) {
    uint tiles_per_row = (scene().window_size.x + (TILE_SIDE - 1u)) / TILE_SIDE;
    uint tile = index / TILE_PIXELS;
    uint within = index % TILE_PIXELS;
    return uvec2(tile % tiles_per_row, tile / tiles_per_row) * TILE_SIDE + uvec2(within % TILE_SIDE, within / TILE_SIDE);
}

// The page's pixel, in tile order, of a lane of one of the slice's workgroups.
uint pixel_of_slice(PathTracePush slice, uint workgroup, uint lane) {
    uint spread = slice.first_workgroup + (workgroup * slice.workgroup_stride) % slice.workgroup_count;
    return sampled_pixel(spread * WORKGROUP_SIZE + lane);
}

#endif
