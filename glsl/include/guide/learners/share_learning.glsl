// Learning of the BSDF share of a cell (see bsdf_share.glsl). The mixture of the guide's density and the surface's own
// density is brought close to f cos L, measured by the Kullback-Leibler divergence. Vorba et al. 2019 ("Path Guiding in
// Production", section 10.5) do this by gradient descent; here each update is one step of expectation maximization. The
// new share of the guide is the mean probability that a sample came from the guide, given its direction. Each sample is
// weighted by the radiance that it scatters from its segment's target.
#ifndef SHARE_LEARNING_GLSL
#define SHARE_LEARNING_GLSL
#include "guide/samplers/bsdf_share.glsl"
#include "film/frame.glsl"
#include "shared/guide.glsl"
#include "shared/kept.glsl"

// Initial share, and the number of samples that it counts for as prior evidence.
const float FIRST_SHARE = 0.5;
const float FIRST_SAMPLES = 64.0;
// Minimum of both shares. A share e bounds the weights by 1 / e times the weights of that sampler alone.
const float LEAST_SHARE = 0.1;
// Fraction of the samples that is recorded. If all were, too many lanes would add to the same few words.
const float ASKED = 0.25;
// Factor of earlier samples at the end of each step. Their evidence depends on earlier shares.
const float SHARE_DECAY = 0.5;

// Evidence of a sample about the share that was in force when the sample was drawn.
struct ShareEvidence {
    uint share;       // index of the share; NONE: no evidence
    float scattered;  // mean over RGB of f cos / pdf, times the fraction of samples to which the share applies
    // Beside the ray, where a wave has room.
    KEPT(ray) float of_guide;  // probability that the guide drew the sample, within the same fraction
};

const ShareEvidence NO_EVIDENCE = ShareEvidence(NONE, 0.0, 0.0);

// Index of a share's sum among the sums of a step.
uint share_sum(uint share, uint which) {
    return all_bin_count() + SHARE_SUMS * share + which;
}

// Adds the evidence of a sample whose segment has the target `target`. `u` in [0, 1) selects the recorded samples and
// rounds.
void add_evidence(ShareEvidence evidence, float target, float u) {
    float scattered = evidence.scattered * target;
    if (evidence.share == NONE || u >= ASKED || target < 0.0 || !is_finite(scattered)) return;
    u /= ASKED;
    // The limit applies before the second sum is formed, so that both sums saturate together.
    scattered = min(scattered, scene().target_limit);
    add_target(share_sum(evidence.share, 0u), fixed_point(scattered, scene().target_limit, u));
    add_target(share_sum(evidence.share, 1u), fixed_point(scattered * evidence.of_guide, scene().target_limit, u));
}

// Adds the sum of a step to the sum of earlier steps times `decay`, stores the result and returns it.
float renewed_word(uint share, uint word, float decay, float recorded) {
    float renewed = recorded + decay * radiance(share_word(share, word));
    store_radiance(share_word(share, word), renewed);
    return renewed;
}

// Updates a share. `decay` is the factor of earlier samples.
void learn_share(uint share, float decay) {
    float sample_count = renewed_word(share, 3u, decay, number_of_targets(share_sum(share, 0u)));
    float scattered = renewed_word(share, 1u, decay, sum_of_targets(share_sum(share, 0u), scene().target_limit));
    float of_guide = renewed_word(share, 2u, decay, sum_of_targets(share_sum(share, 1u), scene().target_limit));
    forget_targets(share_sum(share, 0u));
    forget_targets(share_sum(share, 1u));
    float learned = scattered > 0.0 ? 1.0 - of_guide / scattered : FIRST_SHARE;
    float certainty = sample_count / (sample_count + FIRST_SAMPLES);
    store_radiance(share_word(share, 0u), clamp(mix(FIRST_SHARE, learned, certainty), LEAST_SHARE, 1.0 - LEAST_SHARE));
}

#endif
