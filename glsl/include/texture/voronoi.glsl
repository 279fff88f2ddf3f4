// Voronoi diagrams of jittered grids in one to four dimensions, as Blender has them, and their sums of octaves.
#ifndef VORONOI_GLSL
#define VORONOI_GLSL
#include "shared/variant.glsl"
#include "texture/hash.glsl"

struct Voronoi {
    uint dimensions;
    uint feature;     // VORONOI_NEAREST to VORONOI_RADIUS
    uint metric;      // METRIC_*
    bool normalized;
    float exponent;   // of METRIC_MINKOWSKI
    float detail;     // octaves after the first; the last counts by the fraction
    float roughness;  // factor of amplitudes from octave to octave
    float lacunarity; // factor of frequencies from octave to octave
    float smoothness; // from 0 to 0.5
    float randomness; // distance of points from the corners of their cells
};

struct VoronoiValue {
    float distance;
    vec3 color;
    vec4 position;
};

float voronoi_metric(Voronoi v, vec4 d) {
    d = abs(d);
    if (v.metric == METRIC_MANHATTAN) return d.x + d.y + d.z + d.w;
    if (v.metric == METRIC_CHEBYCHEV) return max(max(d.x, d.y), max(d.z, d.w));
    if (v.metric == METRIC_MINKOWSKI) {
        vec4 powers = mix(pow(max(d, vec4(1.0e-30)), vec4(v.exponent)), vec4(0.0), equal(d, vec4(0.0)));
        return pow(powers.x + powers.y + powers.z + powers.w, 1.0 / v.exponent);
    }
    return length(d);
}

// Point of a cell relative to the cell `base`, from which `offset` leads to it, and the cell's color.
struct VoronoiCell {
    vec4 point;
    vec3 color;
};

VoronoiCell voronoi_cell(Voronoi v, vec4 base, vec4 offset) {
    vec4 cell = base + offset;
    vec4 jitter;
    vec3 color;
    if (has_operation(OPERATION_VORONOI_1D) && v.dimensions == 1u) {
        color = color_of_floats(1u, cell);
        jitter = vec4(color.x, 0.0, 0.0, 0.0);
    } else {
        jitter = hash_of_cell(v.dimensions, ivec4(cell));
        color = v.dimensions == 2u ? hash_of_cell(3u, ivec4(cell)).xyz : jitter.xyz;
        if (v.dimensions < 4u) jitter.w = 0.0;
        if (v.dimensions < 3u) jitter.z = 0.0;
    }
    return VoronoiCell(offset + jitter * v.randomness, color);
}

// Offset of a neighbor: its number in a cube of `side` cells along each dimension, x first.
vec4 neighbor_offset(uint dimensions, uint number, uint side) {
    uvec4 digits = uvec4(number, number / side, number / (side * side), number / (side * side * side));
    digits -= side * (digits / side);
    return mix(vec4(0.0), vec4(digits) - float(side / 2u), lessThan(uvec4(0u, 1u, 2u, 3u), uvec4(dimensions)));
}

uint neighbor_count(uint dimensions, uint side) {
    uint count = side;
    if (dimensions > 1u) count *= side;
    if (dimensions > 2u) count *= side;
    if (dimensions > 3u) count *= side;
    return count;
}

// What has been found among the neighbors.
struct VoronoiScan {
    VoronoiValue nearest;   // the smooth mean for VORONOI_SMOOTH
    VoronoiValue second;
    vec4 nearest_offset;
    vec4 middle;            // point of the cell itself
    float least;            // least distance of the second round
    bool begun;
};

void add_smoothly(inout VoronoiScan scan, Voronoi v, VoronoiValue next) {
    VoronoiValue mean = scan.nearest;
    float t = clamp(0.5 + 0.5 * (mean.distance - next.distance) / v.smoothness, 0.0, 1.0);
    float h = scan.begun ? t * t * (3.0 - 2.0 * t) : 1.0;
    float correction = v.smoothness * h * (1.0 - h);
    scan.begun = true;
    scan.nearest.distance = mix(mean.distance, next.distance, h) - correction;
    correction /= 1.0 + 3.0 * v.smoothness;
    scan.nearest.color = mix(mean.color, next.color, h) - correction;
    vec4 used = mix(vec4(0.0), vec4(1.0), lessThan(uvec4(0u, 1u, 2u, 3u), uvec4(v.dimensions)));
    scan.nearest.position = mix(mean.position, next.position, h) - correction * used;
}

void keep_nearest(inout VoronoiScan scan, VoronoiValue next, vec4 offset) {
    if (next.distance < scan.nearest.distance) {
        scan.second = scan.nearest;
        scan.nearest = next;
        scan.nearest_offset = offset;
    } else if (next.distance < scan.second.distance) {
        scan.second = next;
    }
}

// Distance that the second round asks for: to the edge between the nearest point and another, or half of that between the two. On a
// line, the edges are those of the cell's own point.
float second_round_distance(Voronoi v, VoronoiScan scan, vec4 local, vec4 point, vec4 offset) {
    const float far = 3.0e38;
    vec4 nearest = scan.nearest.position;
    vec4 across = point - nearest;
    float squared = dot(across, across);
    if (v.feature == VORONOI_RADIUS) return any(notEqual(offset, scan.nearest_offset)) ? 0.5 * sqrt(squared) : far;
    if (v.dimensions == 1u) return offset.x != 0.0 ? abs(0.5 * (scan.middle.x + point.x) - local.x) : far;
    return squared > 0.0001 ? dot(0.5 * (nearest + point) - local, across * inversesqrt(squared)) : far;
}

