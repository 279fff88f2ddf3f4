// Sampler hemisphere-inversion: inverts the sums of L(bin) times the integral of cos+(nb, w) over the bin (Kim and Kim
// 2021, Table 2). The sums are computed for each sample, in O(N). With the entry's factors the density is
//     guide_scale * L * integral of the bin + uniform_density * [n.w > 0].
#ifndef HEMISPHERE_INVERSION_GLSL
#define HEMISPHERE_INVERSION_GLSL
#include "guide/samplers/inversion.glsl"
#include "random/random.glsl"

float bin_product(Guide guide, uint bin) {
    return bin_radiance(guide, bin) * cosine_integral(bin, guide.normal_bin).integral;
}

// Adds a bin to the running sum. The chosen bin is the first at which the cumulative share exceeds `u`. If rounding
// keeps all shares below `u`, the last bin with a positive product is chosen.
void pass_bin(Guide guide, uint bin, float u, inout float sum, inout uint chosen) {
    float product = bin_product(guide, min(bin, direction_bin_count() - 1u));
    if (bin >= direction_bin_count()) product = 0.0;
    if (product > 0.0 && sum * guide.entry.acceptance_scale <= u) chosen = bin;
    sum += product;
}

uint invert_products(Guide guide, float u) {
    float sum = 0.0;
    uint chosen = 0u;
    // The loop handles four bins at a time, because a driver may bound the number of iterations.
    for (uint bin = 0u; bin < direction_bin_count(); bin += 4u) {
        pass_bin(guide, bin, u, sum, chosen);
        pass_bin(guide, bin + 1u, u, sum, chosen);
        pass_bin(guide, bin + 2u, u, sum, chosen);
        pass_bin(guide, bin + 3u, u, sum, chosen);
    }
    return chosen;
}

GuidedSample sample_hemisphere_inversion(RandomKey key, uint vertex, float choice, Guide guide) {
    vec4 u = unit_floats(random_bits(key, vertex, RANDOM_TRIES));
    vec2 p = inverted_point(guide, choice < guide.entry.uniform_share, invert_products(guide, u.x), u.yz);
    vec3 wi = map_to_sphere(p);
    uint bin = square_bin(p, DIRECTION_RESOLUTION);
    float pdf = guide.entry.guide_scale * bin_product(guide, bin) + uniform_density(guide, wi);
    return GuidedSample(wi, pdf, bin, bin_radiance(guide, bin), 1u, false);
}

float pdf_hemisphere_inversion(Guide guide, vec3 wi) {
    return guide.entry.guide_scale * bin_product(guide, direction_bin(wi)) + uniform_density(guide, wi);
}

#endif
