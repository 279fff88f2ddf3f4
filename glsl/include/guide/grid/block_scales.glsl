// Scales of blocks of direction bins: how much brighter than its parent's estimate a cell has found a block.
//
// A cell with few targets cannot tell what arrives from each bin, but it can tell how much arrives from many bins together. The
// blocks are the whole map of directions, its quarters, their quarters, and so on, down to 8 x 8 blocks. The scale S of a block
// B multiplies the parent's estimate P of its bins:
//     S(B) = (sum of w m + K mean(P) S(B')) / (sum of w P + K mean(P)),   K = BLOCK_EVIDENCE FALLBACK,
// with the mean m and the weight w of every bin in B. B' is the block that B is a quarter of. S(B') counts for as much as K
// targets. The map as a whole begins with S(B') = 1. This S is the mean of the posterior of a factor on Poisson-like sums under
// a gamma prior of shape K mean(P) S(B') and rate K mean(P).
#ifndef BLOCK_SCALES_GLSL
#define BLOCK_SCALES_GLSL
#include "guide/grid/radiance_grid.glsl"

// Sums over the bins of a block.
struct BlockSums {
    float found;     // w m
    float expected;  // w P
    float prior;     // P
    float bins;      // number of bins
};

// Number of blocks along each side of the map, on the finest level.
const uint FINEST_BLOCKS = 8u;
// Blocks of each level follow those of the coarser levels: 1, 4, 16 and 64 blocks.
const uint FIRST_FINEST = 21u;
const uint BLOCK_COUNT = 85u;

// Targets that the scale of the coarser block counts for, in units of FALLBACK. Targets of a block differ more among each other
// than those of a bin, because few of its directions lead to light.
const float BLOCK_EVIDENCE = 16.0;

// Largest scale, above which a sum has overflowed.
const float LARGEST_SCALE = 1.0e30;

shared BlockSums block_sums[BLOCK_COUNT];
shared float finest_scales[FINEST_BLOCKS * FINEST_BLOCKS];

BlockSums sum_of_bins(uint cell, uint parent, uvec2 block) {
    BlockSums sums = BlockSums(0.0, 0.0, 0.0, 0.0);
    // The first bin of a block is the first with bin * FINEST_BLOCKS / DIRECTION_RESOLUTION = block.
    uvec2 first = (block * DIRECTION_RESOLUTION + FINEST_BLOCKS - 1u) / FINEST_BLOCKS;
    uvec2 end = ((block + 1u) * DIRECTION_RESOLUTION + FINEST_BLOCKS - 1u) / FINEST_BLOCKS;
    for (uint y = first.y; y < end.y; ++y) {
        for (uint x = first.x; x < end.x; ++x) {
            uint bin = y * DIRECTION_RESOLUTION + x;
            LearnedRadiance learned = learned_radiance(radiance_index(cell, bin));
            float prior = learned_radiance(radiance_index(parent, bin)).mean;
            sums.found += learned.weight * learned.mean;
            sums.expected += learned.weight * prior;
            sums.prior += prior;
            sums.bins += 1.0;
        }
    }
    return sums;
}

BlockSums sum_of_quarters(uint first, uint side, uvec2 block) {
    BlockSums sums = BlockSums(0.0, 0.0, 0.0, 0.0);
    for (uint quarter = 0u; quarter < 4u; ++quarter) {
        uvec2 at = 2u * block + uvec2(quarter & 1u, quarter >> 1u);
        BlockSums of_quarter = block_sums[first + at.y * side + at.x];
        sums.found += of_quarter.found;
        sums.expected += of_quarter.expected;
        sums.prior += of_quarter.prior;
        sums.bins += of_quarter.bins;
    }
    return sums;
}

// Scale of a block, from that of the block that it is a quarter of. Sums of huge radiance may be infinite. The block then has the scale of the
// larger one.
float scale_within(float scale, BlockSums sums) {
    float evidence = BLOCK_EVIDENCE * FALLBACK * sums.prior / max(sums.bins, 1.0);
    float expected = sums.expected + evidence;
    float finer = (sums.found + evidence * scale) / expected;
    return expected > 0.0 && finer < LARGEST_SCALE ? finer : scale;
}

// Measures the blocks of a cell. All invocations of the workgroup call this function.
void measure_blocks(uint cell, uint parent) {
    uint lane = gl_LocalInvocationIndex;
    barrier();
    for (uint i = lane; i < FINEST_BLOCKS * FINEST_BLOCKS; i += WORKGROUP_SIZE) {
        block_sums[FIRST_FINEST + i] = sum_of_bins(cell, parent, uvec2(i % FINEST_BLOCKS, i / FINEST_BLOCKS));
    }
    barrier();
    uint below = FIRST_FINEST;
    for (uint side = FINEST_BLOCKS / 2u; side > 0u; side /= 2u) {
        uint first = below - side * side;
        for (uint i = lane; i < side * side; i += WORKGROUP_SIZE) {
            block_sums[first + i] = sum_of_quarters(below, 2u * side, uvec2(i % side, i / side));
        }
        below = first;
        barrier();
    }
    for (uint i = lane; i < FINEST_BLOCKS * FINEST_BLOCKS; i += WORKGROUP_SIZE) {
        float scale = 1.0;
        uint first = 0u;
        for (uint side = 1u; side <= FINEST_BLOCKS; side *= 2u) {
            uvec2 at = uvec2(i % FINEST_BLOCKS, i / FINEST_BLOCKS) * side / FINEST_BLOCKS;
            scale = scale_within(scale, block_sums[first + at.y * side + at.x]);
            first += side * side;
        }
        finest_scales[i] = scale;
    }
    barrier();
}

// Scale of the finest block that contains a bin.
float bin_scale(uint bin) {
    uvec2 at = uvec2(bin % DIRECTION_RESOLUTION, bin / DIRECTION_RESOLUTION) * FINEST_BLOCKS / DIRECTION_RESOLUTION;
    return finest_scales[at.y * FINEST_BLOCKS + at.x];
}

#endif
