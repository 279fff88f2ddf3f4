// The algorithm at one vertex of a path, where its ray ends: shade_vertex is called once for every edge. The phases are those
// of a path tracer with emitter sampling. A guide takes part in all of them: with emitter sampling, its density weights the light of
// "1. Emission" and "2. Emitter sampling".
#ifndef VERTEX_GLSL
#define VERTEX_GLSL
#include "path/connection.glsl"
#include "path/interaction.glsl"
#include "path/roulette.glsl"
#include "film/tally.glsl"

// Emission as the picture shows it. Where emitters are hidden, the camera's rays go through surfaces that emit, and the
// environment is black.
vec3 visible_emission(Path path, vec3 emission) {
    return HIDE_EMITTERS && comes_from_camera(path) ? vec3(0.0) : emission;
}

// Multiple importance sampling: weight of emission that the path's ray has met, where emitter sampling draws the ray's
// direction with the density `pdf_light`.
float emission_weight(Path path, float pdf_light) {
    return path.pdf > 0.0 ? mis_weight(path.pdf, pdf_light) : 1.0;
}

// Cell of the last surface that has scattered the path. It matters where cells learn which lights to draw. Without a segment, path.pdf
// is 0, and nobody uses the density of the cell 0.
uint cell_left(Path path) {
    bool known = learns_lights() && path.segment.index != NONE;
    return known ? path.segment.index / direction_bin_count() : 0u;
}

// Light of a connection that nothing blocks, and what the connection teaches about lights. Each kernel traces the shadow ray in
// its own way.
vec3 direct_light(Path path, Surface surface, Scatterer scatterer, Guide guide, out LightEvidence evidence, inout Tally tally);

// Probability that the path goes on in the direction `next`. The path's throughput does not hold that direction's weight yet.
float survival_of(Path path, Guide guide, DirectionSample next) {
    float survival;
    if (knows_contribution(guide, next)) {
        survival = survival_by_contribution(path.throughput, guide, next, path.pixel_estimate);
    } else {
        survival = survival_by_throughput(path.throughput * next.weight, path.eta * next.eta, path.depth);
    }
    return path.depth < SURE_ROULETTE_DEPTH ? survival : min(survival, MOST_SURVIVAL);
}

// Probability that a path goes on through a surface, straight or refracted. Roulette would end the segment before its target is
// known, and few targets would come from behind the surface. It is played at the next surface that scatters the path.
float survival_of_straight(uint depth) {
    return depth < SURE_ROULETTE_DEPTH ? 1.0 : MOST_SURVIVAL;
}

// Plays Russian roulette. A survivor's weight grows by one over the probability of survival. An ended path brings the
// `expected` radiance in place of what it would have met.
bool survives_roulette(inout Path path, float survival, float expected, float u) {
    bool survives = u < survival;
    vec3 in_place = light_in_place(path.radiance, path.throughput, expected, survival);
    path.radiance += survives ? -light_given_up(path.radiance, in_place, survival) : in_place;
    path.throughput /= max(survival, 1.0e-30);
    path.last_vertex.factor /= max(survival, 1.0e-30);
    path.evidence.scattered /= max(survival, 1.0e-30);
    return survives;
}

void end_path(inout Path path) {
    path.depth = 0u;
    path.last_vertex.factor = vec3(0.0);
}

// Target of a segment: the target of its last part, and what the surfaces and media let through and emit that the path has crossed before.
float target_through(Path path, float target) {
    return target == NO_TARGET ? target : path.straight_light + path.straight_share * target;
}

// Counts a vertex for what the path remembers since the last surface that has scattered it.
void remember_passage(inout Path path, bool straight, bool refracted, vec3 light, vec3 weight) {
    bool through = straight || refracted;
    path.straight_light = through ? path.straight_light + path.straight_share * mean_rgb(light) : 0.0;
    path.straight_share = through ? path.straight_share * mean_rgb(weight) : 1.0;
    path.straight = straight ? path.straight + 1u : 0u;
    if (bends_light()) path.refractions = through ? path.refractions + uint(refracted) : 0u;
}

