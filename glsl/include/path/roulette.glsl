// Russian roulette: the probability with which a path goes on. It may depend on all that the path has met: survivors weigh
// more, so the mean stays.
#ifndef ROULETTE_GLSL
#define ROULETTE_GLSL
#include "path/guiding.glsl"

// Largest probability of survival by throughput, and of any survival from edge SURE_ROULETTE_DEPTH on.
const float MOST_SURVIVAL = 0.95;

// Roulette by expected contribution (Vorba and Krivanek 2016, "Adjoint-Driven Russian Roulette and Splitting in Light
// Transport Simulation") compares what a path may still bring to its pixel with the pixel's estimate. A path that may bring
// this part of the estimate always survives. The part is small because both numbers are coarse. With emitter sampling it
// is larger, because an ended path brings light in place of what it would have met.
const float SAFE_PART = 0.4;
const float SAFE_PART_WITH_LIGHT = 0.7;
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
    float safe_part = SAFE_PART;
    if (NEE) safe_part = SAFE_PART_WITH_LIGHT;
    return clamp(contribution / max(safe_part * pixel_estimate, 1.0e-30), LEAST_SURVIVAL, 1.0);
}

// Radiance that the guide expects along the direction, where an ended path brings light in its place; 0 where the guide knows
// nothing. Without emitter sampling, few paths have collected light before they end, so survivors would have nothing to give up.
float expected_radiance(Guide guide, DirectionSample next) {
    return NEE && knows_contribution(guide, next) ? next.radiance : 0.0;
}

// Light that a path brings where it ends by chance, in place of what it would have met: its throughput times the `expected`
// radiance. A survivor gives up 1 / survival - 1 times as much. The mean is that of a path that nothing ends, whatever
// number stands for the light that an ended path has not met (Pharr, Jakob and Humphreys 2016, section 13.7). The better the guide
// knows that light, the less noise roulette adds. A path brings no more than what survivors have to give, so none is negative.
vec3 light_in_place(vec3 collected, vec3 throughput, float expected, float survival) {
    return min(throughput * expected, collected * (survival / max(1.0 - survival, 1.0e-30)));
}

// Light that a survivor gives up.
vec3 light_given_up(vec3 collected, vec3 in_place, float survival) {
    return min(in_place * (1.0 / max(survival, 1.0e-30) - 1.0), collected);
}

#endif
