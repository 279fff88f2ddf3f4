// Sobol sampling in sets of eight samples. The points of a set are the first eight points of the first two dimensions
// of Sobol's sequence (Sobol' 1967). They form a (0, 3, 2)-net: every elementary interval of area 1/8 contains one
// point. Owen's scrambling (Owen 1995) makes each point uniform and keeps the net. A set has two nets, one for each
// pair of numbers, in independently random orders ("padding"; Kollig and Keller 2002).
//
// Camera rays use the sequence itself beyond its first eight points: 2^n consecutive points that start at a multiple of
// 2^n form a net.
#ifndef SOBOL_GLSL
#define SOBOL_GLSL

const uint SET_SIZE = 8u;

// Owen scrambling of numbers with three binary digits. Seven random bits say whether a digit is flipped; the digits
// before it select the bit.
uvec4 owen_scramble(uvec4 x, uvec4 flips) {
    uvec4 flip0 = flips & 1u;
    uvec4 flip1 = (flips >> (1u + (x >> 2u))) & 1u;
    uvec4 flip2 = (flips >> (3u + (x >> 1u))) & 1u;
    return x ^ ((flip0 << 2u) | (flip1 << 1u) | flip2);
}

// Bits of `flips` in owen_scramble that the digits of the number 0 select.
const uint FLIPS_OF_ZERO = 0xbu;

// First three binary digits of both coordinates of the points i.x and i.y in [0, 8). The result holds x and y of i.x,
// then x and y of i.y.
uvec4 sobol_digits(uvec2 i) {
    // The first dimension is the number with its digits reversed (van der Corput).
    uvec2 x = ((i & 1u) << 2u) | (i & 2u) | (i >> 2u);
    uvec2 y = x ^ ((((i >> 1u) ^ (i >> 2u)) & 1u) << 2u);
    return uvec4(x.x, y.x, x.y, y.y);
}

// First three digits of four random numbers of a sample. `bits` are random and equal for the whole set.
uvec4 set_digits(uint sample_index, uvec4 bits) {
    uvec4 shuffled = owen_scramble(uvec4(sample_index % SET_SIZE), bits >> 18u);
    return owen_scramble(sobol_digits(shuffled.xy), bits >> 25u);
}

// Owen scrambling by a hash in which no bit depends on higher bits (Laine and Karras 2011; constants: Vegdahl 2021).
// The numbers have reversed digits: the most significant digit is the lowest bit. A result is uniform if the lower half
// of `seed` is uniform for a given upper half.
uvec4 hashed_owen_scramble(uvec4 x, uvec4 seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

// Coordinates x and y, with reversed digits, of the points i.x and i.y below 2^16: first those of i.x, then those of i.y.
uvec4 reversed_sobol(uvec2 i) {
    // The second dimension's generator matrix is Pascal's triangle mod 2. Digit k is the parity of the digits of the
    // number whose positions contain all bits of k.
    uvec2 y = i ^ ((i >> 1u) & 0x5555u);
    y ^= (y >> 2u) & 0x3333u;
    y ^= (y >> 4u) & 0x0f0fu;
    y ^= (y >> 8u) & 0x00ffu;
    return uvec4(i.x, y.x, i.y, y.y);
}

// First 16 digits of four random numbers of the point `number`, below 2^16, of a sequence. `bits` are random and equal
// for the whole sequence. The second pair of numbers follows the sequence in an order of its own.
uvec4 sequence_digits(uint number, uvec4 bits) {
    uint reversed = bitfieldReverse(number) >> 16u;
    uvec4 shuffled = hashed_owen_scramble(uvec4(reversed), uvec4((bits.z >> 16u) | (bits.w & 0xffff0000u)));
    uint other = bitfieldReverse(shuffled.x) >> 16u;
    return bitfieldReverse(hashed_owen_scramble(reversed_sobol(uvec2(number, other)), bits)) >> 16u;
}

#endif