// Density with which emitter sampling draws, at the last surface that has scattered the path, the environment in the direction from which
// the path has met it.
float pdf_light_at_end(Path path) {
    vec3 direction = path.ray.direction;
    if (bends_light() && path.refractions != 0u) direction = path.setting_out;
    return pdf_light_at_environment(direction, cell_left(path));
}

// A ray that has left the scene. Returns the target of its segment.
float shade_miss(inout Path path, inout Tally tally) {
    // 1. Emission: the environment's radiance.
    vec3 emission = environment_radiance(path.ray.direction);
    count_light_hit(tally, path.depth, emission);
    if (NEE) emission *= emission_weight(path, pdf_light_at_end(path));
    path.radiance += path.throughput * visible_emission(path, emission);

    // 4. Learning: the segment brings the environment's radiance and nothing else.
    path.last_vertex.light = emission;
    float target = path.depth < MAX_DEPTH && !keeps_vertices() ? mean_rgb(emission) : NO_TARGET;
    if (weakens_light()) target = target_through(path, target);
    if (path.depth == MAX_DEPTH) path.last_vertex.segment = NO_SEGMENT;
    end_path(path);
    return target;
}

// Density with which emitter sampling draws the direction to a place where the path has met emission.
float pdf_light_at_place(Path path, Hit hit, Surface surface) {
    if (has_media() && surface.emitter == NONE) return 0.0;
    bool met = true;
    if (bends_light() && path.refractions != 0u) {
        LightPlace place = LightPlace(hit.primitive, hit.instance);
        met = meets_light(place, path.previous_position, path.setting_out, surface);
    }
    float pdf = pdf_light_at_surface(hit.primitive, hit.instance, surface, path.previous_position, cell_left(path));
    return met ? pdf : 0.0;
}

// A ray that has met a surface or, with the primitive NONE, a point of a medium. Returns the target of its segment.
float shade_place(inout Path path, Hit hit, Surface surface, Scatterer scatterer, vec4 u, inout Tally tally) {
    // 1. Emission: the surface's own, towards where the path comes from.
    vec3 light = surface_emission(surface, -path.ray.direction);
    count_light_hit(tally, path.depth, light);
    if (NEE) light *= emission_weight(path, pdf_light_at_place(path, hit, surface));
    path.radiance += path.throughput * visible_emission(path, light);
    path.last_vertex.light = light;
    if (path.depth == MAX_DEPTH) {
        path.last_vertex.segment = NO_SEGMENT;
        end_path(path);
        return NO_TARGET;
    }

    // 2. Emitter sampling: what the place scatters of a sampled light.
    Guide guide = guide_at(scatterer);
    if (NEE) {
        LightEvidence evidence;
        vec3 direct = direct_light(path, surface, scatterer, guide, evidence, tally);
        if (learns_lights()) learn_light(evidence, max_component(direct) > 0.0);
        path.radiance += path.throughput * direct;
        light += direct;
        path.last_vertex.light = light;
    }

    // 3. Direction: the guide, or the BSDF or phase function, draws where the path goes on.
    DirectionSample next = sample_direction(path.key, path.depth, u, scatterer, guide);
    count_sample(tally, next.tries, next.lost, next.overrun);

    // 4. Learning: the next segment begins here. The segment that ends here gets a target from `light` and from what the guide
    // knows about the light that the surface scatters. A segment that goes on through the surface collects what lies behind.
    bool straight = goes_straight(scatterer, next.wi);
    bool refracted = is_refracted(surface, scatterer, next.wi);
    bool through = straight;
    if (bends_light()) through = straight || refracted;
    bool meets_emitter = path.refractions != 0u && surface.emitter != NONE;
    if (!through) path.segment = segment_from(scatterer.cell, next);
    if (!through) path.evidence = next.evidence;
    float target = target_at(path.key, path.depth, light, scatterer, next);
    if (weakens_light()) target = through ? NO_TARGET : target_through(path, target);
    if (weakens_light()) remember_passage(path, straight, through && !straight, light, next.weight);

    // 5. Roulette: the path goes on with the probability `survival`.
    if (path.pixel_estimate == 0.0 && knows_contribution(guide, next)) {
        path.pixel_estimate = mean_rgb(path.radiance) + expected_scattered(path.throughput, scatterer, guide);
    }
    float survival = survival_of(path, guide, next);
    if (through) survival = survival_of_straight(path.depth);
    path.throughput *= next.weight;
    path.last_vertex.factor = next.weight;
    path.eta *= next.eta;
    if (max_component(path.throughput) > 0.0 && survives_roulette(path, survival, expected_radiance(guide, next), u.w)) {
        // 6. The next edge begins.
        path.ray = straight ? go_straight(surface, next.wi) : leave_surface(surface, next.wi);
        if (!straight && !refracted) path.previous_position = surface.position;
        if (!through) path.pdf = next.pdf;
        if (bends_light()) {
            if (!through) path.setting_out = next.wi;
            // No connection goes the way that the path goes on: behind a refraction, connections end at the first surface that emits.
            bool given_up = refracted && strays(path.refractions, next.wi, path.setting_out);
            if (through && (meets_emitter || given_up)) path.pdf = 0.0;
        }
        if (has_media()) path.medium = medium_beyond(surface, next.wi, path.medium);
        ++path.depth;
    } else {
        end_path(path);
    }
    return target;
}

