// Set 3, NormalizationGrid: the memoized normalizers N(cell, normal bin). Only this file indexes the buffers of the
// set. Kernels that only read the table do so through a texel view of the same buffer, on devices with enough texel
// buffers.
#ifndef NORMALIZATION_GRID_GLSL
#define NORMALIZATION_GRID_GLSL
#include "generated/normalization.glsl"
#include "shared/sets.glsl"
#include "shared/variant.glsl"

// Integral and maximum of the clamped cosine about a normal bin's representative normal, over one direction bin.
struct CosineIntegral {
    float integral;  // integral of the clamped cosine over the direction bin, sr
    float maximum;   // upper bound of the cosine over the bin, at least 0
};

layout(scalar, set = NORMALIZATION_GRID_SET, binding = 0) restrict buffer NormalizationTable { uvec4 normalization_table[]; };
layout(scalar, set = NORMALIZATION_GRID_SET, binding = 1) restrict buffer NormalizationMarks { uint normalization_marks[]; };
layout(scalar, set = NORMALIZATION_GRID_SET, binding = 2) restrict readonly buffer CosineIntegrals { CosineIntegral cosine_integrals[]; };

uint normal_bin_count() {
    return NORMAL_RESOLUTION * NORMAL_RESOLUTION;
}

uint normalization_index(uint cell, uint normal_bin) {
    return cell * normal_bin_count() + normal_bin;
}

// Record of a cell and a normal bin: a NormalizationEntry, or for the product sampler the weights of the map's blocks.
// An entry that is not filled is all zeros.
#ifdef TEXEL_READS
layout(set = NORMALIZATION_GRID_SET, binding = 3) uniform usamplerBuffer normalization_texels;
layout(set = NORMALIZATION_GRID_SET, binding = 4) uniform usamplerBuffer cosine_nodes;

uvec4 normalization_record(uint index) {
    return texelFetch(normalization_texels, int(index));
}

// Sixteen weights of a node of a normal bin's tree (tree.glsl).
uvec4 cosine_node(uint index) {
    return texelFetch(cosine_nodes, int(index));
}
#else
layout(scalar, set = NORMALIZATION_GRID_SET, binding = 4) restrict readonly buffer CosineNodes { uvec4 cosine_nodes[]; };

uvec4 normalization_record(uint index) {
    return normalization_table[index];
}

uvec4 cosine_node(uint index) {
    return cosine_nodes[index];
}
#endif

void store_normalization_record(uint index, uvec4 record) {
    normalization_table[index] = record;
}

bool is_marked(uint index) {
    return (normalization_marks[index >> 5u] & (1u << (index & 31u))) != 0u;
}

// Requests that the entry is filled from the next update on.
void mark_entry(uint index) {
    if (!is_marked(index)) atomicOr(normalization_marks[index >> 5u], 1u << (index & 31u));
}

// Marks of up to 32 normal bins of a cell, starting at `first`, one bit each.
uint marks_from(uint cell, uint first) {
    uint index = normalization_index(cell, first);
    uint shift = index & 31u;
    uint bits = normalization_marks[index >> 5u] >> shift;
    uint count = min(normal_bin_count() - first, 32u);
    if (shift + count > 32u) bits |= normalization_marks[(index >> 5u) + 1u] << (32u - shift);
    return count < 32u ? bits & ((1u << count) - 1u) : bits;
}

// Marked normal bin of a cell with the number `place`, counted from 0; NONE if the cell has fewer marked bins.
uint marked_normal_bin(uint cell, uint place) {
    uint found = NONE;
    for (uint first = 0u; first < normal_bin_count() && found == NONE; first += 32u) {
        uint bits = marks_from(cell, first);
        uint count = uint(bitCount(bits));
        bool here = place < count;
        for (uint i = here ? place : 0u; i > 0u; --i) bits &= bits - 1u;
        found = here ? first + uint(findLSB(bits)) : NONE;
        place -= count;
    }
    return found;
}

// Integral for a direction bin and a normal bin. Neighboring normal bins lie side by side, so that the lanes of an
// update read the same cache line.
CosineIntegral cosine_integral(uint bin, uint normal_bin) {
    return cosine_integrals[bin * normal_bin_count() + normal_bin];
}

#endif
