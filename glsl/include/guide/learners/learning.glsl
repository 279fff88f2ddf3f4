// The switch over the learners: what a path tells the radiance grid. This file alone names LEARNER.
#ifndef LEARNING_GLSL
#define LEARNING_GLSL
#include "guide/learners/expected_sarsa.glsl"
#include "path/guiding.glsl"
#include "guide/learners/irradiance_sarsa.glsl"
#include "guide/learners/monte_carlo.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "guide/samplers/sampler.glsl"

// The guide learns from paths.
bool is_learning() {
    return uses_guide();
}

// Targets are recorded when a path has ended, from its kept vertices.
bool keeps_vertices() {
    return is_learning() && LEARNER == LEARNER_MONTE_CARLO;
}

// The segment that begins at a cell's point with the sampled direction. The quadtree does not learn from lobes of single
// directions, for it never draws these.
Segment segment_from(uint cell, DirectionSample next) {
    if (!is_quadtree()) return Segment(radiance_index(cell, next.bin), 1.0);
    return next.pdf > 0.0 ? Segment(next.bin, 1.0 / next.pdf) : NO_SEGMENT;
}

// SARSA (Eq. 6): emission towards x plus what y scatters of the radiance that the table expects from the direction that
// was sampled there. Roulette has no part in it: it is played afterwards.
float target_sarsa(vec3 light, DirectionSample next) {
    return mean_rgb(light) + mean_rgb(next.weight) * next.radiance;
}

// The target of the segment to y, known as soon as the next direction is drawn there. With emitter sampling, `light` is the
// weighted emission and the light sampled at y: the guide leaves to emitter sampling what that finds better.
float target_at(RandomKey key, uint vertex, vec3 light, Scatterer scatterer, Guide guide, DirectionSample next) {
    if (scatterer.passes || keeps_vertices()) return NO_TARGET;
    if (LEARNER == LEARNER_EXPECTED_SARSA) return target_expected_sarsa(key, vertex, light, scatterer, next);
    if (LEARNER == LEARNER_IRRADIANCE_SARSA && knows_scattered(scatterer, guide)) {
        return target_irradiance_sarsa(light, scatterer, guide);
    }
    return target_sarsa(light, next);
}

#endif
