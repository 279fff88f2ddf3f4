// Results that an invocation gathers before it writes to memory: the samples of its pixel, and counts for the
// statistics.
#ifndef TALLY_GLSL
#define TALLY_GLSL
#include "film/frame.glsl"
#include "film/halves.glsl"
#include "film/slice.glsl"

struct Tally {
    uint rays;
    uint scattered_rays;
    uint shadow_rays;      // rays towards sampled lights
    uint light_hits;       // scattered rays that hit an emitter
    uint guided_samples;
    uint tries;
    uint invalid_samples;  // guided directions below the surface
    uint nonfinite;        // samples and learning targets dropped because they were NaN or infinite
    bool overrun;          // whether a loop was ended before its own end condition held
};

Tally no_tally() {
    return Tally(0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, false);
}

void count_ray(inout Tally tally, uint depth) {
    ++tally.rays;
    if (depth > 1u) ++tally.scattered_rays;
}

void count_light_hit(inout Tally tally, uint depth, vec3 emission) {
    if (depth > 1u && max_component(emission) > 0.0) ++tally.light_hits;
}

void count_sample(inout Tally tally, uint tries, bool invalid, bool overrun) {
    if (tries > 0u) {
        ++tally.guided_samples;
        tally.tries += tries;
        if (invalid) ++tally.invalid_samples;
    }
    tally.overrun = tally.overrun || overrun;
}

// Counters that a tally has. The last counter is for a rare event, and each lane adds to it by itself.
const uint TALLIED_COUNTERS = COUNTER_CUT_SHADOW_RAYS;

shared uint tally_lanes[TALLIED_COUNTERS * WORKGROUP_SIZE];

// Adds the workgroup's tallies to the counters. A few lanes sum up the numbers of all lanes, one counter each. Overruns
// are counted first and by each lane itself: a driver that cut one loop short may cut the loops below short, too.
void publish_tally(Tally tally) {
    count(COUNTER_OVERRUNS, tally.overrun ? 1u : 0u);
    uint numbers[TALLIED_COUNTERS];
    numbers[COUNTER_RAYS] = tally.rays;
    numbers[COUNTER_SCATTERED_RAYS] = tally.scattered_rays;
    numbers[COUNTER_LIGHT_HITS] = tally.light_hits;
    numbers[COUNTER_GUIDED_SAMPLES] = tally.guided_samples;
    numbers[COUNTER_TRIES] = tally.tries;
    numbers[COUNTER_INVALID_SAMPLES] = tally.invalid_samples;
    numbers[COUNTER_NONFINITE] = tally.nonfinite;
    numbers[COUNTER_OVERRUNS] = 0u;
    numbers[COUNTER_SHADOW_RAYS] = tally.shadow_rays;
    for (uint counter = 0u; counter < TALLIED_COUNTERS; ++counter) {
        tally_lanes[counter * WORKGROUP_SIZE + gl_LocalInvocationIndex] = numbers[counter];
    }
    barrier();
    for (uint counter = gl_LocalInvocationIndex; counter < TALLIED_COUNTERS; counter += WORKGROUP_SIZE) {
        uint sum = 0u;
        for (uint lane = 0u; lane < WORKGROUP_SIZE; ++lane) sum += tally_lanes[counter * WORKGROUP_SIZE + lane];
        count(counter, sum);
    }
}

// Samples that one dispatch adds to a pixel: running moments of radiance, and sums of the features at the first hit.
struct PixelSamples {
    FilmRadiance radiance;
    FilmFeatures sums;
    FilmHalf half_of_them;
};

PixelSamples no_samples() {
    return PixelSamples(FilmRadiance(vec3(0.0), 0u, vec3(0.0), 0u), NO_FEATURES, NO_HALF);
}

// Adds the radiance of one sample to the running moments (Welford 1962).
void add_sample(inout PixelSamples s, uint sample_index, vec3 radiance, inout Tally tally) {
    if (!is_finite(radiance)) {
        radiance = vec3(0.0);
        ++tally.nonfinite;
    }
    ++s.radiance.sample_count;
    vec3 delta = radiance - s.radiance.mean;
    s.radiance.mean += delta / float(s.radiance.sample_count);
    s.radiance.squared_deviation += delta * (radiance - s.radiance.mean);
    if (ADAPTIVE && is_of_half(sample_index)) {
        ++s.half_of_them.sample_count;
        s.half_of_them.mean += (radiance - s.half_of_them.mean) / float(s.half_of_them.sample_count);
    }
}

void add_first_hit(inout PixelSamples s, FilmFeatures hit) {
    ++s.radiance.hit_count;
    add_features(s.sums, hit);
}

// Merges two sets of moments (Chan, Golub and LeVeque 1979). Squared deviations are weighted by the squares of the
// weights. The expectation of their sum is the sum of weight^2 variance over all samples except the first.
// src/film/weights.rs derives the variance of the mean from it.
FilmRadiance merge_radiance(FilmRadiance a, FilmRadiance b, DispatchWeights w) {
    float count = float(b.sample_count);
    float weight = w.of_sample * count;
    float share = weight / max(float(a.sample_count) - w.lost_weight + weight, 1.0e-30);
    float effective = float(a.sample_count) - w.lost_samples;
    float spread = effective * (count / max(effective + count, 1.0));
    vec3 delta = b.mean - a.mean;
    vec3 squared = b.squared_deviation + delta * delta * spread;
    squared = a.squared_deviation + w.of_sample * w.of_sample * squared;
    return FilmRadiance(a.mean + delta * share, a.sample_count + b.sample_count, squared, a.hit_count + b.hit_count);
}

void merge_into_film(uint index, PixelSamples s, DispatchWeights weights) {
    FilmRadiance before = load_film_radiance(index);
    FilmRadiance after = merge_radiance(before, s.radiance, weights);
    vec2 counts = vec2(max(after.sample_count, 1u), max(after.hit_count, 1u));
    vec2 old_share = vec2(before.sample_count, before.hit_count) / counts;
    FilmFeatures features = merge_features(load_film_features(index), s.sums, old_share, 1.0 / counts);
    store_film(index, after, features);
    if (ADAPTIVE) store_half(index, merge_halves(load_half(index), s.half_of_them));
}

#endif
