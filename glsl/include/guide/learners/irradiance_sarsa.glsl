// Learner irradiance-sarsa: expected SARSA (Eq. 5) at a constant cost, for the product sampler. A Lambertian surface
// scatters albedo / pi times the irradiance of the hemisphere above it. The normalization grid holds this irradiance
// for the normal's bin.
#ifndef IRRADIANCE_SARSA_GLSL
#define IRRADIANCE_SARSA_GLSL
#include "path/guiding.glsl"

bool is_lambertian(Bsdf bsdf) {
    return is_kind(bsdf, BSDF_DIFFUSE) && !is_coated(bsdf);
}

// Whether the normalization grid determines the radiance that the surface scatters. Other surfaces learn as with SARSA.
bool knows_scattered(Scatterer scatterer, Guide guide) {
    return is_guided(guide) && is_lambertian(scatterer.bsdf) && scatterer.wo.z > 0.0;
}

float target_irradiance_sarsa(vec3 light, Scatterer scatterer, Guide guide) {
    return mean_rgb(light) + mean_rgb(scatterer.bsdf.color0) * mean_radiance(guide);
}

#endif
