// Samples in sets of eight that cover unit squares evenly: the first eight points of the first two dimensions of Sobol's
// sequence (Sobol' 1967), a (0, 3, 2)-net, so that every elementary interval of an eighth of the square holds one of them.
// Owen's scrambling (Owen 1995) makes each point uniform and keeps the net. Two nets lie side by side, in orders that nothing
// but chance relates ("padding"; Kollig and Keller 2002).
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

#endif
