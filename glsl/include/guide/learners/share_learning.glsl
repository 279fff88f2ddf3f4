// How cells learn the share of bsdf_share.glsl. It takes the mixture of the guide's density and the surface's own as near to
// f cos L as it comes, in Kullback-Leibler divergence (as Vorba et al. 2019, "Path Guiding in Production", section 10.5, by
// gradients), by a step of expectation maximization an update: the guide's share becomes the mean probability that a sample
// came from the guide, given its direction, where a sample counts by what it scatters of the radiance that its segment learns.
#ifndef SHARE_LEARNING_GLSL
#define SHARE_LEARNING_GLSL
#include "guide/samplers/bsdf_share.glsl"
#include "film/frame.glsl"
#include "shared/guide.glsl"

// What a cell starts with, and holds on to as if it had learned it from so many samples.
const float FIRST_SHARE = 0.5;
const float FIRST_SAMPLES = 64.0;
// Neither side has less: a share e bounds weights by 1 / e times those of that side alone.
const float LEAST_SHARE = 0.1;
// Part of the samples that is asked: all of them would have many lanes add to few words.
const float ASKED = 0.25;
// What one update leaves of earlier samples: they were weighed by earlier shares.
const float SHARE_DECAY = 0.5;

// What a sample says of the share that it was drawn by.
struct ShareEvidence {
    uint share;       // its index; NONE: nothing
    float scattered;  // mean over RGB of f cos / pdf, times the part of the samples that the share is of
    float of_guide;   // probability that the guide has drawn it, over the same part
};

const ShareEvidence NO_EVIDENCE = ShareEvidence(NONE, 0.0, 0.0);

// Where a step adds to the two sums: after the bins, too.
uint share_sum(uint share, uint which) {
    return SHARES_AT + SHARE_SUMS * share + which;
}

// Adds a sample, whose segment has learned `target`; `u` in [0, 1) decides whether, and rounds.
void add_evidence(ShareEvidence evidence, float target, float u) {
    float scattered = evidence.scattered * target;
    if (evidence.share == NONE || u >= ASKED || target < 0.0 || !is_finite(scattered)) return;
    u /= ASKED;
    // Both sums saturate together.
    scattered = min(scattered, scene().target_limit);
    add_target(share_sum(evidence.share, 0u), fixed_point(scattered, scene().target_limit, u));
    add_target(share_sum(evidence.share, 1u), fixed_point(scattered * evidence.of_guide, scene().target_limit, u));
}

// Adds what a step has recorded to a sum, of which it returns what is left of earlier steps, too.
float renewed_word(uint share, uint word, float recorded) {
    float renewed = recorded + SHARE_DECAY * radiance(share_word(share, word));
    store_radiance(share_word(share, word), renewed);
    return renewed;
}

// Ends a step's learning of a share.
void learn_share(uint share) {
    float sample_count = renewed_word(share, 3u, number_of_targets(share_sum(share, 0u)));
    float scattered = renewed_word(share, 1u, sum_of_targets(share_sum(share, 0u), scene().target_limit));
    float of_guide = renewed_word(share, 2u, sum_of_targets(share_sum(share, 1u), scene().target_limit));
    forget_targets(share_sum(share, 0u));
    forget_targets(share_sum(share, 1u));
    float learned = scattered > 0.0 ? 1.0 - of_guide / scattered : FIRST_SHARE;
    float certainty = sample_count / (sample_count + FIRST_SAMPLES);
    store_radiance(share_word(share, 0u), clamp(mix(FIRST_SHARE, learned, certainty), LEAST_SHARE, 1.0 - LEAST_SHARE));
}

#endif
