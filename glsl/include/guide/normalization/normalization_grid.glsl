// Set 3, NormalizationGrid: memoised normalizers N(cell, normal bin). The only file that indexes it.
// Kernels that only read the table do so through texels where the device has enough of them: a view of the same buffer.
#ifndef NORMALIZATION_GRID_GLSL
#define NORMALIZATION_GRID_GLSL
#include "guide/normalization/normalization_record.glsl"
#include "shared/sets.glsl"
#include "shared/variant.glsl"

// Of one (direction bin, normal bin): what the clamped cosine amounts to over the direction bin.
struct CosineIntegral {
    float integral;  // exact integral over the bin, sr
    float maximum;   // upper bound over the bin
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

// What the grid holds of a cell and a normal bin: a NormalizationEntry or, of the product sampler, the weights of the map's
// blocks. All zeros where it is unfilled.
#ifdef TEXEL_READS
layout(set = NORMALIZATION_GRID_SET, binding = 3) uniform usamplerBuffer normalization_texels;
layout(set = NORMALIZATION_GRID_SET, binding = 4) uniform usamplerBuffer cosine_nodes;

uvec4 normalization_record(uint index) {
    return texelFetch(normalization_texels, int(index));
}

// Sixteen weights of the tree of a normal bin. See tree.glsl.
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

// Asks for the entry to be filled from the next update on.
void mark_entry(uint index) {
    if (!is_marked(index)) atomicOr(normalization_marks[index >> 5u], 1u << (index & 31u));
}

// The marks of up to 32 normal bins of a cell from `first` on, a bit each.
uint marks_from(uint cell, uint first) {
    uint index = normalization_index(cell, first);
    uint shift = index & 31u;
    uint bits = normalization_marks[index >> 5u] >> shift;
    uint count = min(normal_bin_count() - first, 32u);
    if (shift + count > 32u) bits |= normalization_marks[(index >> 5u) + 1u] << (32u - shift);
    return count < 32u ? bits & ((1u << count) - 1u) : bits;
}

// The marked normal bin of a cell before which lie `place` others; NONE where there are not so many.
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

// Neighboring normal bins lie side by side, so that the lanes of an update read one line.
CosineIntegral cosine_integral(uint bin, uint normal_bin) {
    return cosine_integrals[bin * normal_bin_count() + normal_bin];
}

#endif
