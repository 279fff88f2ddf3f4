// A path, and what happens to it where its rays lead.
#ifndef PATH_GLSL
#define PATH_GLSL
#include "camera.glsl"
#include "guiding.glsl"
#include "learning.glsl"
#include "light.glsl"
#include "roulette.glsl"
#include "scatterer.glsl"
#include "surface.glsl"
#include "tally.glsl"
#include "traverse.glsl"

struct Path {
    RandomKey key;
    Ray ray;
    vec3 throughput;
    vec3 radiance;
    float eta;        // index of refraction of the medium that the ray travels over the camera's
    uint depth;       // edges so far, the ray's own included; 0: no path is under way
    Segment segment;  // that the ray travels
    ShareEvidence evidence;  // of its direction
    vec3 from;        // the point of a surface that the ray left
    float pdf;        // density of its direction there; 0 where emitter sampling cannot have drawn it
    float expected_of_pixel;  // what the path had brought and was expected to bring at the first surface that told; 0 before
    PathVertex met;   // the vertex just met, for learners that keep them
};

// Of a sample whose set reaches back no further than to the sample `first_of_sets`.
RandomKey key_of_sample(uvec2 film_pixel, uint sample_index, uint first_of_sets) {
    uint first_of_set = max(sample_index - sample_index % SET_SIZE, first_of_sets);
    return random_key(film_pixel, uint(scene().film_size.x), sample_index, first_of_set, scene().seed);
}

// A path that has met nothing yet, whose ray is still to be set.
Path new_path(RandomKey key) {
    Path path;
    path.key = key;
    path.throughput = vec3(1.0);
    path.radiance = vec3(0.0);
    path.eta = 1.0;
    path.depth = 1u;
    path.segment = NO_SEGMENT;
    path.evidence = NO_EVIDENCE;
    path.from = vec3(0.0);
    path.pdf = 0.0;
    path.expected_of_pixel = 0.0;
    path.met = NO_VERTEX;
    return path;
}

Path start_path(uvec2 film_pixel, RandomKey key) {
    Path path = new_path(key);
    vec4 u = unit_floats(random_bits(key, 0u, RANDOM_SCATTER));
    path.ray = camera_ray(vec2(film_pixel) + sample_filter(u.xy), u.zw);
    return path;
}

vec3 visible_emission(Path path, vec3 emission) {
    return HIDE_EMITTERS && path.depth == 1u ? vec3(0.0) : emission;
}

// The probability with which the path goes on in the direction `next`, by which its throughput is not yet multiplied.
float survival_of(Path path, Guide guide, DirectionSample next) {
    if (!knows_contribution(guide, next)) {
        return survival_by_throughput(path.throughput * next.weight, path.eta * next.eta, path.depth);
    }
    return survival_by_contribution(path.throughput, guide, next, path.expected_of_pixel);
}

// Survivors are weighed up.
bool survives_roulette(inout Path path, float survival, float u) {
    path.throughput /= max(survival, 1.0e-30);
    path.met.factor /= max(survival, 1.0e-30);
    path.evidence.scattered /= max(survival, 1.0e-30);
    return u < survival;
}

void end_path(inout Path path) {
    path.depth = 0u;
    path.met.factor = vec3(0.0);
}

// Share of the emission that the path's ray met, where emitter sampling draws the ray's direction with this density.
float emission_weight(Path path, float pdf_light) {
    return path.pdf > 0.0 ? mis_weight(path.pdf, pdf_light) : 1.0;
}

// Adds the environment's radiance. Returns the target of the segment that led there.
float escape(inout Path path, inout Tally tally) {
    vec3 emission = environment_radiance(path.ray.direction);
    count_light_hit(tally, path.depth, emission);
    if (NEE) emission *= emission_weight(path, pdf_light_at_environment(path.ray.direction));
    path.radiance += path.throughput * visible_emission(path, emission);
    path.met.light = emission;
    float target = path.depth < MAX_DEPTH && !keeps_vertices() ? mean_rgb(emission) : NO_TARGET;
    if (path.depth == MAX_DEPTH) path.met.segment = NO_SEGMENT;
    end_path(path);
    return target;
}

