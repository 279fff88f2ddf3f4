// Data of a film page for adaptive sampling: the tiles to sample, the noise of each tile, and for each pixel the mean
// of one half of its samples. The halves must be independent. Samples of one set depend on each other, so whole sets
// alternate between the two halves. Dammertz et al. 2010 ("A Hierarchical Automatic Stopping Condition for Monte Carlo
// Global Illumination") use two buffers, too.
#ifndef HALVES_GLSL
#define HALVES_GLSL
#include "film/frame.glsl"
#include "random/sobol.glsl"
#include "shared/film.glsl"

struct FilmHalf {
    vec3 mean;
    uint sample_count;
};

const FilmHalf NO_HALF = FilmHalf(vec3(0.0), 0u);

uint tile_count() {
    return scratch_count() / (TILE_PIXELS + 1u);
}

// Index, in tile order, of the pixel at this position among the pixels to sample.
uint sampled_pixel(uint place) {
    if (ADAPTIVE) return load_scratch(place / TILE_PIXELS).x * TILE_PIXELS + place % TILE_PIXELS;
    return place;
}

bool is_of_half(uint sample_index) {
    return (sample_index / SET_SIZE) % 2u == 0u;
}

FilmHalf load_half(uint pixel) {
    uvec4 bits = load_scratch(tile_count() + pixel);
    return FilmHalf(uintBitsToFloat(bits.xyz), bits.w);
}

void store_half(uint pixel, FilmHalf h) {
    store_scratch(tile_count() + pixel, uvec4(floatBitsToUint(h.mean), h.sample_count));
}

// Stores a tile's noise: the sums over its pixels of squared relative errors and of mean radiance. The first word,
// which selects the tiles to sample, is cleared and must be written again.
void store_tile_noise(uint tile, float squared_error, float radiance) {
    store_scratch(tile, uvec4(0u, floatBitsToUint(squared_error), floatBitsToUint(radiance), 0u));
}

FilmHalf merge_halves(FilmHalf a, FilmHalf b) {
    uint sample_count = a.sample_count + b.sample_count;
    float share = float(b.sample_count) / float(max(sample_count, 1u));
    return FilmHalf(a.mean + (b.mean - a.mean) * share, sample_count);
}

// Second half of the samples: all samples without the first half.
FilmHalf other_half(FilmRadiance all, FilmHalf first) {
    uint sample_count = all.sample_count - first.sample_count;
    float ratio = float(first.sample_count) / float(max(sample_count, 1u));
    return FilmHalf(all.mean + (all.mean - first.mean) * ratio, sample_count);
}

// Estimated error of the mean of both halves, from the halves' difference. The expectation of its square is the
// variance of that mean. The result is zero where one half is empty.
vec3 error_by_halves(FilmHalf a, FilmHalf b) {
    float product = float(a.sample_count) * float(b.sample_count);
    return (a.mean - b.mean) * (sqrt(product) / float(max(a.sample_count + b.sample_count, 1u)));
}

#endif
