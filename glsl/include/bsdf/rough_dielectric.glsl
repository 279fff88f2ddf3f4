// Rough surface with microfacets between two dielectrics (Walter et al. 2007).
#ifndef BSDF_ROUGH_DIELECTRIC_GLSL
#define BSDF_ROUGH_DIELECTRIC_GLSL
#include "bsdf/dielectric.glsl"
#include "math/fresnel.glsl"
#include "math/microfacet.glsl"

// Number of the kind.
const uint BSDF_ROUGH_DIELECTRIC = 4u;

// Samples reflection or refraction. `m` is a visible normal.
BsdfSample sample_bsdf_rough_dielectric(Dielectric b, vec3 wo, vec3 m, vec3 u, Film film) {
    float cos_o = dot(wo, m);
    DielectricInterface i = filmed_interface(cos_o, b.eta, film);
    bool reflects = u.z < i.reflectance;
    vec3 refracted = m * (cos_o / i.eta - (cos_o > 0.0 ? i.cos_t : -i.cos_t)) - wo / i.eta;
    vec3 wi = reflects ? reflect(-wo, m) : refracted;
    bool crosses = wo.z * wi.z < 0.0;
    // Rounding may turn a facet that is seen edge-on away from `wo`.
    bool valid = wo.z * wi.z != 0.0 && crosses != reflects && cos_o * wo.z > 0.0;
    return BsdfSample(wi, valid ? LOBE_GLOSSY : LOBE_NONE, vec3(0.0), reflects ? 1.0 : i.eta);
}

// Jacobian of transmission, without two factors: the solid angle of facet normals per solid angle of transmitted
// directions is this value times eta^2 |wi.m|. The value is 0 where a facet with the normal `m` does not transmit
// between the directions.
float transmitted_jacobian(vec3 wo, vec3 wi, vec3 m, float eta) {
    float cos_o = dot(wo, m);
    float cos_i = dot(wi, m);
    float sum = cos_o + eta * cos_i;
    return cos_o * wo.z > 0.0 && cos_i * wi.z > 0.0 ? 1.0 / max(sum * sum, 1.0e-20) : 0.0;
}

float pdf_bsdf_rough_dielectric(Dielectric b, vec3 wo, vec3 wi, Facet f, Film film) {
    float cos_o = dot(wo, f.m);
    DielectricInterface i = filmed_interface(cos_o, b.eta, film);
    float transmitted = f.density / f.area * abs(cos_o * dot(wi, f.m)) * (i.eta * i.eta) * transmitted_jacobian(wo, wi, f.m, i.eta);
    float side = wo.z * wi.z;
    if (side > 0.0) return i.reflectance * reflected_density(f);
    return side < 0.0 ? (1.0 - i.reflectance) * transmitted : 0.0;
}

// f |cos wi|. The square of eta in the Jacobian cancels with the growth of radiance in the denser medium.
vec3 eval_bsdf_rough_dielectric(Dielectric b, vec3 wo, vec3 wi, Facet f, Film film, Filmed filmed) {
    float cos_o = dot(wo, f.m);
    DielectricInterface i = fresnel_dielectric(cos_o, b.eta);
    vec3 reflectance = filmed_reflectance(i, film, filmed);
    float transmitted = f.density * f.masking * abs(cos_o * dot(wi, f.m)) * transmitted_jacobian(wo, wi, f.m, i.eta);
    float side = wo.z * wi.z;
    if (side > 0.0) return b.specular_reflectance * (reflectance * reflected_light(f));
    return side < 0.0 ? b.specular_transmittance * ((1.0 - reflectance) * transmitted) : vec3(0.0);
}

// A dielectric keeps samples for the side that the guide's hemisphere does not reach.
float guided_part_bsdf_rough_dielectric(Facets b) {
    return GUIDE_SET == GUIDE_SET_ALL ? 0.5 * guided_roughness(b) : 0.9;
}

#endif
