// Set 2, RadianceGrid: what has been learned, L(cell, direction bin). The only file that indexes it. Kernels that only read
// the table do so through texels where the device has enough of them: a view of the same buffer.
#ifndef RADIANCE_GRID_GLSL
#define RADIANCE_GRID_GLSL
#include "math/direction_map.glsl"
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

layout(scalar, set = 2, binding = 0) restrict buffer RadianceTable { float radiance_table[]; };
layout(scalar, set = 2, binding = 1) restrict buffer LearnedTable { LearnedRadiance learned_table[]; };
layout(scalar, set = 2, binding = 2) restrict buffer RadianceSums { RadianceSum radiance_sums[]; };
// Of sphere-inversion; then, where second moments are kept, sums of the squares of a step's targets: in fixed point, two words
// each, low and high. One binding, for devices have few.
layout(scalar, set = 2, binding = 3) restrict buffer BinEnds { uint bin_ends[]; };
layout(scalar, set = 2, binding = 4) restrict buffer RadianceNodes { uvec4 radiance_nodes[]; };
layout(scalar, set = 2, binding = 7) restrict readonly buffer CellTable { uint cell_table[]; };

// Fixed-point targets: a target of `target_limit` is this many units.
const float FIXED_POINT_UNITS = 1073741824.0;
// Fixed-point squares likewise: 2^48 units, so that sums hold 2^16 targets of that size, or 2^24 of an emitter's.
const float SQUARE_UNITS = 281474976710656.0;
const float WORD_UNITS = 4294967296.0;

// A word of the table that cells.glsl reads.
uint cell_word(uint index) {
    return cell_table[index];
}

uint radiance_index(uint cell, uint bin) {
    return cell * direction_bin_count() + bin;
}

// Mean radiance (of RGB) that arrives in the cell from the bin's directions; positive.
#ifdef TEXEL_READS
layout(set = 2, binding = 5) uniform samplerBuffer radiance_texels;
layout(set = 2, binding = 6) uniform usamplerBuffer radiance_node_texels;

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

bool keeps_second_moments() {
    return SECOND_MOMENTS_AT != 0u;
}

// Root of the second moment of a bin's targets, before any floor.
float root_second_moment(uint index) {
    return radiance(SECOND_MOMENTS_AT + index);
}

// What directions of the bin are drawn in proportion to: the mean radiance or, where second moments are kept, the root of theirs,
// which is no less but for rounding; positive (Rath et al. 2020, "Variance-Aware Path Guiding").
float target_density(uint index) {
    float mean = radiance(index);
    return keeps_second_moments() ? max(root_second_moment(index), mean) : mean;
}

void store_radiance_node(uint index, uvec4 weights) {
    radiance_nodes[index] = weights;
}

void store_radiance_word(uint index, uint word, uint value) {
    radiance_nodes[index][word] = value;
}

void store_radiance(uint index, float value) {
    radiance_table[index] = value;
}

void store_root_second_moment(uint index, float value) {
    store_radiance(SECOND_MOMENTS_AT + index, value);
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

// Where the two words of a bin's squares are.
uint square_sum_place(uint index) {
    uint place = 2u * index;
    if (SAMPLER == SAMPLER_SPHERE_INVERSION) place += SECOND_MOMENTS_AT;
    return place;
}

// Adds the square of a target, in units of the limit's; saturated and rounded likewise.
void add_square(uint index, float target, float target_limit, float u) {
    float share = clamp(target / target_limit, 0.0, 1.0);
    float square = share * share * SQUARE_UNITS;
    float high = floor(square * (1.0 / WORD_UNITS));
    float low = square - high * WORD_UNITS;
    uint low_units = uint(floor(low)) + (u < fract(low) ? 1u : 0u);
    uint place = square_sum_place(index);
    uint old = atomicAdd(bin_ends[place], low_units);
    uint high_units = uint(high) + (old + low_units < old ? 1u : 0u);
    if (high_units != 0u) atomicAdd(bin_ends[place + 1u], high_units);
}

// The sum of a bin's squares since the last call, in units of the limit's.
float take_squares(uint index) {
    uint place = square_sum_place(index);
    vec2 words = vec2(bin_ends[place], bin_ends[place + 1u]);
    bin_ends[place] = 0u;
    bin_ends[place + 1u] = 0u;
    return (words.y * WORD_UNITS + words.x) * (1.0 / SQUARE_UNITS);
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
