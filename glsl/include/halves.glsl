// What adaptive sampling keeps of a film page: which tiles are sampled, how noisy each is, and of every pixel the sum of one
// half of its samples. Halves are independent, which samples of one set are not: they part after every two sets (Dammertz et
// al. 2010, "A Hierarchical Automatic Stopping Condition for Monte Carlo Global Illumination", has two buffers likewise).
#ifndef HALVES_GLSL
#define HALVES_GLSL
#include "frame.glsl"
#include "sobol.glsl"

const uint TILE_PIXELS = 64u;

struct FilmHalf {
    vec3 sum;
    uint sample_count;
};

const FilmHalf NO_HALF = FilmHalf(vec3(0.0), 0u);

uint tile_count() {
    return adaptive_count() / (TILE_PIXELS + 1u);
}

// The pixel, in tile order, that stands at this place of the pixels to be sampled.
uint sampled_pixel(uint place) {
    if (ADAPTIVE) return load_adaptive(place / TILE_PIXELS).x * TILE_PIXELS + place % TILE_PIXELS;
    return place;
}

bool is_of_half(uint sample_index) {
    return (sample_index / SET_SIZE) % 2u == 0u;
}

FilmHalf load_half(uint pixel) {
    uvec4 bits = load_adaptive(tile_count() + pixel);
    return FilmHalf(uintBitsToFloat(bits.xyz), bits.w);
}

void store_half(uint pixel, FilmHalf h) {
    store_adaptive(tile_count() + pixel, uvec4(floatBitsToUint(h.sum), h.sample_count));
}

// Sums over the pixels of a tile: of squared relative errors, and of mean radiance. Which tiles are sampled is to be said anew.
void store_tile_noise(uint tile, float squared_error, float radiance) {
    store_adaptive(tile, uvec4(0u, floatBitsToUint(squared_error), floatBitsToUint(radiance), 0u));
}

// Of the mean of all of a pixel's samples: by how much both halves differ. Nothing where one of them is empty.
float variance_by_halves(FilmRadiance all, FilmHalf first) {
    float count = float(all.sample_count);
    float first_count = float(first.sample_count);
    float second_count = count - first_count;
    if (first_count == 0.0 || second_count == 0.0) return 0.0;
    vec3 difference = first.sum / first_count - (all.mean * count - first.sum) / second_count;
    return mean_rgb(difference * difference) * (first_count * second_count / (count * count));
}

#endif
