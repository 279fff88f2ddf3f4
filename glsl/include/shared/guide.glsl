// How what a guide has learned is laid out.
#ifndef SHARED_GUIDE_GLSL
#define SHARED_GUIDE_GLSL

// Shares of the scattering function that a cell has: of diffuse lobes, and of scattering functions that are guided as a whole.
const uint SHARES_PER_CELL = 2u;
// Words of a share in the table of radiance: the share, two sums that it is learned from, and the number of samples in these.
const uint SHARE_WORDS = 4u;
// Sums of a step for a share.
const uint SHARE_SUMS = 2u;

// Least number of nodes of all quadtrees for each leaf of the spatial tree.
const uint NODES_PER_LEAF = 8u;

// Exponent, as that of a float, of the code 0 of a small float of 8 bits.
const uint BIAS_8 = 96u;
// Largest small float, of 7 bits and of 8.
const float LARGEST_SMALL_FLOAT = 1.875;
// Bits of a float below the mantissa of a small one.
const uint DROPPED_BITS = 20u;

#endif
