// Textures: colors that vary over a surface, and the material parameters that they multiply. Specialization removes the
// code for formats, filters and wrap modes that no texture of the scene uses.
#ifndef TEXTURES_GLSL
#define TEXTURES_GLSL
#include "bsdf/material.glsl"
#include "shared/records.glsl"
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
    mat4 colors = fetch_taps(s, taps);
    return mix(mix(colors[0], colors[1], taps.fraction.x), mix(colors[2], colors[3], taps.fraction.x), taps.fraction.y);
}

// Color of a checkerboard. Each color covers half a unit in u and v.
vec4 sample_checkerboard(TextureSampler s) {
    bvec2 second = greaterThan(s.uv - floor(s.uv), vec2(0.5));
    return texture_colors(s.index, second.x == second.y ? 0u : 1u);
}

// Linear color and alpha of a texture at the surface's coordinates `uv`.
vec4 sample_texture(uint index, vec2 uv) {
    TextureSampler s = texture_sampler(index, uv);
    vec4 color = vec4(1.0);
    if (has_textures(TEXTURE_SRGB_BYTES | TEXTURE_LINEAR_BYTES | TEXTURE_HALVES | TEXTURE_HEIGHTS)) color = sample_image(s);
    if (has_textures(TEXTURE_CHECKERBOARD) && (s.kind & TEXTURE_CHECKERBOARD) != 0u) color = sample_checkerboard(s);
    return color;
}

// Derivative of an image's luminance by the surface's coordinates. As in Mitsuba, the slope counts texels after the map
// from the surface's coordinates. Where that map rotates an image that is not square, the slope is therefore rotated,
// too.
vec2 texture_gradient(uint index, vec2 uv) {
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

// Bits of TEXTURED_PARAMETERS that stand for colors.
const uint COLOR_PARAMETERS = (1u << PARAMETER_SCALAR0) - 1u;

// Multiplies one component of a vector by a factor.
void scale_component(inout vec4 numbers, uint component, float factor) {
    numbers *= mix(vec4(1.0), vec4(factor), equal(uvec4(component), uvec4(0u, 1u, 2u, 3u)));
}

void scale_parameter(inout Bsdf b, uint parameter, vec3 color) {
    const vec3 one = vec3(1.0);
    if (is_textured(PARAMETER_COLOR0)) b.color0 *= parameter == PARAMETER_COLOR0 ? color : one;
    if (is_textured(PARAMETER_COLOR0 + 1u)) b.color1 *= parameter == PARAMETER_COLOR0 + 1u ? color : one;
    if (is_textured(PARAMETER_COLOR0 + 2u)) b.color2 *= parameter == PARAMETER_COLOR0 + 2u ? color : one;
    if ((TEXTURED_PARAMETERS & ~COLOR_PARAMETERS) == 0u) return;
    float number = luminance(color);
    uint scalar = parameter - PARAMETER_SCALAR0;
    scale_component(b.scalars0, scalar, number);
    scale_component(b.scalars1, scalar - 4u, number);
    scale_component(b.scalars2, scalar - 8u, number);
}

// Multiplies each textured parameter of a material: a color by the texture's color, a scalar by the luminance of that
// color.
void apply_textures(inout Bsdf b, uint material, vec2 uv) {
    bool more = true;
    for (uint i = 0u; i < MAX_TEXTURE_LINKS && more; ++i) {
        uint link = material_links(material, i / 4u)[i % 4u];
        more = link != NONE;
        vec3 color = sample_texture(more ? link & ((1u << LINK_PARAMETER_SHIFT) - 1u) : 0u, uv).rgb;
        if (more) scale_parameter(b, link >> LINK_PARAMETER_SHIFT, color);
    }
}

#endif
