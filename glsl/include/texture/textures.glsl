// Textures of surfaces, and the material parameters that they multiply: images, patterns and programs.
#ifndef TEXTURES_GLSL
#define TEXTURES_GLSL
#include "bsdf/material.glsl"
#include "shared/records.glsl"
#include "texture/pattern.glsl"
#include "texture/program.glsl"

bool is_program(uint index) {
    return has_textures(TEXTURE_PROGRAM) && (texture_kind(index) & TEXTURE_PROGRAM) != 0u;
}

// Whether the scene has images or patterns.
bool has_patterns() {
    return (TEXTURE_KINDS & ~TEXTURE_PROGRAM) != 0u;
}

// Linear color and alpha of a texture at a point of a surface.
vec4 sample_texture(uint index, TexturePoint at) {
    if (!has_textures(TEXTURE_PROGRAM)) return sample_pattern(index, at.uv);
    vec4 color = vec4(1.0);
    bool computed = is_program(index);
    if (has_patterns() && !computed) color = sample_pattern(index, at.uv);
    if (computed) color = vec4(run_program(index, at), 1.0);
    return color;
}

// Derivative of a height by the surface's coordinates. `dp_du` and `dp_dv` are the derivatives of the position.
vec2 height_gradient(uint index, TexturePoint at, vec3 dp_du, vec3 dp_dv) {
    if (!has_textures(TEXTURE_PROGRAM)) return image_gradient(index, at.uv);
    vec2 gradient = vec2(0.0);
    bool computed = is_program(index);
    if (has_patterns() && !computed) gradient = image_gradient(index, at.uv);
    if (computed) gradient = program_gradient(index, at, dp_du, dp_dv);
    return gradient;
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
    if (is_textured(PARAMETER_SHEEN_REFLECTANCE)) b.sheen.reflectance *= parameter == PARAMETER_SHEEN_REFLECTANCE ? color : one;
    if (is_textured(PARAMETER_SHEEN_ROUGHNESS)) b.sheen.roughness *= parameter == PARAMETER_SHEEN_ROUGHNESS ? luminance(color) : 1.0;
    if (is_textured(PARAMETER_FILM_THICKNESS)) b.film.thickness *= parameter == PARAMETER_FILM_THICKNESS ? luminance(color) : 1.0;
    if ((TEXTURED_PARAMETERS & ~COLOR_PARAMETERS) == 0u) return;
    float number = luminance(color);
    uint scalar = parameter - PARAMETER_SCALAR0;
    scale_component(b.scalars0, scalar, number);
    scale_component(b.scalars1, scalar - 4u, number);
    scale_component(b.scalars2, scalar - 8u, number);
}

// Multiplies each textured parameter of a material: a color by the texture's color, a scalar by the luminance of that
// color.
void apply_textures(inout Bsdf b, uint material, TexturePoint at) {
    bool more = true;
    for (uint i = 0u; i < MAX_TEXTURE_LINKS && more; ++i) {
        uint link = material_links(material, i / 4u)[i % 4u];
        more = link != NONE;
        vec3 color = sample_texture(more ? link & ((1u << LINK_PARAMETER_SHIFT) - 1u) : 0u, at).rgb;
        if (more) scale_parameter(b, link >> LINK_PARAMETER_SHIFT, color);
    }
}

#endif
