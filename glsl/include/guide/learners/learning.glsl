// The switch over the learners: what a path tells the radiance grid.
#ifndef LEARNING_GLSL
#define LEARNING_GLSL
#include "guide/learners/expected_sarsa.glsl"
#include "path/guiding.glsl"
#include "guide/learners/irradiance_sarsa.glsl"
#include "guide/learners/monte_carlo.glsl"
#include "guide/grid/radiance_grid.glsl"

bool is_learning() {
    return SAMPLER != SAMPLER_BSDF;
}

bool keeps_vertices() {
    return is_learning() && LEARNER == LEARNER_MONTE_CARLO;
}

// The quadtree does not learn from lobes of single directions: it never draws these.
Segment segment_from(uint cell, DirectionSample s) {
    if (SAMPLER != SAMPLER_QUADTREE) return Segment(radiance_index(cell, s.bin), 1.0);
    return s.pdf > 0.0 ? Segment(s.bin, 1.0 / s.pdf) : NO_SEGMENT;
}

// SARSA (Eq. 6): emission towards x plus what y scatters of the radiance that the table expects from the direction that
// was sampled there. Roulette has no part in it: it is played afterwards.
float target_sarsa(vec3 light, DirectionSample next) {
    return mean_rgb(light) + mean_rgb(next.weight) * next.radiance;
}

// What the segment to y learns as soon as the next direction is drawn. With emitter sampling, `light` is the weighted emission
// and the light sampled at y: the guide leaves to emitter sampling what that finds better.
float target_at(RandomKey key, uint vertex, vec3 light, Scatterer x, Guide guide, DirectionSample next) {
    if (x.passes || keeps_vertices()) return NO_TARGET;
    if (LEARNER == LEARNER_EXPECTED_SARSA) return target_expected_sarsa(key, vertex, light, x, next);
    if (LEARNER == LEARNER_IRRADIANCE_SARSA && knows_scattered(x, guide)) return target_irradiance_sarsa(light, x, guide);
    return target_sarsa(light, next);
}

#endif
