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

// Moves the ray behind a surface, and aims it at the light again.
void cross_surface(inout Passage passage, Hit hit, vec3 target, bool is_bound) {
    Ray ray = passage.ray;
    Surface surface = surface_at(ray, hit);
    if (has_flag(surface.material, MATERIAL_LETS_THROUGH)) {
        cross_medium(passage, hit.t);
        passage.share *= straight_share(surface, -ray.direction);
    } else {
        passage.share = vec3(0.0);
    }
    bool arrives = max_component(passage.share) > 0.0;
    if (arrives && passage.left == 0u) {
        if (is_bound) count(COUNTER_CUT_SHADOW_RAYS, 1u);
        passage.share = vec3(0.0);
        arrives = false;
    }
    passage.ray = go_straight(surface, ray.direction);
    if (has_media()) passage.medium = medium_beyond(surface, ray.direction, passage.medium);
    if (ray.t_max < MAX_DISTANCE) {
        vec3 d = target - passage.ray.origin;
        float remaining = length(d);
        arrives = arrives && dot(d, ray.direction) > 0.0;
        passage.ray.direction = d / max(remaining, 1.0e-30);
        passage.ray.t_max = remaining;
    }
    passage.left -= passage.left > 0u ? 1u : 0u;
    passage.more = arrives;
}

// Share of a light that arrives along a shadow ray which leaves a path's vertex, in a medium, after `depth` edges. The connection is an edge,
// and so is what follows each surface that it crosses. It has no more edges than a path may have. Where paths have no maximum,
// a ray that reaches the bound of the kernels is counted.
vec3 share_that_passes(Ray ray, uint medium, RandomKey key, uint depth, inout bool overrun) {
    vec3 target = ray.origin + ray.t_max * ray.direction;
    Passage passage = Passage(ray, vec3(1.0), medium, MAX_DEPTH - 1u - depth, true, RandomStream(uvec4(1u)));
    if (has_volumes()) passage.stream = random_stream(key, depth, RANDOM_SHADOW);
    bool is_bound = SURE_ROULETTE_DEPTH != NONE;
    // Most rays meet no surface that lets light through. The first traversal takes any surface, the others the nearest ones.
    bool any_hit = true;
    uint turns = passage.left + 2u;
    while (passage.more && turns > 0u) {
        --turns;
        Hit hit = traverse(passage.ray, any_hit, overrun);
        if (hit.primitive == NONE) {
            cross_medium(passage, passage.ray.t_max);
            passage.more = false;
        } else if (!any_hit) {
            cross_surface(passage, hit, target, is_bound);
        } else if (!has_flag(attribute_material(hit.primitive), MATERIAL_LETS_THROUGH)) {
            passage.share = vec3(0.0);
            passage.more = false;
        }
        any_hit = false;
        if (!passage.more || turns == 0u) break;
    }
    overrun = overrun || passage.more;
    return passage.share;
}

// Multiplies a connection's light, and what it teaches, by the share that surfaces and media let through. The connection leaves a path's
// vertex, in a medium, after `depth` edges.
void pass_connection(inout Connection connection, uint medium, RandomKey key, uint depth, inout bool overrun) {
    vec3 share = share_that_passes(connection.ray, medium, key, depth, overrun);
    if (share == vec3(1.0)) return;
    vec3 arriving = connection.light * share;
    float part = mean_rgb(arriving) / max(mean_rgb(connection.light), 1.0e-37);
    connection.evidence.units = uint(float(connection.evidence.units) * min(part, 0.9999999));
    connection.light = arriving;
}

#endif
