// What the normalization grid keeps of a cell and a normal for all samplers but `product`.
#ifndef NORMALIZATION_RECORD_GLSL
#define NORMALIZATION_RECORD_GLSL

// How to sample and to weigh what a sampler follows: L(cell, w), or L(cell, w) max(0, cos(nb, w)) for the bin's
// representative normal nb. Each sampler says what it multiplies.
struct NormalizationEntry {
    float guide_scale;       // times what the sampler follows: density of a guided direction, per steradian
    float uniform_density;   // density of the uniform share and of the fallback, per steradian; positive
    float acceptance_scale;  // times what the sampler follows: a probability, at most 1
    float uniform_share;     // the share e of Eq. 8 and 9
};

NormalizationEntry entry_of(uvec4 record) {
    vec4 x = uintBitsToFloat(record);
    return NormalizationEntry(x.x, x.y, x.z, x.w);
}

uvec4 record_of(NormalizationEntry entry) {
    return floatBitsToUint(vec4(entry.guide_scale, entry.uniform_density, entry.acceptance_scale, entry.uniform_share));
}

#endif
