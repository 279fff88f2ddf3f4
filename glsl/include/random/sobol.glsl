// Samples in sets of eight that cover unit squares evenly: the first eight points of the first two dimensions of Sobol's
// sequence (Sobol' 1967), a (0, 3, 2)-net, so that every elementary interval of an eighth of the square holds one of them.
// Owen's scrambling (Owen 1995) makes each point uniform and keeps the net. Two nets lie side by side, in orders that nothing
// but chance relates ("padding"; Kollig and Keller 2002).
//
// Camera rays go on along the sequence itself, of which every stretch of 2^n points, from a multiple of 2^n on, is a net.
#ifndef SOBOL_GLSL
#define SOBOL_GLSL

const uint SET_SIZE = 8u;

// Scrambles numbers of three binary digits: each digit is flipped or not, as one of seven random bits says that the digits
// before it choose.
uvec4 owen_scramble(uvec4 x, uvec4 flips) {
    uvec4 flip0 = flips & 1u;
    uvec4 flip1 = (flips >> (1u + (x >> 2u))) & 1u;
    uvec4 flip2 = (flips >> (3u + (x >> 1u))) & 1u;
    return x ^ ((flip0 << 2u) | (flip1 << 1u) | flip2);
}

// Of those seven bits, the ones that the digits of 0 meet.
const uint FLIPS_OF_ZERO = 0xbu;

// The first three binary digits of both coordinates of the points of these numbers in [0, 8): of x.xy, then of x.zw.
uvec4 sobol_digits(uvec2 i) {
    // Of the first dimension, the number's digits in reverse (van der Corput).
    uvec2 x = ((i & 1u) << 2u) | (i & 2u) | (i >> 2u);
    uvec2 y = x ^ ((((i >> 1u) ^ (i >> 2u)) & 1u) << 2u);
    return uvec4(x.x, y.x, x.y, y.y);
}

// The first three digits of four numbers of the sample of this index; `bits` are random and the same for all of a set.
uvec4 set_digits(uint sample_index, uvec4 bits) {
    uvec4 shuffled = owen_scramble(uvec4(sample_index % SET_SIZE), bits >> 18u);
    return owen_scramble(sobol_digits(shuffled.xy), bits >> 25u);
}

// Owen's scrambling by a hash of which no bit depends on higher ones (Laine and Karras 2011; constants: Vegdahl 2021), of
// numbers whose most significant digit is the lowest bit. Each is uniform if the lower half of `seed` is, given the upper.
uvec4 hashed_owen_scramble(uvec4 x, uvec4 seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

// Both coordinates of the points of these numbers, below 2^16, digits in reverse: of i.x, then of i.y.
uvec4 reversed_sobol(uvec2 i) {
    // A digit of the second is the parity of those of the number whose places have all bits of its own: Pascal's triangle.
    uvec2 y = i ^ ((i >> 1u) & 0x5555u);
    y ^= (y >> 2u) & 0x3333u;
    y ^= (y >> 4u) & 0x0f0fu;
    y ^= (y >> 8u) & 0x00ffu;
    return uvec4(i.x, y.x, i.y, y.y);
}

// The first 16 digits of four numbers of the point of this number, below 2^16, in a sequence; `bits` are random and the same for
// all of it. The second pair comes in an order of its own.
uvec4 sequence_digits(uint number, uvec4 bits) {
    uint reversed = bitfieldReverse(number) >> 16u;
    uvec4 shuffled = hashed_owen_scramble(uvec4(reversed), uvec4((bits.z >> 16u) | (bits.w & 0xffff0000u)));
    uint other = bitfieldReverse(shuffled.x) >> 16u;
    return bitfieldReverse(hashed_owen_scramble(reversed_sobol(uvec2(number, other)), bits)) >> 16u;
}

#endif
