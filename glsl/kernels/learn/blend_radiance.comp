// Blends what each cell has learned with the estimate of its parent cell, and writes the radiance table that the next
// step samples. One workgroup handles several cells. Larger cells come first.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/grid/block_scales.glsl"
#include "guide/grid/cells.glsl"
#include "guide/grid/floor.glsl"

// Push constants: cells of the dispatch.
struct BlendPush {
    uint first_cell;  // first cell of the dispatch
    uint end_cell;    // one more than the last cell of the dispatch
};
layout(push_constant, scalar) uniform Push { BlendPush push; };

// What a bin's estimate is made of: share learned.mean + (1 - share) S prior, with the scale S of the bin's block.
struct BinParts {
    LearnedRadiance learned;  // of the cell
    float prior;              // estimate of the parent
    float share;              // weight / (weight + FALLBACK); 1 in the largest cell
};

// Sums over the bins of a finest block. The sum of its estimates is own + S borrowed.
struct FinestBlock {
    BlockSums sums;
    float own;
    float borrowed;
};

BinParts parts_of(uint cell, uint parent, uint bin) {
    LearnedRadiance learned = learned_radiance(radiance_index(cell, bin));
    if (parent == NONE) return BinParts(learned, 0.0, 1.0);
    float prior = learned_radiance(radiance_index(parent, bin)).mean;
    return BinParts(learned, prior, learned.weight / (learned.weight + FALLBACK));
}

// Sums over the bins of the finest block `at`.
FinestBlock measured_block(uint cell, uint parent, uvec2 at) {
    FinestBlock block = FinestBlock(BlockSums(0.0, 0.0, 0.0), 0.0, 0.0);
    for (uint i = 0u; i < BLOCK_BINS; ++i) {
        uint bin = bin_of_block(at, i);
        if (bin != NONE) {
            BinParts parts = parts_of(cell, parent, bin);
            float weight = parts.learned.weight;
            block.sums = both(block.sums, BlockSums(weight * parts.learned.mean, weight * parts.prior, parts.prior));
            block.own += parts.share * parts.learned.mean;
            block.borrowed += (1.0 - parts.share) * parts.prior;
        }
    }
    return block;
}

// Stores the estimates of the bins of the finest block `at`. Bins of a cell that is sampled hold at least `least`.
void store_block(uint cell, uint parent, uvec2 at, float scale, float least) {
    for (uint i = 0u; i < BLOCK_BINS; ++i) {
        uint bin = bin_of_block(at, i);
        if (bin != NONE) {
            BinParts parts = parts_of(cell, parent, bin);
            float estimate = mix(scale * parts.prior, parts.learned.mean, parts.share);
            uint index = radiance_index(cell, bin);
            if (is_parent(cell)) {
                store_learned_radiance(index, LearnedRadiance(estimate, parts.learned.weight));
            } else {
                store_radiance(index, max(estimate, least));
            }
        }
    }
}

void main() {
    uint cell = push.first_cell + (gl_WorkGroupID.x * WORKGROUP_SIZE + gl_LocalInvocationIndex) / LANES_PER_CELL;
    // Lanes behind the last cell do its work again, without storing it, because all lanes meet at the barriers.
    bool exists = cell < push.end_cell;
    cell = min(cell, push.end_cell - 1u);
    uint parent = parent_cell(cell);
    FinestBlock blocks[4];
    BlockSums sums = BlockSums(0.0, 0.0, 0.0);
    for (uint i = 0u; i < 4u; ++i) {
        blocks[i] = measured_block(cell, parent, finest_block(i));
        sums = both(sums, blocks[i].sums);
    }
    float scale = scale_of_lane(sums);
    float scales[4];
    float estimates = 0.0;
    for (uint i = 0u; i < 4u; ++i) {
        scales[i] = scale_within(scale, blocks[i].sums, finest_block(i), FINEST_SIDE);
        estimates += blocks[i].own + scales[i] * blocks[i].borrowed;
    }
    float least = least_radiance(sum_of_cell(estimates));
    if (!exists) return;
    for (uint i = 0u; i < 4u; ++i) store_block(cell, parent, finest_block(i), scales[i], least);
}
