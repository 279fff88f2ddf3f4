// Scales of blocks of direction bins: how much brighter than its parent's estimate a cell has found a block.
//
// A cell with few targets cannot tell what arrives from each bin, but it can tell how much arrives from many bins together. The
// blocks are the whole map of directions, its quarters, their quarters, and so on, down to 8 x 8 blocks. The scale S of a block
// B multiplies the parent's estimate P of its bins:
//     S(B) = (sum of w m + K mean(P) S(B')) / (sum of w P + K mean(P)),   K = BLOCK_EVIDENCE FALLBACK,
// with the mean m and the weight w of every bin in B. B' is the block that B is a quarter of. S(B') counts for as much as K
// targets. The map as a whole begins with S(B') = 1. This S is the mean of the posterior of a factor on Poisson-like sums under
// a gamma prior of shape K mean(P) S(B') and rate K mean(P).
//
// LANES_PER_CELL lanes share a cell. Each has one of the 4 x 4 blocks, with the four finest blocks in it.
#ifndef BLOCK_SCALES_GLSL
#define BLOCK_SCALES_GLSL
#include "guide/grid/radiance_grid.glsl"
#include "shared/guide.glsl"

// Sums over the bins of a block.
struct BlockSums {
    float found;     // w m
    float expected;  // w P
    float prior;     // P
};

// Blocks along each side of the map: one block for each lane, and the finest.
const uint LANE_SIDE = 4u;
const uint FINEST_SIDE = 8u;
// Most bins along each side of a finest block.
const uint BLOCK_SIDE = (DIRECTION_RESOLUTION + FINEST_SIDE - 1u) / FINEST_SIDE;
const uint BLOCK_BINS = BLOCK_SIDE * BLOCK_SIDE;

// Targets that the scale of the coarser block counts for, in units of FALLBACK. Targets of a block differ more among each other
// than those of a bin, because few of its directions lead to light.
const float BLOCK_EVIDENCE = 16.0;

// Largest scale, above which a sum has overflowed.
const float LARGEST_SCALE = 1.0e30;

shared float lane_found[WORKGROUP_SIZE];
shared float lane_expected[WORKGROUP_SIZE];
shared float lane_prior[WORKGROUP_SIZE];

// First lane of the invocation's cell.
uint first_lane() {
    return gl_LocalInvocationIndex / LANES_PER_CELL * LANES_PER_CELL;
}

// The lane's block.
uvec2 lane_block() {
    uint lane = gl_LocalInvocationIndex % LANES_PER_CELL;
    return uvec2(lane % LANE_SIDE, lane / LANE_SIDE);
}

// Finest block with the number `i` of the four in the lane's block.
uvec2 finest_block(uint i) {
    return 2u * lane_block() + uvec2(i % 2u, i / 2u);
}

// First bin of a block, where the map has `side` blocks along each side: the first with bin * side / DIRECTION_RESOLUTION = block.
uvec2 first_bin(uvec2 block, uint side) {
    return (block * DIRECTION_RESOLUTION + side - 1u) / side;
}

// Bin with the number `i` of a finest block; NONE if the block has fewer.
uint bin_of_block(uvec2 block, uint i) {
    uvec2 at = first_bin(block, FINEST_SIDE) + uvec2(i % BLOCK_SIDE, i / BLOCK_SIDE);
    uvec2 end = first_bin(block + 1u, FINEST_SIDE);
    return at.x < end.x && at.y < end.y ? at.y * DIRECTION_RESOLUTION + at.x : NONE;
}

// Sums over two blocks together.
BlockSums both(BlockSums a, BlockSums b) {
    return BlockSums(a.found + b.found, a.expected + b.expected, a.prior + b.prior);
}

// Shows the lane's sums to the other lanes of the workgroup. All invocations call this function.
void share_sums(BlockSums sums) {
    barrier();
    lane_found[gl_LocalInvocationIndex] = sums.found;
    lane_expected[gl_LocalInvocationIndex] = sums.expected;
    lane_prior[gl_LocalInvocationIndex] = sums.prior;
    barrier();
}

// Sum over what four lanes of the cell have shared: the one of block `corner`, and those `step` blocks to the right, below, and both.
BlockSums sum_of_four(uvec2 corner, uint step) {
    BlockSums sums = BlockSums(0.0, 0.0, 0.0);
    for (uint i = 0u; i < 4u; ++i) {
        uvec2 at = corner + step * uvec2(i % 2u, i / 2u);
        uint lane = first_lane() + at.y * LANE_SIDE + at.x;
        sums = both(sums, BlockSums(lane_found[lane], lane_expected[lane], lane_prior[lane]));
    }
    return sums;
}

// Scale of a block, from that of the block that it is a quarter of. The map has `side` blocks along each side. Sums of huge
// radiance may be infinite. The block then has the scale of the larger one.
float scale_within(float scale, BlockSums sums, uvec2 block, uint side) {
    uvec2 size = first_bin(block + 1u, side) - first_bin(block, side);
    float evidence = BLOCK_EVIDENCE * FALLBACK * sums.prior / float(max(size.x * size.y, 1u));
    float expected = sums.expected + evidence;
    float finer = (sums.found + evidence * scale) / expected;
    return expected > 0.0 && finer < LARGEST_SCALE ? finer : scale;
}

// Scale of the lane's block, from the sums over its bins. All invocations of the workgroup call this function.
float scale_of_lane(BlockSums own) {
    uvec2 block = lane_block();
    share_sums(own);
    BlockSums quarter = sum_of_four(block / 2u * 2u, 1u);
    share_sums(quarter);
    BlockSums whole = sum_of_four(uvec2(0u), 2u);
    float scale = scale_within(1.0, whole, uvec2(0u), 1u);
    scale = scale_within(scale, quarter, block / 2u, 2u);
    return scale_within(scale, own, block, LANE_SIDE);
}

// Sum over the lanes of the cell. All invocations of the workgroup call this function.
float sum_of_cell(float value) {
    barrier();
    lane_found[gl_LocalInvocationIndex] = value;
    barrier();
    float sum = 0.0;
    for (uint i = 0u; i < LANES_PER_CELL; ++i) sum += lane_found[first_lane() + i];
    return sum;
}

#endif
