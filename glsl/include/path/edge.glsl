// The end of a path's edge: what its ray hits.
#ifndef EDGE_GLSL
#define EDGE_GLSL
#include "geometry/surface.glsl"
#include "geometry/traverse.glsl"

// Most emitters in a row that a camera ray goes through where emitters are hidden.
const uint MOST_HIDDEN = 1024u;

bool emits(uint primitive) {
    return attribute_emitter(primitive) != NONE;
}

// What a ray hits. Hidden emitters let the camera's rays through, as in Mitsuba 3.
Hit end_of_edge(Ray ray, bool from_camera, inout bool overrun) {
    Hit hit = traverse(ray, false, overrun);
    if (HIDE_EMITTERS && from_camera) {
        uint left = MOST_HIDDEN;
        while (left > 0u && hit.primitive != NONE && emits(hit.primitive)) {
            --left;
            Ray rest = leave_surface(surface_at(ray, hit), ray.direction);
            float passed = dot(rest.origin - ray.origin, ray.direction);
            rest.t_max = ray.t_max - passed;
            hit = traverse(rest, false, overrun);
            hit.t += passed;
        }
        overrun = overrun || (hit.primitive != NONE && emits(hit.primitive));
    }
    return hit;
}

#endif
