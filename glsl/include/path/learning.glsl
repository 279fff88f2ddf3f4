// Switch over the learners: the target that a path reports to the radiance grid. No other file names LEARNER.
#ifndef LEARNING_GLSL
#define LEARNING_GLSL
#include "path/expected_sarsa.glsl"
#include "path/guiding.glsl"
#include "guide/learners/monte_carlo.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "guide/samplers/sampler.glsl"

// Whether the guide learns from paths.
bool is_learning() {
    return uses_guide();
}

// Whether targets are recorded when a path has ended, from the vertices that it has kept.
bool keeps_vertices() {
    return is_learning() && LEARNER == LEARNER_MONTE_CARLO;
}

// Segment from a vertex along a sampled direction. Lobes of single directions have no segment in a quadtree, because a
// quadtree never samples them.
Segment segment_from(uint cell, DirectionSample next) {
    if (!is_quadtree()) return Segment(radiance_index(cell, next.bin), 1.0);
    return next.pdf > 0.0 ? Segment(next.bin, 1.0 / next.pdf) : NO_SEGMENT;
}

// Target of SARSA (Eq. 6): the emission from y towards x, plus the radiance that y scatters from the sampled direction,
// as the table expects it. Russian roulette is played later and does not affect the target.
float target_sarsa(vec3 light, DirectionSample next) {
    return mean_rgb(light) + mean_rgb(next.weight) * next.radiance;
}

// Target of the segment that leads to y, reported as soon as the next direction is drawn. With emitter sampling,
// `light` is the weighted emission and the sampled light at y. The guide thus leaves to emitter sampling the light that
// emitter sampling finds better.
float target_at(RandomKey key, uint vertex, vec3 light, Scatterer scatterer, DirectionSample next) {
    if (scatterer.passes || keeps_vertices()) return NO_TARGET;
    if (LEARNER == LEARNER_EXPECTED_SARSA) return target_expected_sarsa(key, vertex, light, scatterer, next);
    return target_sarsa(light, next);
}

#endif
