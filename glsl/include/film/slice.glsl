// Slice of a film page: the pixels that one dispatch samples.
#ifndef SLICE_GLSL
#define SLICE_GLSL
#include "film/frame.glsl"
#include "film/halves.glsl"
#include "shared/film.glsl"

// Weights of a dispatch's samples relative to the samples before them.
struct DispatchWeights {
    float of_sample;     // weight of each sample of the dispatch
    float lost_weight;   // number of earlier samples minus the sum of their weights
    float lost_samples;  // number of earlier samples minus their effective number
};

// Places of the tiles of a film page that one device traces: in every run of `period` tiles of the film, `width` tiles are its own.
struct TilePlaces {
    uint own_before;  // number of the device's tiles before this page
    uint first;       // Place of the device's first tile of the film, relative to the page's first tile. It wraps.
    uint width;       // number of the device's tiles in a run
    uint period;      // number of tiles of a run
};

// Slice of a film page, and the range of samples that the dispatch adds.
struct TracePush {
    uint first_workgroup;     // first workgroup of the slice, counted over the film page's tiles that are sampled
    uint workgroup_count;     // number of workgroups of the slice
    uint workgroup_stride;    // stride that spreads neighboring workgroups; coprime to their number
    uint page_first_pixel;    // number of pixels, in tile order, before this film page
    DispatchWeights weights;  // weights of the samples relative to the samples before them
    uint first_sample;        // index of the first sample
    uint sample_count;        // number of samples to add
    uint first_of_sets;       // index of a sample before which no set of samples starts
    TilePlaces tiles;         // places of the page's tiles that this device traces
};

// Pixel of the window for an index in tile order. Tiles follow each other row by row, and so do the pixels within a
// tile.
uvec2 tile_order_pixel(uint index) {
    uint tiles_per_row = (scene().window_size.x + (TILE_SIDE - 1u)) / TILE_SIDE;
    uint tile = index / TILE_PIXELS;
    uint within = index % TILE_PIXELS;
    return uvec2(tile % tiles_per_row, tile / tiles_per_row) * TILE_SIDE + uvec2(within % TILE_SIDE, within / TILE_SIDE);
}

// Index within the film page of one of the tiles that this device traces, by its number among them.
uint traced_tile(TilePlaces tiles, uint number) {
    uint own = tiles.own_before + number;
    return own / tiles.width * tiles.period + own % tiles.width + tiles.first;
}

// Index within the film page, in tile order, of the pixel of a lane of the slice's workgroup.
uint pixel_of_slice(TracePush slice, uint workgroup, uint lane) {
    uint spread = slice.first_workgroup + (workgroup * slice.workgroup_stride) % slice.workgroup_count;
    uint place = spread * WORKGROUP_SIZE + lane;
    return sampled_pixel(traced_tile(slice.tiles, place / TILE_PIXELS) * TILE_PIXELS + place % TILE_PIXELS);
}

#endif
