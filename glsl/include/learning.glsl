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

bool is_learning() {
    return SAMPLER != SAMPLER_BSDF;
}

Segment segment_from(uint cell, vec3 wi) {
    return Segment(radiance_index(cell, direction_bin(wi, DIRECTION_RESOLUTION)));
}

void record(Segment segment, RandomKey key, uint vertex, float target) {
    if (segment.index == NONE || !is_finite(target)) return;
    float u = random4(key, vertex, RANDOM_RECORD).x;
    add_target(segment.index, fixed_point(target, scene().target_limit, u));
}

// SARSA (Eq. 6): emission towards x plus what y scatters of the radiance that the table expects from the direction that
// was sampled there. Roulette has no part in it: it is played afterwards.
float target_sarsa(vec3 emission, DirectionSample next) {
    return mean_rgb(emission) + mean_rgb(next.weight) * next.radiance;
}

#endif
