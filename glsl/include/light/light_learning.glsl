// Learning of the light selection (light_selection.glsl). Every connection to a sampled light is evidence for the light's group: the
// radiance that the surface scatters from the light, 0 where something blocks the light, over the density of the light within
// its group.
#ifndef LIGHT_LEARNING_GLSL
#define LIGHT_LEARNING_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "guide/samplers/bsdf_share.glsl"
#include "light/light_selection.glsl"
#include "shared/guide.glsl"
#include "shared/kept.glsl"

// Samples of a pixel that all record evidence. Of the later ones, one of RECORDED_SAMPLES does: recording takes time, and by then a
// cell knows much.
const uint FIRST_SAMPLES_RECORDED = 32u;
const uint RECORDED_SAMPLES = 4u;

// Evidence of a connection that may be blocked.
struct LightEvidence {
    // Fixed-point units of the scattered radiance if nothing blocks the light. A wave keeps them with the connection's light, so that a
    // blocked connection loses both and keeps the sum.
    uint units;
    KEPT(ray) uint sum;  // index of the group's sum; NONE: no evidence
};

const LightEvidence NO_LIGHT_EVIDENCE = LightEvidence(0u, NONE);

// Whether the connections of a sample are recorded.
bool records_lights(uint sample_index) {
    return learns_lights() && (sample_index < FIRST_SAMPLES_RECORDED || sample_index % RECORDED_SAMPLES == 0u);
}

// Index of a group's sum among the sums of a step. The sums of groups follow those of bins and shares.
uint light_sum(uint cell, uint group) {
    uint share_sums = 0u;
    if (learns_share()) share_sums = SHARE_SUMS * SHARES_PER_CELL;
    return scene().cell_count * (direction_bin_count() + share_sums) + cell * LIGHT_GROUPS + group;
}

// Index of a group among the learned means. The groups of all cells follow the bins of all cells, parent cells included where
// cells borrow from them.
uint learned_light(uint cell, uint group) {
    uint cells = FALLBACK > 0.0 ? scene().all_cell_count : scene().cell_count;
    return cells * direction_bin_count() + cell * LIGHT_GROUPS + group;
}

// Power of a group over that of all lights. It is stored as the mean of a cell that follows all cells.
float power_of_group(uint group) {
    return learned_radiance(learned_light(scene().cell_count, group)).mean;
}

// Evidence of a connection to a light of a group. `scattered` is the radiance that the surface scatters from the light, over the
// light's density within the group. `u` in [0, 1) rounds it.
LightEvidence light_evidence(uint cell, uint group, float scattered, float u) {
    return LightEvidence(fixed_point(scattered, scene().target_limit, u), light_sum(cell, group));
}

// Records a connection, once it is known whether the light arrives.
void learn_light(LightEvidence evidence, bool arrives) {
    if (evidence.sum != NONE) add_target(evidence.sum, arrives ? evidence.units : 0u);
}

#endif
