// Set 2, RadianceGrid: what has been learned, L(cell, direction bin). The only file that indexes it. Kernels that only read
// the table do so through texels where the device has enough of them: a view of the same buffer.
#ifndef RADIANCE_GRID_GLSL
#define RADIANCE_GRID_GLSL
#include "math/direction_map.glsl"
#include "shared/sets.glsl"
#include "shared/variant.glsl"

// What one step adds to a bin: a sum of fixed-point targets in two words, exact in any order, and their number.
struct RadianceSum {
    uint low;
    uint high;
    uint target_count;
    float flux;  // while quadtrees are refined: of a quarter with all below it
};

// The estimate itself, before any floor: mean radiance and the (decayed) number of targets behind it.
struct LearnedRadiance {
    float mean;
    float weight;
};

layout(scalar, set = RADIANCE_GRID_SET, binding = 0) restrict buffer RadianceTable { float radiance_table[]; };
layout(scalar, set = RADIANCE_GRID_SET, binding = 1) restrict buffer LearnedTable { LearnedRadiance learned_table[]; };
layout(scalar, set = RADIANCE_GRID_SET, binding = 2) restrict buffer RadianceSums { RadianceSum radiance_sums[]; };
// Ends of the bins' shares, for sphere-inversion.
layout(scalar, set = RADIANCE_GRID_SET, binding = 3) restrict buffer BinEnds { uint bin_ends[]; };
layout(scalar, set = RADIANCE_GRID_SET, binding = 4) restrict buffer RadianceNodes { uvec4 radiance_nodes[]; };
layout(scalar, set = RADIANCE_GRID_SET, binding = 7) restrict readonly buffer CellTable { uint cell_table[]; };

// Fixed-point targets: a target of `target_limit` is this many units.
const float FIXED_POINT_UNITS = 1073741824.0;

// A word of the table that cells.glsl reads.
uint cell_word(uint index) {
    return cell_table[index];
}

uint radiance_index(uint cell, uint bin) {
    return cell * direction_bin_count() + bin;
}

// Mean radiance (of RGB) that arrives in the cell from the bin's directions; positive.
#ifdef TEXEL_READS
layout(set = RADIANCE_GRID_SET, binding = 5) uniform samplerBuffer radiance_texels;
layout(set = RADIANCE_GRID_SET, binding = 6) uniform usamplerBuffer radiance_node_texels;

float radiance(uint index) {
    return texelFetch(radiance_texels, int(index)).x;
}

// Sixteen weights of the cell's tree, see tree.glsl; or what quadtree_nodes.glsl says.
uvec4 radiance_node(uint index) {
    return texelFetch(radiance_node_texels, int(index));
}
#else
float radiance(uint index) {
    return radiance_table[index];
}

uvec4 radiance_node(uint index) {
    return radiance_nodes[index];
}
#endif

void store_radiance_node(uint index, uvec4 weights) {
    radiance_nodes[index] = weights;
}

void store_radiance_word(uint index, uint word, uint value) {
    radiance_nodes[index][word] = value;
}

void store_radiance(uint index, float value) {
    radiance_table[index] = value;
}

// Shares of a cell's radiance are counted in this many units, exactly: density and samples cannot differ.
const uint SHARE_UNITS = 0x80000000u;

// Units that the bins of the cell up to this one, itself included, hold together; SHARE_UNITS at the cell's last bin.
uint bin_end(uint index) {
    return bin_ends[index];
}

void store_bin_end(uint index, uint end) {
    bin_ends[index] = end;
}

LearnedRadiance learned_radiance(uint index) {
    return learned_table[index];
}

void store_learned_radiance(uint index, LearnedRadiance learned) {
    learned_table[index] = learned;
}

// Units of a target: saturated, then rounded up or down with `u` so that the mean is right.
uint fixed_point(float target, float target_limit, float u) {
    float units = clamp(target / target_limit, 0.0, 1.0) * FIXED_POINT_UNITS;
    float whole = floor(units);
    return uint(whole) + (u < units - whole ? 1u : 0u);
}

void add_target(uint index, uint units) {
    uint old = atomicAdd(radiance_sums[index].low, units);
    if (old + units < old) atomicAdd(radiance_sums[index].high, 1u);
    atomicAdd(radiance_sums[index].target_count, 1u);
}

float sum_of_targets(uint index, float target_limit) {
    RadianceSum s = radiance_sums[index];
    return (float(s.high) * 4294967296.0 + float(s.low)) * (target_limit / FIXED_POINT_UNITS);
}

float number_of_targets(uint index) {
    return float(radiance_sums[index].target_count);
}

void forget_targets(uint index) {
    radiance_sums[index] = RadianceSum(0u, 0u, 0u, 0.0);
}

// The sum of a bin's targets and their number since the last call.
void take_targets(uint index, float target_limit, out float sum, out float target_count) {
    sum = sum_of_targets(index, target_limit);
    target_count = number_of_targets(index);
    forget_targets(index);
}

float quarter_flux(uint index) {
    return radiance_sums[index].flux;
}

void store_quarter_flux(uint index, float flux) {
    radiance_sums[index].flux = flux;
}

#endif
