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

// How a place scatters. A point of a medium scatters by the phase function, in a frame whose z-axis is the direction straight on.
Scatterer scatterer_of_place(Path path, Surface place) {
    if (!has_media() || place.material != NONE) return scatterer_at(place, -path.ray.direction, path.key, path.depth);
    Scatterer scatterer;
    scatterer.bsdf = untextured_bsdf(record_of_medium(path.medium));
    scatterer.frame = basis_from_normal(path.ray.direction);
    scatterer.wo = vec3(0.0, 0.0, -1.0);
    scatterer.upright = vec3(0.0, 0.0, 1.0);
    scatterer.passes = false;
    scatterer.cell = cell_at(place.position);
    return scatterer;
}

#endif
