// Images and patterns: colors that vary over a surface. Specialization removes the code for formats, filters and wrap modes that no
// texture of the scene uses.
#ifndef PATTERN_GLSL
#define PATTERN_GLSL
#include "film/frame.glsl"
#include "math/constants.glsl"
#include "texture/texture_lookup.glsl"

struct TextureSampler {
    uint index;
    uint kind;
    uint address;
    uvec2 size;
    vec2 uv;        // coordinates on the texture
    mat2 from_surface;
    float scale;
};

TextureSampler texture_sampler(uint index, vec2 uv) {
    TextureSampler s = TextureSampler(
        index, texture_kind(index), texture_address(index), texture_size(index), uv, mat2(1.0), 1.0);
    if (has_textures(TEXTURE_TRANSFORMED | TEXTURE_HALVES)) {
        s.scale = texture_scale(index);
        if (has_textures(TEXTURE_TRANSFORMED)) {
            vec3 u_row = texture_u_row(index);
            vec3 v_row = texture_v_row(index);
            s.uv = vec2(dot(u_row, vec3(uv, 1.0)), dot(v_row, vec3(uv, 1.0)));
            s.from_surface = mat2(u_row.x, v_row.x, u_row.y, v_row.y);
        }
    }
    return s;
}

vec4 fetch_texel(TextureSampler s, uint column, uint row) {
    uint texel = row * s.size.x + column;
    bool halves = has_textures(TEXTURE_HALVES) && (s.kind & TEXTURE_HALVES) != 0u;
    uint address = s.address + (halves ? 2u * texel : texel);
    uvec2 words = uvec2(texel_word(address), 0u);
    if (has_textures(TEXTURE_HALVES)) words.y = texel_word(halves ? address + 1u : address);
    return decode_texel(s.kind, words, s.scale);
}

// Colors of the four texels, one per column: upper left, upper right, lower left, lower right.
mat4 fetch_taps(TextureSampler s, Taps taps) {
    return mat4(fetch_texel(s, taps.low.x, taps.low.y), fetch_texel(s, taps.high.x, taps.low.y),
                fetch_texel(s, taps.low.x, taps.high.y), fetch_texel(s, taps.high.x, taps.high.y));
}

vec4 sample_image(TextureSampler s) {
    Taps taps = texture_taps(s.kind, s.size, s.uv);
    if (!has_textures(TEXTURE_BILINEAR)) return fetch_texel(s, taps.low.x, taps.low.y);
    return mix_texels(s.kind, fetch_taps(s, taps), taps.fraction);
}

// Color of a checkerboard. Each color covers half a unit in u and v.
vec4 sample_checkerboard(TextureSampler s) {
    bvec2 second = greaterThan(s.uv - floor(s.uv), vec2(0.5));
    return texture_colors(s.index, second.x == second.y ? 0u : 1u);
}

// Linear color and alpha of an image or a pattern at the surface's coordinates `uv`.
vec4 sample_pattern(uint index, vec2 uv) {
    TextureSampler s = texture_sampler(index, uv);
    vec4 color = vec4(1.0);
    if (has_textures(TEXTURE_SRGB_BYTES | TEXTURE_LINEAR_BYTES | TEXTURE_HALVES | TEXTURE_HEIGHTS)) color = sample_image(s);
    if (has_textures(TEXTURE_CHECKERBOARD) && (s.kind & TEXTURE_CHECKERBOARD) != 0u) color = sample_checkerboard(s);
    return color;
}

// Derivative of an image's luminance by the surface's coordinates. As in Mitsuba, the slope counts texels after the map
// from the surface's coordinates. Where that map rotates an image that is not square, the slope is therefore rotated,
// too.
vec2 image_gradient(uint index, vec2 uv) {
    TextureSampler s = texture_sampler(index, uv);
    Taps taps = texture_taps(s.kind, s.size, s.uv);
    mat4 colors = fetch_taps(s, taps);
    vec4 heights = vec4(luminance(colors[0].rgb), luminance(colors[1].rgb), luminance(colors[2].rgb),
                        luminance(colors[3].rgb));
    // The luminance of a gray color is rounded, which would show in the slopes between many texels.
    if (has_textures(TEXTURE_HEIGHTS) && (s.kind & TEXTURE_HEIGHTS) != 0u) {
        heights = vec4(colors[0].r, colors[1].r, colors[2].r, colors[3].r);
    }
    vec2 slope = vec2(mix(heights.y - heights.x, heights.w - heights.z, taps.fraction.y),
                      mix(heights.z - heights.x, heights.w - heights.y, taps.fraction.x));
    return vec2(s.size) * (slope * taps.direction * s.from_surface);
}

#endif
