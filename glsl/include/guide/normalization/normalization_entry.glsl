// Computes, from a cell's radiance, the factors of its sampler.
#ifndef NORMALIZATION_ENTRY_GLSL
#define NORMALIZATION_ENTRY_GLSL
#include "math/constants.glsl"
#include "guide/normalization/normalization_grid.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "guide/samplers/sampler.glsl"

// x^n by repeated squaring. The error is a few roundings; a driver's pow can be less exact.
float power(float x, uint n) {
    float result = 1.0;
    while (n != 0u) {
        if ((n & 1u) != 0u) result *= x;
        x *= x;
        n >>= 1u;
    }
    return result;
}

// Whether division by a sum is safe in single precision. A guide with a sum that is too small or too large leaves all
// samples to the uniform share.
bool is_usable(float sum) {
    return sum > 1.0e-36 && sum < 1.0e38;
}

// Optimal uniform share of Eq. 8: it needs the fewest proposals. `c` is the mean of the sampled function over its
// maximum.
float optimal_uniform_share(float c) {
    return max((1.0 - 2.0 * c) / (2.0 - 2.0 * min(c, 0.5)), 0.0);
}

// Share e of the rejection samplers.
float uniform_share(float c) {
    if (is_plain_rejection()) return MIN_UNIFORM_SHARE;
    if (EPSILON > 0.0) return EPSILON;
    return max(optimal_uniform_share(c), mixes_acceptances() ? 0.0 : MIN_UNIFORM_SHARE);
}

// Factors of a rejection sampler. `normalizer` is the integral of the sampled function over the hemisphere, `bound` its
// upper bound.
NormalizationEntry rejection_factors(float normalizer, float bound) {
    bool usable = is_usable(normalizer) && 2.0 * PI * bound < MAX_DISTANCE;
    float c = usable ? min(normalizer / (2.0 * PI * bound), 1.0) : 0.0;
    float e = usable ? uniform_share(c) : 1.0;
    float accepted = mixes_acceptances() ? c + (1.0 - c) * e : c;
    float all_fail = power(1.0 - accepted, MAX_TRIES);
    float unconditional = mixes_acceptances() ? MIN_UNIFORM_SHARE : e;
    float guided = (1.0 - unconditional) * (1.0 - all_fail);
    NormalizationEntry entry;
    if (mixes_acceptances()) {
        entry.guide_scale = guided * INV_TWO_PI / accepted;
        entry.acceptance_scale = usable ? (1.0 - e) / bound : 0.0;
    } else {
        entry.guide_scale = usable ? guided / normalizer : 0.0;
        entry.acceptance_scale = usable ? 1.0 / bound : 0.0;
    }
    entry.uniform_density = (unconditional + (1.0 - unconditional) * all_fail) * INV_TWO_PI;
    entry.uniform_share = e;
    return entry;
}

// Factors of a sampler that draws a bin in proportion to its share of `total`, and a uniform direction within the bin.
NormalizationEntry inversion_factors(float total) {
    float e = is_usable(total) ? MIN_UNIFORM_SHARE : 1.0;
    NormalizationEntry entry;
    entry.guide_scale = is_usable(total) ? (1.0 - e) * bin_density() / total : 0.0;
    entry.uniform_density = e * INV_TWO_PI;
    entry.acceptance_scale = is_usable(total) ? 1.0 / total : 0.0;
    entry.uniform_share = e;
    return entry;
}

// Factors of sphere-inversion, where shares are counted in SHARE_UNITS. `total` is the sum of the bins' radiance.
NormalizationEntry sphere_inversion_factors(float total) {
    NormalizationEntry entry = inversion_factors(float(SHARE_UNITS));
    return is_usable(total) ? entry : NormalizationEntry(0.0, INV_TWO_PI, 0.0, 1.0);
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
    if (is_hemisphere_inversion()) return inversion_factors(normalizer);
    return rejection_factors(normalizer, bound);
}

#endif
