// The switch over the learners: what a path tells the radiance grid.
#ifndef LEARNING_GLSL
#define LEARNING_GLSL
#include "guiding.glsl"
#include "radiance_grid.glsl"

// The segment from x towards the next vertex y: the bin L(x, w) that y's target will go to; NONE where x is the eye.
struct Segment {
    uint index;
};

const Segment NO_SEGMENT = Segment(NONE);
// Where a segment ends at the maximum depth nothing is learned: its end was not followed further.
const float NO_TARGET = -1.0;

bool is_learning() {
    return SAMPLER != SAMPLER_BSDF;
}

Segment segment_from(uint cell, DirectionSample s) {
    return Segment(radiance_index(cell, s.bin));
}

// Adds a target, if there is one, to the segment's bin; `u` in [0, 1) rounds it.
void record(Segment segment, float target, float u) {
    if (segment.index == NONE || target == NO_TARGET || !is_finite(target)) return;
    add_target(segment.index, fixed_point(target, scene().target_limit, u));
}

// SARSA (Eq. 6): emission towards x plus what y scatters of the radiance that the table expects from the direction that
// was sampled there. Roulette has no part in it: it is played afterwards. With emitter sampling, `light` is the weighted
// emission and the light sampled at y: the guide leaves to emitter sampling what that finds better.
float target_sarsa(vec3 light, DirectionSample next) {
    return mean_rgb(light) + mean_rgb(next.weight) * next.radiance;
}

#endif
