// Russian roulette: the probability with which a path goes on. It may depend on all that the path has met: survivors weigh
// more, so the mean stays.
#ifndef ROULETTE_GLSL
#define ROULETTE_GLSL
#include "path/guiding.glsl"

// Largest probability of survival by throughput, and of any survival from edge SURE_ROULETTE_DEPTH on.
const float MOST_SURVIVAL = 0.95;

// Roulette by expected contribution (Vorba and Krivanek 2016, "Adjoint-Driven Russian Roulette and Splitting in Light
// Transport Simulation") compares what a path may still bring to its pixel with the pixel's estimate. A path that may bring
// this part of the estimate always survives. The part is small because both numbers are coarse.
const float SAFE_PART = 0.4;
// Least probability of survival by contribution: it bounds what a survivor's weight gains where the guide is wrong.
const float LEAST_SURVIVAL = 0.05;
// Least mean radiance that a guide knows. A record that has met no light holds a number far below this in place of 0.
const float LEAST_KNOWN = 1.0e-30;

// Survival by throughput, from edge RR_DEPTH on. Radiance grows by eta^2 when it enters a medium: the factor undoes that.
float survival_by_throughput(vec3 throughput, float eta, uint depth) {
    return depth < RR_DEPTH ? 1.0 : min(max_component(throughput) * eta * eta, MOST_SURVIVAL);
}

// The guide knows what the direction may bring.
bool knows_contribution(Guide guide, DirectionSample next) {
    return ROULETTE == ROULETTE_CONTRIBUTION && is_guided(guide) && next.pdf > 0.0 && mean_radiance(guide) > LEAST_KNOWN;
}

// Radiance that a surface is expected to add to a path of this throughput: the mean radiance around it times its albedo.
float expected_scattered(vec3 throughput, Scatterer scatterer, Guide guide) {
    return mean_rgb(throughput * bsdf_albedo(scatterer.bsdf)) * mean_radiance(guide);
}

// Survival by contribution. A sample is expected to bring its throughput times its weight f cos / pdf times the radiance L of
// its bin. The mean radiance is added to L, so that paths into a bin that has met no light yet survive.
float survival_by_contribution(vec3 throughput, Guide guide, DirectionSample next, float pixel_estimate) {
    float contribution = mean_rgb(throughput * next.weight) * (next.radiance + mean_radiance(guide));
    return clamp(contribution / max(SAFE_PART * pixel_estimate, 1.0e-30), LEAST_SURVIVAL, 1.0);
}

#endif
