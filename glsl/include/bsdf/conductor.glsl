// Smooth metal.
#ifndef BSDF_CONDUCTOR_GLSL
#define BSDF_CONDUCTOR_GLSL
#include "bsdf/film.glsl"
#include "bsdf/parameters.glsl"
#include "math/fresnel.glsl"

// Number of the kind.
const uint BSDF_CONDUCTOR = 5u;

// Parameters of all metals. With eta = k = 0 a metal reflects all light.
struct Conductor {
    COLOR(0) vec3 specular_reflectance;  // factor of reflection
    COLOR(1) vec3 eta;                   // real part of the index of refraction
    COLOR(2) vec3 k;                     // imaginary part of the index of refraction
};

// Reflectance of a metal.
vec3 conductor_reflectance(Conductor b, float cos_o, Film film, Filmed filmed) {
    return is_filmed(film) ? filmed.facet : fresnel_conductor(cos_o, b.eta, b.k);
}

BsdfSample sample_bsdf_conductor(Conductor b, vec3 wo, vec3 u, Film film, Filmed filmed) {
    vec3 weight = b.specular_reflectance * conductor_reflectance(b, wo.z, film, filmed);
    return BsdfSample(vec3(-wo.xy, wo.z), wo.z > 0.0 ? LOBE_DELTA : LOBE_NONE, weight, 1.0);
}

#endif
