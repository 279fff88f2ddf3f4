// Slice of a film page: the pixels that one dispatch samples.
#ifndef SLICE_GLSL
#define SLICE_GLSL
#include "film/frame.glsl"
#include "film/halves.glsl"
#include "shared/film.glsl"

// Weights of a dispatch's samples relative to the samples before them.
struct DispatchWeights {
    float of_sample;
    float lost_weight;   // number of earlier samples minus the sum of their weights
    float lost_samples;  // number of earlier samples minus their effective number
};

// Slice of a film page, and the range of samples that the dispatch adds.
struct TracePush {
    uint first_workgroup;    // first workgroup of the slice, counted over the page's tiles that are sampled
    uint workgroup_count;
    uint workgroup_stride;   // coprime to the count; spreads neighboring workgroups over the device
    uint page_first_pixel;   // number of pixels, in tile order, before this film page
    DispatchWeights weights;
    uint first_sample;
    uint sample_count;
    uint first_of_sets;      // index of a sample; no set of samples starts before it
    uint first_tile;         // first tile of the page that this device traces
    uint tile_stride;        // distance between two tiles that this device traces
};

// Pixel of the window for an index in tile order. Tiles follow each other row by row, and so do the pixels within a
// tile.
uvec2 tile_order_pixel(uint index) {
    uint tiles_per_row = (scene().window_size.x + (TILE_SIDE - 1u)) / TILE_SIDE;
    uint tile = index / TILE_PIXELS;
    uint within = index % TILE_PIXELS;
    return uvec2(tile % tiles_per_row, tile / tiles_per_row) * TILE_SIDE + uvec2(within % TILE_SIDE, within / TILE_SIDE);
}

// Index within the film page, in tile order, of the pixel of a lane of the slice's workgroup.
uint pixel_of_slice(TracePush slice, uint workgroup, uint lane) {
    uint spread = slice.first_workgroup + (workgroup * slice.workgroup_stride) % slice.workgroup_count;
    uint place = spread * WORKGROUP_SIZE + lane;
    uint tile = slice.first_tile + (place / TILE_PIXELS) * slice.tile_stride;
    return sampled_pixel(tile * TILE_PIXELS + place % TILE_PIXELS);
}

#endif
