// Media between surfaces: fog, milk, wax. Media that are grids follow in tracking.glsl. A path knows the number of the medium that it is in, counted from 1; 0 is empty
// space. A surface that bounds media tells the number on each of its sides.
//
// Free flight: a path chooses a color channel in proportion to its throughput, and flies as far as this channel's extinction has it. The
// weight divides by the mean density over all channels, with the same proportions (one-sample multiple importance sampling over
// wavelengths; Miller, Georgiev and Jarosz 2019). Without absorption, the sum of the throughput's channels then never changes.
#ifndef MEDIUM_GLSL
#define MEDIUM_GLSL
#include "bsdf/material.glsl"
#include "bsdf/phase.glsl"
#include "film/frame.glsl"
#include "geometry/surface.glsl"
#include "random/random.glsl"

// Number of the space without a medium.
const uint NO_MEDIUM = 0u;

// Whether the scene has media.
bool has_media() {
    return has_kind(BSDF_PHASE);
}

// Record of a medium.
uint record_of_medium(uint medium) {
    return scene().first_medium + medium - 1u;
}

// Extinction coefficient, per scene unit.
vec3 extinction_of(uint medium) {
    return material_colors(record_of_medium(medium), 1u).rgb;
}

// Share of the extinction that is scattering.
vec3 albedo_of(uint medium) {
    return material_colors(record_of_medium(medium), 2u).rgb;
}

// Optical depth from which no light is counted: exp of its negative is a denormal number.
const float MOST_DEPTH = 88.0;

// Share of light that comes through so much of a medium.
vec3 transmittance(vec3 extinction, float distance) {
    return mix(exp(-extinction * distance), vec3(0.0), greaterThan(extinction * distance, vec3(MOST_DEPTH)));
}

vec3 transmittance_of(uint medium, float distance) {
    return medium == NO_MEDIUM ? vec3(1.0) : transmittance(extinction_of(medium), distance);
}

// Medium in which a ray leaves a surface in a direction. A surface that is no boundary does not change the medium, nor does a point of
// a medium, which has no material.
uint medium_beyond(Surface surface, vec3 direction, uint medium) {
    if (surface.material == NONE) return medium;
    if ((material_kind_and_flags(surface.material) & MATERIAL_BOUNDARY) == 0u) return medium;
    uint media = material_media(surface.material);
    bool inside = dot(direction, surface.geometric_normal) < 0.0;
    return inside ? media & ((1u << EXTERIOR_MEDIUM_SHIFT) - 1u) : media >> EXTERIOR_MEDIUM_SHIFT;
}

// Probability of each color channel to decide how far a path flies.
vec3 channel_shares(vec3 throughput) {
    float sum = throughput.r + throughput.g + throughput.b;
    return sum > 0.0 ? throughput / sum : vec3(1.0 / 3.0);
}

// -log(1 - u) for the random words `bits` of u. Both u and 1 - u are exact where they are small, so that thin media scatter as seldom, and
// thick ones let as little pass, as they should. The series is that of the area hyperbolic tangent; a driver's log would err by 1e-5.
float exponential_sample(uvec2 bits) {
    float fine = (unit_float(bits.y) + 0.5 / 16777216.0) * (1.0 / 16777216.0);
    float u = unit_float(bits.x) + fine;
    uint v_bits = floatBitsToUint(unit_float(~bits.x) + (1.0 / 16777216.0 - fine));
    int exponent = int(v_bits >> 23u) - 127;
    float excess = uintBitsToFloat((v_bits & 0x7fffffu) | 0x3f800000u) - 1.0;
    if (excess > 0.5) {
        excess = 0.5 * excess - 0.5;
        ++exponent;
    }
    bool near = u < 0.25;
    excess = near ? -u : excess;
    float s = excess / (2.0 + excess);
    float s2 = s * s;
    float series = 2.0 * s * (1.0 + s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0 + s2 * (1.0 / 9.0 + s2 * (1.0 / 11.0))))));
    return -(series + (near ? 0.0 : float(exponent) * 0.69314718056));
}

// Distance at which a path next meets a particle of the medium, if nothing is in its way.
float flight_distance(uint medium, vec3 throughput, RandomKey key, uint vertex) {
    uvec4 bits = random_bits(key, vertex, RANDOM_FLIGHT);
    vec3 shares = channel_shares(throughput);
    vec3 extinction = extinction_of(medium);
    float u = unit_float(bits.z);
    float chosen = u < shares.r ? extinction.r : (u < shares.r + shares.g ? extinction.g : extinction.b);
    return min(exponential_sample(bits.xy) / max(chosen, 1.0e-37), MAX_DISTANCE);
}

// Factor of a path's throughput over a flight that ended at a particle, whose albedo is not part of it, or before at a surface or nowhere.
vec3 flight_weight(uint medium, vec3 throughput, float distance, bool scatters) {
    vec3 extinction = extinction_of(medium);
    vec3 density = transmittance(extinction, distance);
    if (scatters) density *= extinction;
    float mean = dot(channel_shares(throughput), density);
    return mean > 0.0 ? density / mean : vec3(0.0);
}

// Point of a medium, as a surface without extent, material and normal.
Surface point_of_medium(vec3 position) {
    Surface s = NO_SURFACE;
    s.position = position;
    return s;
}

#endif
