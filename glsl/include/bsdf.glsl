// The switch over the kinds of scattering function. Directions are unit vectors in the local frame whose z-axis is the
// shading normal, on the side of `wo` where a surface is two-sided. Of each kind there is a triple: sample_bsdf_x draws a
// direction, pdf_bsdf_x is its density per steradian (without what is concentrated in single directions), eval_bsdf_x is
// f times |cos| (likewise).
//
// A diffuse lobe may be sampled by a guide instead: then `diffuse_density`, the density of `wi` under that lobe's sampler, is the
// guide's; otherwise it is pdf_cosine_hemisphere(wi.z).
#ifndef BSDF_GLSL
#define BSDF_GLSL
#include "bsdf_diffuse.glsl"

// Share of the light that is scattered, for the albedo layer.
vec3 bsdf_albedo(Bsdf b) {
    return b.color0;
}

// u.xy draws the direction, u.z the lobe.
BsdfSample sample_bsdf(Bsdf b, vec3 wo, vec3 u) {
    BsdfSample s = NO_BSDF_SAMPLE;
    if (is_kind(b, BSDF_DIFFUSE)) s = sample_bsdf_diffuse(b, wo, u);
    return s;
}

float pdf_bsdf(Bsdf b, vec3 wo, vec3 wi, float diffuse_density) {
    float pdf = 0.0;
    if (is_kind(b, BSDF_DIFFUSE)) pdf = pdf_bsdf_diffuse(b, wo, wi, diffuse_density);
    return pdf;
}

vec3 eval_bsdf(Bsdf b, vec3 wo, vec3 wi) {
    vec3 f = vec3(0.0);
    if (is_kind(b, BSDF_DIFFUSE)) f = eval_bsdf_diffuse(b, wo, wi);
    return f;
}

#endif
