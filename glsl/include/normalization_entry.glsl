// From a cell's radiance to the factors of its rejection sampler.
#ifndef NORMALIZATION_ENTRY_GLSL
#define NORMALIZATION_ENTRY_GLSL
#include "constants.glsl"
#include "normalization_grid.glsl"
#include "radiance_grid.glsl"

// x^n by squaring: exact to a few roundings, which a driver's pow is not.
float power(float x, uint n) {
    float result = 1.0;
    while (n != 0u) {
        if ((n & 1u) != 0u) result *= x;
        x *= x;
        n >>= 1u;
    }
    return result;
}

// Eq. 8: the uniform share that spends the fewest proposals on a target whose mean over maximum is c.
float optimal_uniform_share(float c) {
    return max((1.0 - 2.0 * c) / (2.0 - 2.0 * min(c, 0.5)), MIN_UNIFORM_SHARE);
}

// The factors for a target of this normalizer (integral over the hemisphere) and this upper bound.
NormalizationEntry normalization_factors(float normalizer, float bound) {
    float c = min(normalizer / (2.0 * PI * bound), 1.0);
    float e = optimal_uniform_share(c);
    float all_fail = power(1.0 - c, MAX_TRIES);
    NormalizationEntry entry;
    entry.guide_scale = (1.0 - e) * (1.0 - all_fail) / normalizer;
    entry.uniform_density = (e + (1.0 - e) * all_fail) * INV_TWO_PI;
    entry.acceptance_scale = 1.0 / bound;
    entry.uniform_share = e;
    return entry;
}

NormalizationEntry normalize_cell(uint cell, uint normal_bin) {
    float normalizer = 0.0;
    float bound = 0.0;
    for (uint bin = 0u; bin < direction_bin_count(); ++bin) {
        CosineIntegral cosine = cosine_integral(bin, normal_bin);
        float bin_radiance = radiance(radiance_index(cell, bin));
        normalizer += bin_radiance * cosine.integral;
        bound = max(bound, bin_radiance * cosine.maximum);
    }
    return normalization_factors(normalizer, bound);
}

#endif
