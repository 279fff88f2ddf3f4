// Russian roulette: the probability with which a path goes on. Whatever of a path's past decides it, the mean stays, for
// survivors are weighed up.
#ifndef ROULETTE_GLSL
#define ROULETTE_GLSL
#include "path/guiding.glsl"

// By throughput, from an edge on. That radiance is less concentrated outside a medium is undone first.
const float MOST_SURVIVAL = 0.95;

// By expected contribution (Vorba and Krivanek 2016, "Adjoint-Driven Russian Roulette and Splitting in Light Transport
// Simulation"): of what a path may still bring to its pixel over what the pixel is expected to hold. The window is wide, for
// both are coarse: no path is at risk that is expected to bring this part of its pixel.
const float SAFE_PART = 0.4;
// Bounds what a survivor gains at a vertex, however wrong the guide is.
const float LEAST_SURVIVAL = 0.05;
// A record that has met no light yet holds a mean radiance far below this in place of 0.
const float LEAST_KNOWN = 1.0e-30;

float survival_by_throughput(vec3 throughput, float eta, uint depth) {
    return depth < RR_DEPTH ? 1.0 : min(max_component(throughput) * eta * eta, MOST_SURVIVAL);
}

// Whether the guide knows what the direction may bring.
bool knows_contribution(Guide guide, DirectionSample next) {
    return ROULETTE == ROULETTE_CONTRIBUTION && is_guided(guide) && next.pdf > 0.0 && mean_radiance(guide) > LEAST_KNOWN;
}

// What a path with this throughput gets of a surface that scatters the mean radiance around it. Coarse: the albedo stands for
// the scattering function.
float expected_scattered(vec3 throughput, Scatterer x, Guide guide) {
    return mean_rgb(throughput * bsdf_albedo(x.bsdf)) * mean_radiance(guide);
}

// Where a sample has the weight f cos / pdf and its bin the radiance L, throughput, weight and L multiply to what is expected
// of it. The mean radiance is added to L, so that no light is lost on a bin that has not met it yet.
float survival_by_contribution(vec3 throughput, Guide guide, DirectionSample next, float expected_of_pixel) {
    float contribution = mean_rgb(throughput * next.weight) * (next.radiance + mean_radiance(guide));
    return clamp(contribution / max(SAFE_PART * expected_of_pixel, 1.0e-30), LEAST_SURVIVAL, 1.0);
}

#endif
