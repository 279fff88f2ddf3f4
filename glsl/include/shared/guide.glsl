// Memory layout of what a guide has learned.
#ifndef SHARED_GUIDE_GLSL
#define SHARED_GUIDE_GLSL

// Number of learned BSDF shares of a cell: one for diffuse lobes, one for BSDFs that are guided as a whole.
const uint SHARES_PER_CELL = 2u;
// Words of a BSDF share in the radiance table: the share, the two sums that determine it, and the number of samples in
// the sums.
const uint SHARE_WORDS = 4u;
// Number of sums that a step records for a BSDF share.
const uint SHARE_SUMS = 2u;

// Invocations that blend the radiance of one cell.
const uint LANES_PER_CELL = 16u;

// Nodes that the memory of all quadtrees provides for each leaf of the spatial tree, at least.
const uint NODES_PER_LEAF = 8u;

// Biased exponent, as in a 32-bit float, that the code 0 of an 8-bit float stands for.
const uint BIAS_8 = 96u;
// Largest value of a small float, with 7 bits as well as with 8.
const float LARGEST_SMALL_FLOAT = 1.875;
// Number of low mantissa bits of a 32-bit float that a small float drops.
const uint DROPPED_BITS = 20u;

#endif
