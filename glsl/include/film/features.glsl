// Features of the surfaces that camera rays hit first. src/film/features.rs says which means run over which samples.
#ifndef FEATURES_GLSL
#define FEATURES_GLSL
#include "shared/kept.glsl"

// Features of one hit, sums over some samples, or means over all samples of a pixel. The depth is the mean over the samples
// that hit.
struct FilmFeatures {
    vec3 albedo;                   // mean albedo of the first hit
    float depth;                   // mean depth of the first hit over the samples that hit
    vec3 normal;                   // mean shading normal of the first hit
    KEPT(never) float reserved;    // unused
};

const FilmFeatures NO_FEATURES = FilmFeatures(vec3(0.0), 0.0, vec3(0.0), 0.0);

void add_features(inout FilmFeatures sums, FilmFeatures hit) {
    sums.albedo += hit.albedo;
    sums.normal += hit.normal;
    sums.depth += hit.depth;
}

// Means over earlier and new samples: earlier means count for a share, new sums are divided. x is for means over all samples,
// y for means over the samples that hit.
FilmFeatures merge_features(FilmFeatures means, FilmFeatures sums, vec2 old_share, vec2 per_one) {
    means.albedo = means.albedo * old_share.x + sums.albedo * per_one.x;
    means.normal = means.normal * old_share.x + sums.normal * per_one.x;
    means.depth = means.depth * old_share.y + sums.depth * per_one.y;
    return means;
}

#endif
