// The end of a path's edge: what its ray hits.
#ifndef EDGE_GLSL
#define EDGE_GLSL
#include "geometry/surface.glsl"
#include "geometry/traverse.glsl"

// Most shapes in a row that the camera does not see and its ray goes through.
const uint MOST_HIDDEN = 1024u;

// Whether any shape is invisible to the camera.
bool hides_shapes() {
    if (HAS_UNSEEN) return true;
    return HIDE_EMITTERS;
}

// Whether the camera's rays go through a primitive. Hidden emitters let them through, as in Mitsuba 3.
bool is_hidden(uint primitive) {
    bool hidden = HAS_UNSEEN && (load_primitive(primitive).flags & PRIMITIVE_UNSEEN) != 0u;
    if (HIDE_EMITTERS) hidden = hidden || attribute_emitter(primitive) != NONE;
    return hidden;
}

// What a ray hits.
Hit end_of_edge(Ray ray, bool from_camera, inout bool overrun) {
    Hit hit = traverse(ray, false, overrun);
    if (hides_shapes() && from_camera) {
        uint left = MOST_HIDDEN;
        while (left > 0u && hit.primitive != NONE && is_hidden(hit.primitive)) {
            --left;
            Ray rest = leave_surface(surface_at(ray, hit), ray.direction);
            float passed = dot(rest.origin - ray.origin, ray.direction);
            rest.t_max = ray.t_max - passed;
            hit = traverse(rest, false, overrun);
            hit.t += passed;
        }
        overrun = overrun || (hit.primitive != NONE && is_hidden(hit.primitive));
    }
    return hit;
}

#endif
