// Texture lookup: the texels that a position needs, and the decoding of texels. The functions read no memory.
#ifndef TEXTURE_LOOKUP_GLSL
#define TEXTURE_LOOKUP_GLSL
#include "math/constants.glsl"
#include "shared/variant.glsl"

// Four texels and the weights of their bilinear mix.
struct Taps {
    uvec2 low;       // column and row of the upper left texel
    uvec2 high;      // column and row of the lower right texel
    vec2 fraction;   // weights of the right column and of the lower row
    vec2 direction;  // direction of columns and rows as u and v grow: 1, or -1 in a mirrored copy
};

// Coordinates u and v within the image, in [0, 1], after wrapping. `direction` is -1 on a mirrored copy and 1
// elsewhere.
vec2 wrap(uint kind, vec2 uv, out vec2 direction) {
    direction = vec2(1.0);
    vec2 repeated = uv - floor(uv);
    if (has_textures(TEXTURE_MIRROR) && (kind & TEXTURE_MIRROR) != 0u) {
        vec2 period = uv - 2.0 * floor(0.5 * uv);
        direction = mix(vec2(1.0), vec2(-1.0), greaterThan(period, vec2(1.0)));
        return min(period, 2.0 - period);
    }
    return has_textures(TEXTURE_CLAMP) && (kind & TEXTURE_CLAMP) != 0u ? clamp(uv, 0.0, 1.0) : repeated;
}

// Texel at a position that is at most one texel outside the image.
uvec2 wrap_texel(uint kind, ivec2 texel, ivec2 size) {
    ivec2 repeated = mix(texel, texel + size, lessThan(texel, ivec2(0)));
    repeated = mix(repeated, repeated - size, greaterThanEqual(repeated, size));
    bool repeats = has_textures(TEXTURE_REPEAT) && (kind & TEXTURE_REPEAT) != 0u;
    // The clamp applies to every wrap mode, because the coordinates may be NaN.
    return uvec2(clamp(repeats ? repeated : texel, ivec2(0), size - 1));
}

// Texels and weights for a lookup. The center of texel i lies at (i + 1/2) / size.
Taps texture_taps(uint kind, uvec2 size, vec2 uv) {
    Taps taps;
    vec2 position = wrap(kind, uv, taps.direction) * vec2(size);
    bool nearest = has_textures(TEXTURE_NEAREST) && (kind & TEXTURE_NEAREST) != 0u;
    if (!nearest) position -= 0.5;
    vec2 low = floor(position);
    taps.fraction = nearest ? vec2(0.0) : position - low;
    taps.low = wrap_texel(kind, ivec2(low), ivec2(size));
    taps.high = nearest ? taps.low : wrap_texel(kind, ivec2(low) + 1, ivec2(size));
    return taps;
}

// Inverse of the sRGB curve (IEC 61966-2-1). The power is a polynomial with an error of at most 6e-6 at each of the 256
// byte values, and of at most 8e-6 between them.
vec3 decode_srgb(vec3 s) {
    vec3 power = vec3(-0.05466098);
    power = power * s + 0.22672586;
    power = power * s - 0.43458080;
    power = power * s + 0.71700174;
    power = power * s + 0.51145685;
    power = power * s + 0.03313727;
    power = power * s + 0.00091467;
    return mix(power, s / 12.92, lessThanEqual(s, vec3(0.04045)));
}

// Color of a texel from its words. Only an image of halves has a second word.
vec4 decode_texel(uint kind, uvec2 words, float scale) {
    vec4 color = vec4(0.0);
    if (has_textures(TEXTURE_SRGB_BYTES | TEXTURE_LINEAR_BYTES)) color = unpackUnorm4x8(words.x);
    if (has_textures(TEXTURE_SRGB_BYTES) && (kind & TEXTURE_SRGB_BYTES) != 0u) color.rgb = decode_srgb(color.rgb);
    if (has_textures(TEXTURE_HALVES) && (kind & TEXTURE_HALVES) != 0u) {
        color = scale * vec4(unpackHalf2x16(words.x), unpackHalf2x16(words.y));
    }
    if (has_textures(TEXTURE_HEIGHTS) && (kind & TEXTURE_HEIGHTS) != 0u) {
        color = vec4(vec3(uintBitsToFloat(words.x)), 1.0);
    }
    return color;
}

// Divisor in place of an alpha of zero.
const float TINY_ALPHA = 1.0e-20;

// Texel whose color is multiplied by its alpha, if it is encoded.
vec4 covered_texel(bool encoded, vec4 texel) {
    return encoded ? vec4(texel.rgb * texel.a, texel.a) : texel;
}

// Color and alpha between four texels, one per column: upper left, upper right, lower left, lower right. Encoded colors count by
// their alpha, and their mix is decoded, as in Cycles.
vec4 mix_texels(uint kind, mat4 colors, vec2 fraction) {
    bool encoded = has_textures(TEXTURE_ENCODED) && (kind & TEXTURE_ENCODED) != 0u;
    vec4 upper = mix(covered_texel(encoded, colors[0]), covered_texel(encoded, colors[1]), fraction.x);
    vec4 lower = mix(covered_texel(encoded, colors[2]), covered_texel(encoded, colors[3]), fraction.x);
    vec4 color = mix(upper, lower, fraction.y);
    if (encoded) color.rgb = decode_srgb(color.rgb / max(color.a, TINY_ALPHA));
    return color;
}

#endif
