// A smooth dielectric layer over any surface that reflects (Weidlich and Wilkie 2007), as Mitsuba 0.6's `coating`: light that
// the layer reflects back inwards is lost.
#ifndef COATING_GLSL
#define COATING_GLSL
#include "bsdf/parameters.glsl"
#include "math/fresnel.glsl"

// One direction, as the layer takes it in.
struct CoatedDirection {
    vec3 inside;        // refracted; on the same side
    float reflectance;  // of the layer
};

CoatedDirection enter_coating(Coating c, vec3 w) {
    DielectricInterface i = fresnel_dielectric(abs(w.z), c.eta);
    return CoatedDirection(vec3(w.xy / c.eta, w.z < 0.0 ? -i.cos_t : i.cos_t), i.reflectance);
}

// A direction from inside, as it leaves the layer; zero where all light is reflected.
vec3 leave_coating(Coating c, vec3 w) {
    DielectricInterface i = fresnel_dielectric(abs(w.z), 1.0 / c.eta);
    vec3 outside = vec3(w.xy * c.eta, w.z < 0.0 ? -i.cos_t : i.cos_t);
    return i.reflectance < 1.0 ? normalize(outside) : vec3(0.0);
}

// Probability that a sample is the layer's reflection: it is likelier the more the layer absorbs.
float coating_probability(Coating c, CoatedDirection wo) {
    float passing = mean_rgb(exp(-2.0 * c.optical_thickness));
    float specular = wo.reflectance;
    float nested = (1.0 - wo.reflectance) * passing;
    return specular / max(specular + nested, 1.0e-20);
}

// Share of the light that passes the layer both ways.
vec3 coating_transmittance(Coating c, CoatedDirection wo, CoatedDirection wi) {
    float paths = 1.0 / max(abs(wo.inside.z), 1.0e-6) + 1.0 / max(abs(wi.inside.z), 1.0e-6);
    return (1.0 - wo.reflectance) * (1.0 - wi.reflectance) * exp(-paths * c.optical_thickness);
}

// Solid angle inside the layer per solid angle outside.
float coating_jacobian(Coating c, vec3 wi, CoatedDirection refracted) {
    return abs(wi.z) / (c.eta * c.eta * max(abs(refracted.inside.z), 1.0e-6));
}

// The sample of the coated surface, given its probability, from that of the one inside.
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
    // A guide knows directions outside the layer only.
    if (nested.lobe == LOBE_DIFFUSE) nested.lobe = LOBE_GLOSSY;
    return nested;
}

#endif
