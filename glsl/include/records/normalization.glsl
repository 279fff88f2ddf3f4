// Record of the normalization grid for a cell and a normal, for all samplers except `product`.
#ifndef RECORDS_NORMALIZATION_GLSL
#define RECORDS_NORMALIZATION_GLSL

// Factors of a sampler. Each sampler states the function that it follows: L(cell, w), or L(cell, w) max(0, cos(nb, w))
// with the representative normal nb of the normal bin.
struct NormalizationEntry {
    float guide_scale;       // times the followed function: density of a guided direction, per steradian
    float uniform_density;   // density of uniform share and fallback, per steradian; positive
    float acceptance_scale;  // times the followed function: a probability, at most 1
    float uniform_share;     // share e of Eq. 8 and Eq. 9
};

#endif