// Features of the place that scatters the path first. A point of a medium has no normal.
FirstHit first_hit_of(uint medium, Surface surface, Scatterer scatterer) {
    float depth = distance(surface.position, camera_position());
    vec3 albedo = bsdf_albedo(scatterer.bsdf);
    if (has_media() && surface.material == NONE) albedo = albedo_at(medium, surface.position);
    return FirstHit(true, FilmFeatures(albedo, depth, surface.shading_normal, 0.0));
}

// Adds the light of the medium that a path has flown through, and weights the path by its flight to where its ray has ended.
void end_flight(inout Path path, Flown flown) {
    if (!has_media()) return;
    if (has_feature(FEATURE_GLOW)) {
        path.radiance += path.throughput * flown.glow;
        path.straight_light += path.straight_share * mean_rgb(flown.glow);
    }
    path.throughput *= flown.weight;
    path.straight_share *= mean_rgb(flown.weight);
}

// Weights what a path's vertex gives the segment that leads to it by the flight along the segment.
void weight_vertex(inout PathVertex vertex, Flown flown) {
    if (!has_media()) return;
    vertex.light *= flown.weight;
    vertex.factor *= flown.weight;
    if (has_feature(FEATURE_GLOW)) vertex.light += flown.glow;
}

// A ray that has met a surface or a point of a medium. Returns the target of its segment.
float shade_met(inout Path path, Hit hit, vec4 u, inout FirstHit first_hit, inout Tally tally) {
    Surface surface = place_of_hit(path, hit);
    Scatterer scatterer = scatterer_of_place(path, surface);
    uint medium = path.medium;
    if (!lets_through()) {
        if (path.depth == 1u) first_hit = first_hit_of(medium, surface, scatterer);
        return shade_place(path, hit, surface, scatterer, u, tally);
    }
    bool from_camera = comes_from_camera(path);
    uint straight = path.straight;
    float target = shade_place(path, hit, surface, scatterer, u, tally);
    if (from_camera && !scatterer.passes && path.straight <= straight) first_hit = first_hit_of(medium, surface, scatterer);
    return target;
}

// Handles the end of the path's ray: adds light to the path, and sends the path on or ends it. `u` holds the random numbers
// of direction and roulette. Returns the learning target of the segment that the ray has travelled.
float shade_vertex(inout Path path, Hit hit, vec4 u, inout FirstHit first_hit, inout Tally tally) {
    count_ray(tally, path.depth);
    Flown flown = flown_to(path, hit);
    end_flight(path, flown);
    float target;
    if (meets_nothing(path, hit)) {
        target = shade_miss(path, tally);
    } else {
        target = shade_met(path, hit, u, first_hit, tally);
    }
    weight_vertex(path.last_vertex, flown);
    return target;
}

// Records a segment's target in the guide. `u` in [0, 1) rounds it.
void learn(Segment travelled, ShareEvidence evidence, float target, float u, inout Tally tally) {
    if (!is_learning()) return;
    if (record(travelled, target, u)) ++tally.nonfinite;
    if (learns_share()) add_evidence(evidence, target, u);
}

#endif
