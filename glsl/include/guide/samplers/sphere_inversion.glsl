// Sampler sphere-inversion: inverts the sums of L(cell, w) over the whole sphere, regardless of the normal, in O(log N)
// (Kim and Kim 2021, Table 2). About half of its samples point below the surface and are lost. With the entry's factors
// the density is
//     guide_scale * units of the bin + uniform_density * [n.w > 0].
#ifndef SPHERE_INVERSION_GLSL
#define SPHERE_INVERSION_GLSL
#include "guide/samplers/inversion.glsl"
#include "random/random.glsl"

// Number of the cell's SHARE_UNITS that a bin holds.
float bin_units(uint cell, uint bin) {
    uint index = radiance_index(cell, bin);
    return float(bin_end(index) - (bin == 0u ? 0u : bin_end(index - 1u)));
}

// Number of bisection steps that leave one of all bins.
uint halvings() {
    return 2u * uint(findMSB(DIRECTION_RESOLUTION - 1u) + 1);
}

// Bin that holds this unit of the cell's SHARE_UNITS.
uint bin_of_unit(uint cell, uint unit) {
    uint low = 0u;
    uint high = direction_bin_count() - 1u;
    // All lanes run the same number of steps, because a driver may keep the wrong values for lanes that leave a loop
    // early.
    for (uint i = 0u; i < halvings(); ++i) {
        uint middle = (low + high) / 2u;
        bool lower = unit < bin_end(radiance_index(cell, middle));
        low = lower ? low : min(middle + 1u, high);
        high = lower ? middle : high;
    }
    return low;
}

GuidedSample sample_sphere_inversion(RandomKey key, uint vertex, float choice, Guide guide) {
    uvec4 bits = random_bits(key, vertex, RANDOM_TRIES);
    uint chosen = bin_of_unit(guide.cell, bits.x >> 1u);
    vec2 p = inverted_point(guide, choice < guide.entry.uniform_share, chosen, unit_floats(bits).yz);
    vec3 wi = map_to_sphere(p);
    uint bin = square_bin(p, DIRECTION_RESOLUTION);
    float pdf = guide.entry.guide_scale * bin_units(guide.cell, bin) + uniform_density(guide, wi);
    return GuidedSample(wi, pdf, bin, bin_radiance(guide, bin), 1u, false);
}

float pdf_sphere_inversion(Guide guide, vec3 wi) {
    return guide.entry.guide_scale * bin_units(guide.cell, direction_bin(wi)) + uniform_density(guide, wi);
}

#endif
