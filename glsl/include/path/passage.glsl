// Passage of a shadow ray through surfaces that let light go straight on, and through media.
#ifndef PASSAGE_GLSL
#define PASSAGE_GLSL
#include "geometry/traverse.glsl"
#include "path/connection.glsl"
#include "path/medium.glsl"
#include "path/straight.glsl"
#include "path/tracking.glsl"

// Ray to a light, on its way through surfaces.
struct Passage {
    Ray ray;
    vec3 share;  // of the light that has come through surfaces and media so far
    uint medium; // number of the medium that the ray travels in
    uint left;   // surfaces that the ray may still cross
    bool more;   // the ray has not arrived
    uint refractions;  // of the ray so far
    vec3 radiance;     // of the connection's light, where a refracted ray has met it
    RandomStream stream;  // random numbers of the way through grids
};

// Multiplies the share by what the medium lets through over a distance of the ray.
void cross_medium(inout Passage passage, float distance) {
    if (!has_media()) return;
    if (is_volume(passage.medium)) {
        Ray ray = passage.ray;
        ray.t_max = distance;
        passage.share *= tracked_transmittance(passage.medium, ray, passage.stream);
    } else {
        passage.share *= transmittance_of(passage.medium, distance);
    }
}

// A refracted ray has met a surface that emits: the light of its connection, or another one.
void meet_light(inout Passage passage, Hit hit, Surface surface, LightPlace light) {
    cross_medium(passage, hit.t);
    bool own = hit.primitive == light.primitive && hit.instance == light.instance;
    passage.radiance = own ? surface_emission(surface, -passage.ray.direction) : vec3(0.0);
    passage.more = false;
}

// Moves the ray behind a surface. A straight ray is aimed at the light again.
void cross_surface(inout Passage passage, Hit hit, Surface surface, Connection connection, vec3 target, bool is_bound) {
    Ray ray = passage.ray;
    vec3 direction = ray.direction;
    if (may_pass(surface.material)) {
        cross_medium(passage, hit.t);
        Transmission transmission = transmission_at(surface, -ray.direction);
        passage.share *= transmission.share;
        direction = transmission.direction;
    } else {
        passage.share = vec3(0.0);
    }
    if (bends_light() && has_flag(surface.material, MATERIAL_REFRACTS)) {
        ++passage.refractions;
        bool can_meet = max_component(connection.scattered) > 0.0;
        bool given_up = !can_meet || strays(passage.refractions, direction, connection.ray.direction);
        if (given_up) passage.share = vec3(0.0);
    }
    bool arrives = max_component(passage.share) > 0.0;
    if (arrives && passage.left == 0u) {
        if (is_bound) count(COUNTER_CUT_SHADOW_RAYS, 1u);
        passage.share = vec3(0.0);
        arrives = false;
    }
    passage.ray = go_straight(surface, direction);
    if (has_media()) passage.medium = medium_beyond(surface, direction, passage.medium);
    if (ray.t_max < MAX_DISTANCE && passage.refractions == 0u) {
        vec3 d = target - passage.ray.origin;
        float remaining = length(d);
        arrives = arrives && dot(d, ray.direction) > 0.0;
        passage.ray.direction = d / max(remaining, 1.0e-30);
        passage.ray.t_max = remaining;
    }
    passage.left -= passage.left > 0u ? 1u : 0u;
    passage.more = arrives;
}

// A ray has met nothing more on its way.
void leave_surfaces(inout Passage passage, LightPlace light) {
    cross_medium(passage, passage.ray.t_max);
    if (passage.refractions != 0u && light.primitive == NONE) passage.radiance = environment_radiance(passage.ray.direction);
    passage.more = false;
}

// The way of a connection's shadow ray to its light. The connection leaves a path's vertex, in a medium, after `depth` edges. It is an
// edge, and so is what follows each surface that it crosses. It has no more edges than a path may have. Where paths have no maximum,
// a ray that reaches the bound of the kernels is counted.
Passage way_of(Connection connection, uint medium, RandomKey key, uint depth, inout bool overrun) {
    Ray ray = connection.ray;
    vec3 target = ray.origin + ray.t_max * ray.direction;
    Passage passage =
        Passage(ray, vec3(1.0), medium, MAX_DEPTH - 1u - depth, true, 0u, vec3(0.0), RandomStream(uvec4(1u)));
    if (has_volumes()) passage.stream = random_stream(key, depth, RANDOM_SHADOW);
    bool is_bound = SURE_ROULETTE_DEPTH != NONE;
    // Most rays meet no surface that lets light through. The first traversal takes any surface, the others the nearest ones. Refraction may
    // lead a ray past a surface that lies on its straight line, so that where light bends, the first traversal takes the nearest one, too.
    bool any_hit = !bends_light();
    uint turns = passage.left + 2u;
    while (passage.more && turns > 0u) {
        --turns;
        Hit hit = traverse(passage.ray, any_hit, overrun);
        if (hit.primitive == NONE) {
            leave_surfaces(passage, connection.place);
        } else if (!any_hit) {
            Surface surface = surface_at(passage.ray, hit);
            bool ends = false;
            if (bends_light()) ends = passage.refractions != 0u && surface.emitter != NONE;
            if (ends) meet_light(passage, hit, surface, connection.place);
            else cross_surface(passage, hit, surface, connection, target, is_bound);
        } else if (!may_pass(attribute_material(hit.primitive))) {
            passage.share = vec3(0.0);
            passage.more = false;
        }
        any_hit = false;
        if (!passage.more || turns == 0u) break;
    }
    overrun = overrun || passage.more;
    return passage;
}

// Multiplies a connection's light, and what it teaches, by the share that surfaces and media let through. The connection leaves a path's
// vertex, in a medium, after `depth` edges. Light that has been refracted is that of the place which the ray has met.
void pass_connection(inout Connection connection, uint medium, RandomKey key, uint depth, inout bool overrun) {
    Passage passage = way_of(connection, medium, key, depth, overrun);
    if (passage.refractions == 0u && passage.share == vec3(1.0)) return;
    vec3 arriving = connection.light * passage.share;
    if (bends_light() && passage.refractions != 0u) arriving = connection.scattered * passage.radiance * passage.share;
    float part = mean_rgb(arriving) / max(mean_rgb(connection.light), 1.0e-37);
    connection.evidence.units = uint(float(connection.evidence.units) * min(part, 0.9999999));
    connection.light = arriving;
}

#endif
