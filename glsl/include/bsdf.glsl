// The switch over the kinds of material. Directions are in the local frame of `basis_from_normal` of the facing normal.
#ifndef BSDF_GLSL
#define BSDF_GLSL
#include "bsdf_diffuse.glsl"
#include "frame.glsl"

const uint MATERIAL_KIND_MASK = 0xffu;
const uint MATERIAL_TWO_SIDED = 0x100u;

bool is_two_sided(Material m) {
    return (m.kind_and_sides & MATERIAL_TWO_SIDED) != 0u;
}

// Share of the light that is scattered, for the albedo layer.
vec3 bsdf_albedo(Material m) {
    return m.reflectance;
}

vec3 sample_bsdf(Material m, vec2 u) {
    return sample_bsdf_diffuse(u);
}

float pdf_bsdf(Material m, vec3 wi) {
    return pdf_bsdf_diffuse(wi);
}

// f times the cosine, both below and above the surface.
vec3 eval_bsdf(Material m, vec3 wi) {
    return eval_bsdf_diffuse(m.reflectance, wi);
}

#endif
