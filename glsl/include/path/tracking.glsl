// Flights and shadow rays through media that are grids. A flight meets as many particles as the majorant has, real ones and ones that
// change nothing (delta tracking: Woodcock et al. 1965). A shadow ray is multiplied by the share of those that change nothing (ratio
// tracking: Novak, Selle and Jarosz 2014).
//
// Colors: a particle is real with the mean probability over the channels, in proportion to the throughput as it is there. This is
// one-sample multiple importance sampling over wavelengths (Miller, Georgiev and Jarosz 2019), as in medium.glsl: no particle changes
// the sum of the throughput's channels.
#ifndef TRACKING_GLSL
#define TRACKING_GLSL
#include "path/medium.glsl"
#include "path/volume.glsl"

// Most blocks and particles of one flight or shadow ray. Blocks are at most three times MOST_BLOCKS of src/scene/medium.rs. A ray that reaches
// this bound is counted, and brings no light.
const uint MOST_TURNS = 16384u;

// Share of the light below which a shadow ray goes on by chance, with the probability of one half.
const float SMALL_SHARE = 0.02;

// Volume of a medium's extinction; NONE for a homogeneous medium.
uint volume_of(uint medium) {
    return material_material0(record_of_medium(medium));
}

// Whether a ray in this medium is in a grid.
bool is_volume(uint medium) {
    if (!has_volumes()) return false;
    return medium != NO_MEDIUM && volume_of(medium) != NONE;
}

// Extinction of a medium at a point.
vec3 extinction_at(uint medium, vec3 position) {
    vec3 extinction = extinction_of(medium);
    if (!is_volume(medium)) return extinction;
    VolumeRecord volume = load_volume(volume_of(medium));
    return extinction * volume_value(volume, place_in_volume(volume, position));
}

// Share of the extinction that is scattering, at a point.
vec3 albedo_at(uint medium, vec3 position) {
    vec3 albedo = albedo_of(medium);
    if (!is_volume(medium)) return albedo;
    uint at = material_material1_or_relief(record_of_medium(medium));
    if (at == NONE) return albedo;
    VolumeRecord volume = load_volume(at);
    albedo *= volume_value(volume, place_in_volume(volume, position));
    if ((volume.flags & VOLUME_SCATTERING) != 0u) albedo /= max(extinction_at(medium, position), 1.0e-30);
    return clamp(albedo, 0.0, 1.0);
}

// Radiance that a deep layer of the medium without scattering would emit, as it is at a point.
vec3 emission_at(uint medium, vec3 position) {
    uint record = record_of_medium(medium);
    vec3 emission = material_coating_specular(record);
    uint at = material_media(record);
    if (!has_volumes() || at == NONE) return emission;
    VolumeRecord volume = load_volume(at);
    return emission * volume_value(volume, place_in_volume(volume, position));
}

float next_exponential(inout RandomStream stream) {
    uint first = next_bits(stream);
    return exponential_sample(uvec2(first, next_bits(stream)));
}

// Flight through a grid.
struct Flight {
    float t;        // distance to the particle, or of the whole ray
    bool scatters;  // the flight ends at a particle
    vec3 weight;    // factor of the throughput, albedo excluded
};

// Flies along a ray, in a medium that is a grid. The stream of random numbers belongs to the flight alone.
Flight fly(uint medium, Ray ray, vec3 throughput, RandomStream stream) {
    VolumeRecord volume = load_volume(volume_of(medium));
    VolumeWalk walk = start_walk(volume, ray);
    Flight flight = Flight(ray.t_max, false, vec3(1.0));
    vec3 extinction = extinction_of(medium);
    vec3 shares = channel_shares(throughput);
    float left = next_exponential(stream);
    uint turns = MOST_TURNS;
    while (walk.more && turns > 0u) {
        --turns;
        float depth = walk.majorant * max(end_of_block(walk) - walk.t, 0.0);
        if (depth > left) {
            walk.t += left / walk.majorant;
            vec3 value = volume_value(volume, walk.origin + walk.t * walk.direction);
            vec3 real = min(extinction * value / walk.majorant, 1.0);
            float mean = dot(shares, real);
            flight.scatters = next_random(stream) < mean;
            vec3 factor = flight.scatters ? real / mean : (1.0 - real) / max(1.0 - mean, 1.0e-30);
            flight.weight *= factor;
            shares *= factor;
            if (flight.scatters) flight.t = min(flight.t, walk.t);
            walk.more = !flight.scatters;
            left = next_exponential(stream);
        } else {
            left -= depth;
            leave_block(walk, volume);
        }
        if (!walk.more || turns == 0u) break;
    }
    if (walk.more) {
        count(COUNTER_CUT_FLIGHTS, 1u);
        flight.weight = vec3(0.0);
    }
    return flight;
}

// Share of light that comes through a medium that is a grid, along a ray. The expectation is exact.
vec3 tracked_transmittance(uint medium, Ray ray, inout RandomStream stream) {
    VolumeRecord volume = load_volume(volume_of(medium));
    VolumeWalk walk = start_walk(volume, ray);
    vec3 share = vec3(1.0);
    vec3 extinction = extinction_of(medium);
    float left = next_exponential(stream);
    uint turns = MOST_TURNS;
    while (walk.more && turns > 0u) {
        --turns;
        float depth = walk.majorant * max(end_of_block(walk) - walk.t, 0.0);
        if (depth > left) {
            walk.t += left / walk.majorant;
            vec3 value = volume_value(volume, walk.origin + walk.t * walk.direction);
            share *= 1.0 - min(extinction * value / walk.majorant, 1.0);
            if (max_component(share) < SMALL_SHARE) share *= next_random(stream) < 0.5 ? 2.0 : 0.0;
            walk.more = max_component(share) > 0.0;
            left = next_exponential(stream);
        } else {
            left -= depth;
            leave_block(walk, volume);
        }
        if (!walk.more || turns == 0u) break;
    }
    if (walk.more) {
        count(COUNTER_CUT_FLIGHTS, 1u);
        share = vec3(0.0);
    }
    return share;
}

#endif