// Emitter sampling: the light that a surface scatters straight from a sampled light, weighted.
vec3 direct_light(Path path, Surface s, Scatterer x, Guide guide, inout Tally tally) {
    LightSample light = sample_light(path.key, path.depth, s.position);
    vec3 wi = light.wi * x.frame;
    float pdf = pdf_direction(x, guide, wi);
    if (MIS_FAULT == MIS_BLIND_TO_GUIDE) pdf = pdf_bsdf(x.bsdf, x.wo, wi, pdf_cosine_hemisphere(wi.z));
    float weight = light.delta ? 1.0 : mis_weight(light.pdf, pdf);
    vec3 scattered = eval_scatterer(x, wi) * light.radiance;
    if (x.passes || light.pdf <= 0.0 || max_component(scattered) <= 0.0) return vec3(0.0);
    ++tally.shadow_rays;
    Hit blocker = traverse(shadow_ray(s, light), true, tally.overrun);
    return blocker.primitive == NONE ? scattered * (weight / light.pdf) : vec3(0.0);
}

// Adds what the surface emits and what it scatters of sampled lights, and draws where the path goes on. Returns the target
// of the segment that ends here.
float scatter(inout Path path, uint primitive, Surface s, Scatterer x, vec4 u, inout Tally tally) {
    vec3 light = surface_emission(s, -path.ray.direction);
    count_light_hit(tally, path.depth, light);
    if (NEE) light *= emission_weight(path, pdf_light_at_surface(primitive, s, path.from));
    path.radiance += path.throughput * visible_emission(path, light);
    path.met.light = light;
    if (path.depth == MAX_DEPTH) {
        path.met.segment = NO_SEGMENT;
        end_path(path);
        return NO_TARGET;
    }
    Guide guide = guide_at(x);
    if (NEE) {
        vec3 direct = direct_light(path, s, x, guide, tally);
        path.radiance += path.throughput * direct;
        light += direct;
        path.met.light = light;
    }
    DirectionSample next = sample_direction(path.key, path.depth, u, x, guide);
    count_sample(tally, next.tries, next.lost, next.overrun);
    if (!x.passes) path.segment = segment_from(x.cell, next);
    if (!x.passes) path.evidence = next.evidence;
    // What lies behind a hole is collected by the segment that leads there.
    if (x.passes && keeps_vertices()) path.segment = NO_SEGMENT;
    float target = target_at(path.key, path.depth, light, x, guide, next);
    if (path.expected_of_pixel == 0.0 && knows_contribution(guide, next)) {
        path.expected_of_pixel = mean_rgb(path.radiance) + expected_scattered(path.throughput, x, guide);
    }
    float survival = survival_of(path, guide, next);
    path.throughput *= next.weight;
    path.met.factor = next.weight;
    path.eta *= next.eta;
    if (max_component(path.throughput) > 0.0 && survives_roulette(path, survival, u.w)) {
        path.ray = x.passes ? pass_surface(s, next.wi) : leave_surface(s, next.wi);
        path.from = s.position;
        path.pdf = next.pdf;
        ++path.depth;
    } else {
        end_path(path);
    }
    return target;
}

// What a camera ray has hit.
struct FirstHit {
    bool known;
    vec3 albedo;
    vec3 normal;
    float depth;
};

const FirstHit NO_FIRST_HIT = FirstHit(false, vec3(0.0), vec3(0.0), 0.0);

// What happens where the path's ray has led. Returns the target of the segment that it travelled.
float meet(inout Path path, Hit hit, vec4 u, inout FirstHit first, inout Tally tally) {
    count_ray(tally, path.depth);
    if (hit.primitive == NONE) return escape(path, tally);
    Surface s = surface_at(path.ray, hit);
    Scatterer x = scatterer_at(s, -path.ray.direction, path.key, path.depth);
    if (path.depth == 1u) {
        first = FirstHit(true, bsdf_albedo(x.bsdf), s.shading_normal, distance(s.position, camera_position()));
    }
    return scatter(path, hit.primitive, s, x, u, tally);
}

// Hands a segment's target to the guide; `u` in [0, 1) rounds it.
void learn(Segment travelled, ShareEvidence evidence, float target, float u, inout Tally tally) {
    if (!is_learning()) return;
    if (record(travelled, target, u)) ++tally.nonfinite;
    if (learns_share()) add_evidence(evidence, target, u);
}

#endif
