// Learner expected-sarsa (Eq. 5). The target contains the radiance that y scatters from all directions above it, as the
// table expects it: a stratified mean over EXPECTED_DIRECTIONS directions. Single directions and the other side of the
// surface are not among these. If the sampled direction is one of those, it is added to the target as in SARSA.
#ifndef EXPECTED_SARSA_GLSL
#define EXPECTED_SARSA_GLSL
#include "path/guiding.glsl"
#include "random/random.glsl"
#include "guide/learners/segment.glsl"

// Golden section. Its multiples modulo 1 are evenly distributed for any number of them.
const float GOLDEN_SECTION = 0.61803398875;

// Local direction `i` of EXPECTED_DIRECTIONS. It is uniform over the hemisphere if `shift` is uniform over the unit
// square.
vec3 stratified_direction(uint i, vec2 shift) {
    float height = (float(i) + shift.x) / float(EXPECTED_DIRECTIONS);
    vec2 sc = sin_cos_turn(fract(float(i) * GOLDEN_SECTION + shift.y));
    return vec3(sqrt(max(1.0 - height * height, 0.0)) * sc.yx, height);
}

float scattered_radiance(Scatterer scatterer, vec3 wi) {
    float incident = radiance(radiance_index(scatterer.cell, direction_bin(scatterer.frame * wi)));
    return mean_rgb(eval_scatterer(scatterer, wi)) * incident;
}

float target_expected_sarsa(RandomKey key, uint vertex, vec3 light, Scatterer scatterer, DirectionSample next) {
    vec2 shift = unit_floats(random_bits(key, vertex, RANDOM_LEARNING)).xy;
    float sum = 0.0;
    for (uint i = 0u; i < EXPECTED_DIRECTIONS; ++i) sum += scattered_radiance(scatterer, stratified_direction(i, shift));
    float scattered = sum * (2.0 * PI / float(EXPECTED_DIRECTIONS));
    bool stands_for_others = next.pdf == 0.0 || dot(next.wi, scatterer.frame[2]) < 0.0;
    if (stands_for_others) scattered += mean_rgb(next.weight) * next.radiance;
    return mean_rgb(light) + scattered;
}

#endif