// One octave. Edges and radii take two rounds: the nearest point, and then what is nearest to it.
VoronoiValue voronoi_octave(Voronoi v, vec4 p) {
    const float far = 3.0e38;
    vec4 base = floor(p);
    vec4 local = p - base;
    bool two_rounds = v.feature == VORONOI_EDGE || v.feature == VORONOI_RADIUS;
    uint side = v.feature == VORONOI_SMOOTH ? 5u : 3u;
    uint count = neighbor_count(v.dimensions, side);
    uint total = two_rounds ? 2u * count : count;
    VoronoiValue none = VoronoiValue(far, vec3(0.0), vec4(0.0));
    VoronoiScan scan = VoronoiScan(none, none, vec4(0.0), vec4(0.0), far, false);
    bool more = true;
    for (uint number = 0u; number < 625u && more; ++number) {
        bool second_round = number >= count;
        vec4 offset = neighbor_offset(v.dimensions, second_round ? number - count : number, side);
        if (second_round && v.feature == VORONOI_RADIUS) offset += scan.nearest_offset;
        VoronoiCell cell = voronoi_cell(v, base, offset);
        VoronoiValue next = VoronoiValue(voronoi_metric(v, cell.point - local), cell.color, cell.point);
        if (more && second_round) {
            scan.least = min(scan.least, second_round_distance(v, scan, local, cell.point, offset));
        } else if (more && v.feature == VORONOI_SMOOTH) {
            add_smoothly(scan, v, next);
        } else if (more) {
            keep_nearest(scan, next, offset);
            if (all(equal(offset, vec4(0.0)))) scan.middle = cell.point;
        }
        more = number + 1u < total;
        if (!more) break;
    }
    VoronoiValue value = scan.nearest;
    if (v.feature == VORONOI_SECOND) value = scan.second;
    value.position += base;
    if (two_rounds) value = VoronoiValue(scan.least, vec3(0.0), vec4(0.0));
    return value;
}

// Largest distance to the nearest point, for one octave.
float voronoi_reach(Voronoi v) {
    float side = 0.5 + 0.5 * v.randomness;
    if (v.feature == VORONOI_EDGE) return side;
    vec4 corner = mix(vec4(0.0), vec4(side), lessThan(uvec4(0u, 1u, 2u, 3u), uvec4(v.dimensions)));
    return voronoi_metric(v, corner) * (v.feature == VORONOI_SECOND ? 2.0 : 1.0);
}

// Sum of octaves. Distances to edges are the least of all octaves.
VoronoiValue fractal_voronoi(Voronoi v, vec4 p) {
    v.detail = clamp(v.detail, 0.0, 15.0);
    v.roughness = clamp(v.roughness, 0.0, 1.0);
    v.randomness = clamp(v.randomness, 0.0, 1.0);
    v.smoothness = clamp(0.5 * v.smoothness, 0.0, 0.5);
    if (v.feature == VORONOI_SMOOTH && v.smoothness == 0.0) v.feature = VORONOI_NEAREST;
    bool edge = v.feature == VORONOI_EDGE;
    if (v.dimensions == 1u || edge || v.feature == VORONOI_RADIUS) v.metric = METRIC_EUCLIDEAN;
    bool single = v.detail == 0.0 || v.roughness == 0.0 || v.feature == VORONOI_RADIUS;
    float reach = voronoi_reach(v);
    float amplitude = 1.0;
    float amplitudes = edge ? reach : (single ? 1.0 : 0.0);
    float scale = 1.0;
    VoronoiValue sum = VoronoiValue(edge ? 8.0 : 0.0, vec3(0.0), vec4(0.0));
    bool more = true;
    for (uint octave = 0u; octave < 16u && more; ++octave) {
        VoronoiValue found = voronoi_octave(v, scale * p);
        bool whole = single || float(octave) <= v.detail;
        float share = whole ? 1.0 : v.detail - floor(v.detail);
        if (more && single) sum = found;
        if (more && !single && edge) {
            float nearer = mix(sum.distance, min(sum.distance, found.distance / scale), amplitude);
            sum.distance = mix(sum.distance, whole ? nearer : min(sum.distance, nearer), share);
            amplitudes = mix(amplitudes, mix(amplitudes, reach / scale, amplitude), share);
        }
        if (more && !single && !edge) {
            amplitudes += share * amplitude;
            sum.distance += share * amplitude * found.distance;
            sum.color += share * amplitude * found.color;
            sum.position = mix(sum.position, mix(sum.position, found.position / scale, amplitude), share);
        }
        scale *= v.lacunarity;
        amplitude *= v.roughness;
        more = !single && octave + 1u < 16u && float(octave + 1u) < v.detail + 1.0;
        if (!more) break;
    }
    if (v.normalized && v.feature != VORONOI_RADIUS) {
        sum.distance /= edge ? amplitudes : amplitudes * reach;
        sum.color /= edge ? 1.0 : amplitudes;
    }
    return sum;
}

#endif
