// Learner irradiance-sarsa: expected SARSA (Eq. 5) at a constant cost, for the product sampler. A Lambertian surface
// scatters albedo / pi times the irradiance of the hemisphere above it. The normalization grid holds this irradiance
// for the normal's bin.
#ifndef IRRADIANCE_SARSA_GLSL
#define IRRADIANCE_SARSA_GLSL
#include "path/guiding.glsl"

bool is_lambertian(Bsdf b) {
    return is_kind(b, BSDF_DIFFUSE) && !is_coated(b);
}

// Whether the normalization grid determines the radiance that the surface scatters. Other surfaces learn as with SARSA.
bool knows_scattered(Scatterer x, Guide guide) {
    return is_guided(guide) && is_lambertian(x.bsdf) && x.wo.z > 0.0;
}

float target_irradiance_sarsa(vec3 light, Scatterer x, Guide guide) {
    return mean_rgb(light) + mean_rgb(x.bsdf.color0) * mean_radiance(guide);
}

#endif
