// Small floats: positive numbers in 7 or 8 bits, with three bits of mantissa (relative error at most 1/16) and at least
// four bits of exponent. Sixteen of them fit in four words. A stored weight is never 0.
#ifndef SMALL_FLOATS_GLSL
#define SMALL_FLOATS_GLSL
#include "shared/guide.glsl"

// Biased exponent that the 7-bit code 0 stands for, as BIAS_8 does for 8 bits.
const uint BIAS_7 = 112u;

// Code nearest to `x`, for `x` at most LARGEST_SMALL_FLOAT.
uint small_float(float x, uint bias) {
    uint least = bias << (23u - DROPPED_BITS);
    uint rounded = (floatBitsToUint(max(x, 0.0)) + (1u << (DROPPED_BITS - 1u))) >> DROPPED_BITS;
    return rounded - min(rounded, least);
}

// Values of four 8-bit codes.
vec4 unpack_8(uint word) {
    uvec4 codes = uvec4(word, word >> 8u, word >> 16u, word >> 24u) & 0xffu;
    return uintBitsToFloat((codes << DROPPED_BITS) + (BIAS_8 << 23u));
}

uint pack_8(vec4 x) {
    return small_float(x.x, BIAS_8) | (small_float(x.y, BIAS_8) << 8u) | (small_float(x.z, BIAS_8) << 16u) |
        (small_float(x.w, BIAS_8) << 24u);
}

// Values of four 7-bit codes. The word's upper four bits are free for other use.
vec4 unpack_7(uint word) {
    uvec4 codes = uvec4(word, word >> 7u, word >> 14u, word >> 21u) & 0x7fu;
    return uintBitsToFloat((codes << DROPPED_BITS) + (BIAS_7 << 23u));
}

uint pack_7(vec4 x) {
    return small_float(x.x, BIAS_7) | (small_float(x.y, BIAS_7) << 7u) | (small_float(x.z, BIAS_7) << 14u) |
        (small_float(x.w, BIAS_7) << 21u);
}

// Weights of the 4 x 4 parts of a square, indexed [row][column], from 8-bit codes (unpack_weights_8) or 7-bit codes.
mat4 unpack_weights_8(uvec4 words) {
    return mat4(unpack_8(words.x), unpack_8(words.y), unpack_8(words.z), unpack_8(words.w));
}

mat4 unpack_weights_7(uvec4 words) {
    return mat4(unpack_7(words.x), unpack_7(words.y), unpack_7(words.z), unpack_7(words.w));
}

float largest_weight(mat4 w) {
    vec4 columns = max(max(w[0], w[1]), max(w[2], w[3]));
    return max(max(columns.x, columns.y), max(columns.z, columns.w));
}

// Factor that maps the largest weight to the largest code. It is 0 where no finite factor does so; then all weights are
// equal.
float code_scale(float largest) {
    return largest > 1.0e-36 && largest < 1.0e37 ? LARGEST_SMALL_FLOAT / largest : 0.0;
}

uvec4 pack_weights_8(mat4 w) {
    float scale = code_scale(largest_weight(w));
    return uvec4(pack_8(w[0] * scale), pack_8(w[1] * scale), pack_8(w[2] * scale), pack_8(w[3] * scale));
}

// Packs sixteen weights in 7 bits each. The free bits hold `scalar`, which is not negative, with 8 bits of mantissa.
// The scalar is stored as at least 1e-37, so that a packed record is never all zeros.
uvec4 pack_weights_7(mat4 w, float scalar) {
    float scale = code_scale(largest_weight(w));
    uvec4 words = uvec4(pack_7(w[0] * scale), pack_7(w[1] * scale), pack_7(w[2] * scale), pack_7(w[3] * scale));
    uint bits = (floatBitsToUint(clamp(scalar, 1.0e-37, 3.0e38)) + 0x8000u) >> 16u;
    return words | ((uvec4(bits, bits >> 4u, bits >> 8u, bits >> 12u) & 0xfu) << 28u);
}

float unpack_scalar(uvec4 words) {
    uvec4 nibbles = words >> 28u;
    return uintBitsToFloat((nibbles.x | (nibbles.y << 4u) | (nibbles.z << 8u) | (nibbles.w << 12u)) << 16u);
}

#endif
