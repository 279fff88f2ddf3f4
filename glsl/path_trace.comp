// One step of rendering and learning: traces `sample_count` paths for every pixel of a slice, adds them to the film, and
// records what they meet in the radiance grid. A lane starts its next path as soon as the last one has ended.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "camera.glsl"
#include "guiding.glsl"
#include "learning.glsl"
#include "light.glsl"
#include "roulette.glsl"
#include "scatterer.glsl"
#include "surface.glsl"
#include "tally.glsl"
#include "traverse.glsl"

struct PathTracePush {
    uint first_workgroup;    // of the slice, among those of the page's tiles that are sampled
    uint workgroup_count;
    uint workgroup_stride;   // coprime to the count: spreads neighbors over a device that deals out contiguous halves
    uint page_first_pixel;   // pixels (in tile order) before this film page
    SampleWeights weights;
    uint first_sample;
    uint sample_count;
    uint first_of_sets;      // sample; no set of samples reaches back beyond it
};
layout(push_constant, scalar) uniform Push { PathTracePush push; };

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

// Tiles of 8 x 8 pixels, row by row, and pixels within a tile likewise.
uvec2 tile_order_pixel(uint index) {
    uint tiles_per_row = (scene().window_size.x + 7u) / 8u;
    uint tile = index / 64u;
    uint within = index % 64u;
    return uvec2(tile % tiles_per_row, tile / tiles_per_row) * 8u + uvec2(within % 8u, within / 8u);
}

Path start_path(uvec2 film_pixel, uint sample_index) {
    Path path;
    uint first_of_set = max(sample_index - sample_index % SET_SIZE, push.first_of_sets);
    path.key = random_key(film_pixel, uint(scene().film_size.x), sample_index, first_of_set, scene().seed);
    vec4 u = unit_floats(random_bits(path.key, 0u, RANDOM_SCATTER));
    path.ray = camera_ray(vec2(film_pixel) + sample_filter(u.xy), u.zw);
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

void main() {
    uint workgroup = push.first_workgroup + (gl_WorkGroupID.x * push.workgroup_stride) % push.workgroup_count;
    uint index = sampled_pixel(workgroup * WORKGROUP_SIZE + gl_LocalInvocationIndex);
    uvec2 pixel = tile_order_pixel(push.page_first_pixel + index);
    bool inside = all(lessThan(pixel, scene().window_size));
    uvec2 film_pixel = scene().window_offset + pixel;

    PixelSamples samples = no_samples();
    Tally tally = no_tally();
    Path path;
    end_path(path);
    uint kept_count = 0u;
    uint next_sample = inside ? 0u : push.sample_count;
    bool more = next_sample < push.sample_count;
    uint edges_left = push.sample_count * MAX_DEPTH;
    while (more && edges_left > 0u) {
        --edges_left;
        if (path.depth == 0u) path = start_path(film_pixel, push.first_sample + next_sample++);

        Hit hit = traverse(path.ray, false, tally.overrun);
        count_ray(tally, path.depth);
        Segment travelled = path.segment;
        ShareEvidence evidence = path.evidence;
        path.met.segment = travelled;
        uvec4 bits = random_bits(path.key, path.depth, RANDOM_SCATTER);
        float target;
        if (hit.primitive == NONE) {
            target = escape(path, tally);
        } else {
            Surface s = surface_at(path.ray, hit);
            Scatterer x = scatterer_at(s, -path.ray.direction, path.key, path.depth);
            if (path.depth == 1u) {
                add_first_hit(samples, bsdf_albedo(x.bsdf), s.shading_normal, distance(s.position, camera_position()));
            }
            target = scatter(path, hit.primitive, s, x, unit_floats(bits), tally);
        }
        if (keeps_vertices()) {
            kept_count = keep_vertex(kept_count, path.met);
            if (path.depth == 0u) {
                tally.nonfinite += record_returns(kept_count, path.key);
                kept_count = 0u;
            }
        } else if (is_learning()) {
            if (record(travelled, target, leftover_float(bits))) ++tally.nonfinite;
            if (learns_share()) add_evidence(evidence, target, leftover_float(bits));
        }

        if (path.depth == 0u) add_sample(samples, path.key.sample_index, path.radiance, tally);
        more = path.depth != 0u || next_sample < push.sample_count;
    }
    tally.overrun = tally.overrun || more;

    if (inside) merge_into_film(index, samples, push.weights);
    publish_tally(tally);
}
