// Set 3, NormalizationGrid: memoised normalizers N(cell, normal bin). The only file that indexes it.
// Kernels that only read the table do so through texels where the device has enough of them: a view of the same buffer.
#ifndef NORMALIZATION_GRID_GLSL
#define NORMALIZATION_GRID_GLSL
#include "variant.glsl"

// How to sample and to weigh what a sampler follows: L(cell, w), or L(cell, w) max(0, cos(nb, w)) for the bin's
// representative normal nb. Each sampler says what it multiplies.
struct NormalizationEntry {
    float guide_scale;       // times what the sampler follows: density of a guided direction, per steradian
    float uniform_density;   // density of the uniform share and of the fallback, per steradian; 0 marks an unfilled entry
    float acceptance_scale;  // times what the sampler follows: a probability, at most 1
    float uniform_share;     // the share e of Eq. 8 and 9
};

// Of one (direction bin, normal bin): what the clamped cosine amounts to over the direction bin.
struct CosineIntegral {
    float integral;  // exact integral over the bin, sr
    float maximum;   // upper bound over the bin
};

layout(scalar, set = 3, binding = 0) restrict buffer NormalizationTable { NormalizationEntry normalization_table[]; };
layout(scalar, set = 3, binding = 1) restrict buffer NormalizationMarks { uint normalization_marks[]; };
layout(scalar, set = 3, binding = 2) restrict readonly buffer CosineIntegrals { CosineIntegral cosine_integrals[]; };

uint normal_bin_count() {
    return NORMAL_RESOLUTION * NORMAL_RESOLUTION;
}

uint normalization_index(uint cell, uint normal_bin) {
    return cell * normal_bin_count() + normal_bin;
}

#ifdef TEXEL_READS
layout(set = 3, binding = 3) uniform samplerBuffer normalization_texels;

NormalizationEntry normalization_entry(uint index) {
    vec4 t = texelFetch(normalization_texels, int(index));
    return NormalizationEntry(t.x, t.y, t.z, t.w);
}
#else
NormalizationEntry normalization_entry(uint index) {
    return normalization_table[index];
}
#endif

void store_normalization_entry(uint index, NormalizationEntry entry) {
    normalization_table[index] = entry;
}

bool is_marked(uint index) {
    return (normalization_marks[index >> 5u] & (1u << (index & 31u))) != 0u;
}

// Asks for the entry to be filled from the next update on.
void mark_entry(uint index) {
    if (!is_marked(index)) atomicOr(normalization_marks[index >> 5u], 1u << (index & 31u));
}

// Neighboring normal bins lie side by side, so that the lanes of an update read one line.
CosineIntegral cosine_integral(uint bin, uint normal_bin) {
    return cosine_integrals[bin * normal_bin_count() + normal_bin];
}

#endif
