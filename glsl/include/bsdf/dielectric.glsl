// Smooth surface between two dielectrics.
#ifndef BSDF_DIELECTRIC_GLSL
#define BSDF_DIELECTRIC_GLSL
#include "bsdf/film.glsl"
#include "bsdf/parameters.glsl"
#include "math/fresnel.glsl"

// Number of the kind.
const uint BSDF_DIELECTRIC = 2u;

// Parameters of all dielectrics.
struct Dielectric {
    COLOR(0) vec3 specular_reflectance;    // factor of reflection
    COLOR(1) vec3 specular_transmittance;  // factor of transmission
    SCALAR(2) float eta;                   // index of refraction, interior over exterior
};

// Samples reflection or refraction. Radiance that enters a denser medium is concentrated in a smaller solid angle; the
// weight therefore contains the square of eta.
BsdfSample sample_bsdf_dielectric(Dielectric b, vec3 wo, vec3 u, Film film, Filmed filmed) {
    DielectricInterface i = filmed_interface(wo.z, b.eta, film);
    uint lobe = wo.z != 0.0 ? LOBE_DELTA : LOBE_NONE;
    if (u.z < i.reflectance) {
        vec3 reflected = b.specular_reflectance;
        if (is_filmed(film)) reflected *= filmed.facet / i.reflectance;
        return BsdfSample(vec3(-wo.xy, wo.z), lobe, reflected, 1.0);
    }
    vec3 wi = vec3(-wo.xy / i.eta, wo.z > 0.0 ? -i.cos_t : i.cos_t);
    vec3 transmitted = b.specular_transmittance / (i.eta * i.eta);
    if (is_filmed(film)) transmitted *= (1.0 - filmed.facet) / (1.0 - i.reflectance);
    return BsdfSample(wi, lobe, transmitted, i.eta);
}

// The light that comes through from behind the surface: its direction, and the share of the radiance that arrives.
BsdfSample refracted(Dielectric b, vec3 wo) {
    DielectricInterface i = fresnel_dielectric(wo.z, b.eta);
    vec3 wi = vec3(-wo.xy / i.eta, wo.z > 0.0 ? -i.cos_t : i.cos_t);
    vec3 share = wo.z != 0.0 ? b.specular_transmittance * ((1.0 - i.reflectance) / (i.eta * i.eta)) : vec3(0.0);
    return BsdfSample(wi, LOBE_DELTA, share, i.eta);
}

#endif
