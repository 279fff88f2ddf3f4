// What happens where a path's ray has led: light is collected, the guide learns, and the path goes on or ends.
#ifndef VERTEX_GLSL
#define VERTEX_GLSL
#include "path/connection.glsl"
#include "path/roulette.glsl"
#include "film/tally.glsl"

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

// The light of a connection that nothing is in the way of. How that is found out is the kernel's own matter.
vec3 direct_light(Path path, Surface s, Scatterer x, Guide guide, inout Tally tally);

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
