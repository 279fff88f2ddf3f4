// What adaptive sampling keeps of a film page: which tiles are sampled, how noisy each is, and of every pixel the mean of one
// half of its samples. Halves are independent, which samples of one set are not: they have whole sets in turns (Dammertz et al.
// 2010, "A Hierarchical Automatic Stopping Condition for Monte Carlo Global Illumination", has two buffers likewise).
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

// The pixel, in tile order, that stands at this place of the pixels to be sampled.
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

// Sums over the pixels of a tile: of squared relative errors, and of mean radiance. Which tiles are sampled is to be said anew.
void store_tile_noise(uint tile, float squared_error, float radiance) {
    store_scratch(tile, uvec4(0u, floatBitsToUint(squared_error), floatBitsToUint(radiance), 0u));
}

FilmHalf merge_halves(FilmHalf a, FilmHalf b) {
    uint sample_count = a.sample_count + b.sample_count;
    float share = float(b.sample_count) / float(max(sample_count, 1u));
    return FilmHalf(a.mean + (b.mean - a.mean) * share, sample_count);
}

// The samples that are not of the first half.
FilmHalf other_half(FilmRadiance all, FilmHalf first) {
    uint sample_count = all.sample_count - first.sample_count;
    float ratio = float(first.sample_count) / float(max(sample_count, 1u));
    return FilmHalf(all.mean + (all.mean - first.mean) * ratio, sample_count);
}

// The error of the mean of both, by how much they differ: the expectation of its square is the variance of that mean. Nothing
// where one of them is empty.
vec3 error_by_halves(FilmHalf a, FilmHalf b) {
    float product = float(a.sample_count) * float(b.sample_count);
    return (a.mean - b.mean) * (sqrt(product) / float(max(a.sample_count + b.sample_count, 1u)));
}

#endif
