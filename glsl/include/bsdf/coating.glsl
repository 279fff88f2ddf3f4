// Smooth dielectric coating over any reflecting surface (Weidlich and Wilkie 2007), as in Mitsuba 0.6's `coating`.
// Light that the coating reflects back inwards is lost.
#ifndef COATING_GLSL
#define COATING_GLSL
#include "bsdf/parameters.glsl"
#include "math/constants.glsl"
#include "math/fresnel.glsl"

// Direction that crosses the coating.
struct CoatedDirection {
    vec3 inside;        // refracted direction, on the same side of the surface
    float reflectance;  // Fresnel reflectance of the coating
};

CoatedDirection enter_coating(Coating c, vec3 w) {
    DielectricInterface i = fresnel_dielectric(abs(w.z), c.eta);
    return CoatedDirection(vec3(w.xy / c.eta, w.z < 0.0 ? -i.cos_t : i.cos_t), i.reflectance);
}

// Direction above the coating for a direction below it; zero where all light is reflected.
vec3 leave_coating(Coating c, vec3 w) {
    DielectricInterface i = fresnel_dielectric(abs(w.z), 1.0 / c.eta);
    vec3 outside = vec3(w.xy * c.eta, w.z < 0.0 ? -i.cos_t : i.cos_t);
    return i.reflectance < 1.0 ? normalize(outside) : vec3(0.0);
}

// Probability that a sample is the coating's specular reflection. It grows with the absorption of the coating.
float coating_probability(Coating c, CoatedDirection wo) {
    float passing = mean_rgb(exp(-2.0 * c.optical_thickness));
    float specular = wo.reflectance;
    float nested = (1.0 - wo.reflectance) * passing;
    // A device may round the quotient above 1.
    return min(specular / max(specular + nested, 1.0e-20), 1.0);
}

// Share of the light that passes the coating in both directions.
vec3 coating_transmittance(Coating c, CoatedDirection wo, CoatedDirection wi) {
    float paths = 1.0 / max(abs(wo.inside.z), 1.0e-6) + 1.0 / max(abs(wi.inside.z), 1.0e-6);
    return (1.0 - wo.reflectance) * (1.0 - wi.reflectance) * exp(-paths * c.optical_thickness);
}

// Solid angle below the coating per solid angle above it.
float coating_jacobian(Coating c, vec3 wi, CoatedDirection refracted) {
    return abs(wi.z) / (c.eta * c.eta * max(abs(refracted.inside.z), 1.0e-6));
}

// Sample of the coated surface, from a sample of the surface below. `probability` is that of the specular reflection.
BsdfSample sample_coating(Coating c, vec3 wo, CoatedDirection entered, BsdfSample nested, float probability, bool specular) {
    if (specular) {
        vec3 weight = c.specular_reflectance * (entered.reflectance / max(probability, 1.0e-20));
        return BsdfSample(vec3(-wo.xy, wo.z), LOBE_DELTA, weight, 1.0);
    }
    vec3 inside = nested.wi;
    nested.wi = leave_coating(c, inside);
    if (nested.lobe == LOBE_NONE || nested.wi.z == 0.0) return NO_BSDF_SAMPLE;
    CoatedDirection wi = CoatedDirection(inside, fresnel_dielectric(abs(inside.z), 1.0 / c.eta).reflectance);
    nested.weight *= coating_transmittance(c, entered, wi) / max(1.0 - probability, 1.0e-20);
    // A guide knows only directions above the coating, so it must not replace the diffuse lobe below.
    if (nested.lobe == LOBE_DIFFUSE) nested.lobe = LOBE_GLOSSY;
    return nested;
}

#endif
