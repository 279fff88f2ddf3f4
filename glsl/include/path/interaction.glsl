// What a path meets at the end of its ray: a surface, a point of a medium, or nothing.
#ifndef INTERACTION_GLSL
#define INTERACTION_GLSL
#include "path/medium.glsl"
#include "path/path.glsl"
#include "path/scatterer.glsl"
#include "path/tracking.glsl"

// The path's ray, as far as it flies before it meets a particle of a homogeneous medium.
Ray flight_ray(Path path) {
    Ray ray = path.ray;
    if (has_media() && path.medium != NO_MEDIUM && !is_volume(path.medium)) {
        ray.t_max = min(ray.t_max, flight_distance(path.medium, path.throughput, path.key, path.depth));
    }
    return ray;
}

// Lets a path whose ray travels through a grid meet a particle before what the ray hits.
void fly_to_particle(inout Path path, inout Hit hit) {
    if (!is_volume(path.medium)) return;
    Ray ray = path.ray;
    ray.t_max = hit.t;
    Flight flight = fly(path.medium, ray, path.throughput, random_stream(path.key, path.depth, RANDOM_FLIGHT));
    path.flown = flight.weight;
    if (flight.scatters) hit = no_hit(flight.t);
}

// Whether a ray that has hit no surface has met a particle of a medium.
bool ends_in_medium(Path path, Hit hit) {
    return has_media() && path.medium != NO_MEDIUM && hit.primitive == NONE && hit.t < path.ray.t_max;
}

// Whether a ray has met nothing.
bool meets_nothing(Path path, Hit hit) {
    return hit.primitive == NONE && !ends_in_medium(path, hit);
}

// What a flight brings that ends at a hit.
struct Flown {
    vec3 weight;  // factor of the path's throughput
    vec3 glow;    // radiance that the medium emits into the path, throughput excluded
};

Flown flown_to(Path path, Hit hit) {
    Flown flown = Flown(vec3(1.0), vec3(0.0));
    if (!has_media() || path.medium == NO_MEDIUM) return flown;
    bool scatters = ends_in_medium(path, hit);
    flown.weight = path.flown;
    if (!is_volume(path.medium)) flown.weight = flight_weight(path.medium, path.throughput, hit.t, scatters);
    if (!scatters) return flown;
    vec3 position = path.ray.origin + hit.t * path.ray.direction;
    vec3 albedo = albedo_at(path.medium, position);
    if (has_feature(FEATURE_GLOW)) flown.glow = flown.weight * (1.0 - albedo) * emission_at(path.medium, position);
    flown.weight *= albedo;
    return flown;
}

// Where the ray has ended, if it has met anything: on a surface, or at a point of a medium.
Surface place_of_hit(Path path, Hit hit) {
    if (ends_in_medium(path, hit)) return point_of_medium(path.ray.origin + hit.t * path.ray.direction);
    return surface_at(path.ray, hit);
}

// Axis of the world, along +x, +y, +z, -x, -y and -z.
vec3 world_axis(uint i) {
    vec3 axis = vec3(equal(uvec3(i % 3u), uvec3(0u, 1u, 2u)));
    return i < 3u ? axis : -axis;
}

// Axis about which the product sampler draws at a vertex in a medium, from the hemisphere about it. The axis is chosen in proportion to the
// irradiance that the cell has learned. So all axes together draw from the whole sphere in proportion to the radiance, times the sum of
// the cosines to those axes, which lies between 1 and the root of 3. The choice depends on nothing that is drawn later, so that each
// sample is divided by the density given the axis.
vec3 guide_axis(uint cell, RandomKey key, uint vertex) {
    float weights[6];
    float known = 0.0;
    float unknown_axes = 0.0;
    for (uint i = 0u; i < 6u; ++i) {
        Guide guide = guide_of(cell, world_axis(i), SHARE_OF_WHOLES);
        weights[i] = is_filled(guide) ? max(mean_radiance(guide), 0.0) : -1.0;
        known += max(weights[i], 0.0);
        unknown_axes += weights[i] < 0.0 ? 1.0 : 0.0;
    }
    // An axis that no path has asked for yet counts as the mean of the others.
    float unknown = known > 0.0 ? known / (6.0 - unknown_axes) : 1.0;
    float left = unit_float(plain_bits(key, vertex, RANDOM_AXIS).x) * (known + unknown_axes * unknown);
    uint chosen = 0u;
    for (uint i = 0u; i < 6u; ++i) {
        if (left >= 0.0) chosen = i;
        left -= weights[i] < 0.0 ? unknown : weights[i];
    }
    return world_axis(chosen);
}

// How a place scatters. A point of a medium scatters by the phase function, in a frame whose z-axis is the direction straight on, or that of
// the guide.
Scatterer scatterer_of_place(Path path, Surface place) {
    if (!has_media() || place.material != NONE) return scatterer_at(place, -path.ray.direction, path.key, path.depth);
    Scatterer scatterer;
    scatterer.bsdf = untextured_bsdf(record_of_medium(path.medium));
    scatterer.cell = cell_at(place.position);
    scatterer.frame = basis_from_normal(path.ray.direction);
    scatterer.wo = vec3(0.0, 0.0, -1.0);
    if (is_product()) {
        scatterer.frame = basis_from_normal(guide_axis(scatterer.cell, path.key, path.depth));
        scatterer.wo = -path.ray.direction * scatterer.frame;
    }
    scatterer.upright = vec3(0.0, 0.0, 1.0);
    scatterer.passes = false;
    return scatterer;
}

#endif
