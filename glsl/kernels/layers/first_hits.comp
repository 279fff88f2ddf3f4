// Finds what camera rays meet first, for the layers that compositors read: one sample of a pixel for each invocation. Samples follow each
// other pixel by pixel, in the order of the window's rows.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef RAY_QUERIES
#extension GL_EXT_ray_query : require
#endif
#include "geometry/course.glsl"
#include "path/edge.glsl"
#include "path/interaction.glsl"
#include "records/first_hit.glsl"

// Push constants: samples of the dispatch.
struct FirstHitsPush {
    uint first_pixel;   // pixel of the window of the first sample
    uint pixel_count;   // number of pixels
    uint sample_count;  // number of samples of each pixel
};
layout(push_constant, scalar) uniform Push { FirstHitsPush push; };

// Most surfaces with holes that a ray passes.
const uint MOST_HOLES = 256u;

void store_first_hit(uint index, FirstHitRecord r) {
    store_scratch(4u * index, uvec4(floatBitsToUint(r.position), r.primitive));
    store_scratch(4u * index + 1u, uvec4(floatBitsToUint(r.opening), r.instance));
    store_scratch(4u * index + 2u, uvec4(floatBitsToUint(r.closing), r.material));
    store_scratch(4u * index + 3u, floatBitsToUint(vec4(r.uv, r.reserved)));
}

FirstHitRecord record_of(Hit hit, Surface surface) {
    FirstHitRecord r = NO_HIT;
    r.position = surface.position;
    r.opening = surface.position;
    r.closing = surface.position;
    r.primitive = hit.primitive;
    r.instance = hit.instance;
    r.material = surface.material;
    r.uv = surface.uv;
    if (has_time()) {
        SurfacePoint point = point_of_hit(hit, surface.position);
        moment = 0.0;
        r.opening = place_of_point(point);
        moment = 1.0;
        r.closing = place_of_point(point);
    }
    return r;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    bool inside = index < push.pixel_count * push.sample_count;
    uint place = push.first_pixel + index / push.sample_count;
    uvec2 pixel = scene().window_offset + uvec2(place % scene().window_size.x, place / scene().window_size.x);
    Path path = start_path(pixel, key_of_sample(pixel, index % push.sample_count, 0u));
    FirstHitRecord found = NO_HIT;
    bool overrun = false;
    bool more = inside;
    uint left = MOST_HOLES;
    while (more && left > 0u) {
        --left;
        turn_disks_to(path);
        Hit hit = end_of_edge(path.ray, true, overrun);
        more = false;
        if (hit.primitive != NONE) {
            Surface surface = surface_at(path.ray, hit);
            Scatterer scatterer = scatterer_at(surface, -path.ray.direction, path.key, path.depth);
            more = scatterer.passes;
            if (more) {
                path.ray = go_straight(surface, path.ray.direction);
                ++path.depth;
                ++path.straight;
            } else {
                found = record_of(hit, surface);
            }
        }
        if (!more || left == 0u) break;
    }
    if (inside) store_first_hit(index, found);
    count(COUNTER_OVERRUNS, uint(overrun || more));
}
