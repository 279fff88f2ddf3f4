// Smooth surface between two dielectrics.
#ifndef BSDF_DIELECTRIC_GLSL
#define BSDF_DIELECTRIC_GLSL
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
BsdfSample sample_bsdf_dielectric(Dielectric b, vec3 wo, vec3 u) {
    DielectricInterface i = fresnel_dielectric(wo.z, b.eta);
    uint lobe = wo.z != 0.0 ? LOBE_DELTA : LOBE_NONE;
    if (u.z < i.reflectance) return BsdfSample(vec3(-wo.xy, wo.z), lobe, b.specular_reflectance, 1.0);
    vec3 wi = vec3(-wo.xy / i.eta, wo.z > 0.0 ? -i.cos_t : i.cos_t);
    return BsdfSample(wi, lobe, b.specular_transmittance / (i.eta * i.eta), i.eta);
}

// The light that comes through from behind the surface: its direction, and the share of the radiance that arrives.
BsdfSample refracted(Dielectric b, vec3 wo) {
    DielectricInterface i = fresnel_dielectric(wo.z, b.eta);
    vec3 wi = vec3(-wo.xy / i.eta, wo.z > 0.0 ? -i.cos_t : i.cos_t);
    vec3 share = wo.z != 0.0 ? b.specular_transmittance * ((1.0 - i.reflectance) / (i.eta * i.eta)) : vec3(0.0);
    return BsdfSample(wi, LOBE_DELTA, share, i.eta);
}

#endif
