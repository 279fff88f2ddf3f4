// Set 2, RadianceGrid: the learned radiance L(cell, direction bin). Only this file indexes the buffers of the set.
// Kernels that only read the table do so through a texel view of the same buffer, on devices with enough texel buffers.
#ifndef RADIANCE_GRID_GLSL
#define RADIANCE_GRID_GLSL
#include "math/direction_map.glsl"
#include "shared/sets.glsl"
#include "shared/variant.glsl"

// Sums that one step records for a bin. The sum of targets is a 64-bit fixed-point number in two words, so that the
// order of additions does not matter.
struct RadianceSum {
    uint low;           // lower word of the fixed-point sum
    uint high;          // upper word of the fixed-point sum
    uint target_count;  // number of targets
    float flux;         // Flux of a quarter, including all nodes below it. Only the refinement of quadtrees uses it.
};

// Estimate of a bin before the floor: the mean radiance, and the number of targets behind it after decay.
struct LearnedRadiance {
    float mean;    // mean radiance before the floor is applied
    float weight;  // number of targets behind the mean, after decay
};

layout(scalar, set = RADIANCE_GRID_SET, binding = 0) restrict buffer RadianceTable { float radiance_table[]; };
layout(scalar, set = RADIANCE_GRID_SET, binding = 1) restrict buffer LearnedTable { LearnedRadiance learned_table[]; };
layout(scalar, set = RADIANCE_GRID_SET, binding = 2) restrict buffer RadianceSums { RadianceSum radiance_sums[]; };
// Cumulative shares of a cell's bins, for the sampler sphere-inversion.
layout(scalar, set = RADIANCE_GRID_SET, binding = 3) restrict buffer BinEnds { uint bin_ends[]; };
layout(scalar, set = RADIANCE_GRID_SET, binding = 4) restrict buffer RadianceNodes { uvec4 radiance_nodes[]; };
layout(scalar, set = RADIANCE_GRID_SET, binding = 7) restrict readonly buffer CellTable { uint cell_table[]; };

// Number of fixed-point units of a target that equals `target_limit`.
const float FIXED_POINT_UNITS = 1073741824.0;

// Word of the table that cells.glsl reads.
uint cell_word(uint index) {
    return cell_table[index];
}

uint radiance_index(uint cell, uint bin) {
    return cell * direction_bin_count() + bin;
}

// Mean over RGB of the radiance that arrives in the cell from the bin's directions; positive.
#ifdef TEXEL_READS
layout(set = RADIANCE_GRID_SET, binding = 5) uniform samplerBuffer radiance_texels;
layout(set = RADIANCE_GRID_SET, binding = 6) uniform usamplerBuffer radiance_node_texels;

float radiance(uint index) {
    return texelFetch(radiance_texels, int(index)).x;
}

// Sixteen weights of a node of the cell's tree (tree.glsl), or a node as in quadtree_nodes.glsl.
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

// Number of units that a cell's radiance is divided into. Shares of bins are integers, so that density and samples
// agree exactly.
const uint SHARE_UNITS = 0x80000000u;

// Sum of the units of the cell's bins up to and including this one. It is SHARE_UNITS for the last bin of the cell.
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

// Units of a target. The target is clamped, then rounded up or down at random with `u`, so that the expected value is
// exact.
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

// Returns the sum and the number of a bin's targets since the last call, and clears both.
void take_targets(uint index, float target_limit, out float sum, out float target_count) {
    sum = sum_of_targets(index, target_limit);
    target_count = number_of_targets(index);
    forget_targets(index);
}

// Updated estimate of a bin or of a group of lights (Eq. 7). The learning rate is alpha = count / (count + decayed earlier count). With decay = 1 the
// estimate is the running mean over all targets.
LearnedRadiance updated_mean(LearnedRadiance before, float decay, float sum, float target_count) {
    float weight = before.weight * decay + target_count;
    if (target_count == 0.0) return LearnedRadiance(before.mean, weight);
    float alpha = target_count / weight;
    return LearnedRadiance(mix(before.mean, sum / target_count, alpha), weight);
}

float quarter_flux(uint index) {
    return radiance_sums[index].flux;
}

void store_quarter_flux(uint index, float flux) {
    radiance_sums[index].flux = flux;
}

#endif
