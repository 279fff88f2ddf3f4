// Triangles whose vertices move while the shutter is open: along a line from one key to the next, at whose ends src/encode/bvh/deforming.rs
// writes where they are. Normals of vertices are mixed in the same way.
#ifndef DEFORMING_GLSL
#define DEFORMING_GLSL
#include "geometry/bvh.glsl"
#include "geometry/motion.glsl"
#include "geometry/normals.glsl"

bool is_deforming(uint flags) {
    if (HAS_DEFORMING) return (flags & PRIMITIVE_DEFORMING) != 0u;
    return false;
}

// Keys of a deforming triangle before and after the path's time, and the part of the way between them.
struct Keys {
    KeyRecord before;
    KeyRecord after;
    float way;
};

Keys keys_now(uint primitive) {
    uint count = deforming_intervals(primitive);
    precise float place = moment * float(count);
    uint at = min(uint(place), count - 1u);
    precise float way = place - float(at);
    uint first = deforming_first_key(primitive) + at * KEY_TEXELS;
    return Keys(load_key(first), load_key(first + KEY_TEXELS), way);
}

// Primitive at the path's time. Distances to the plane of a deforming triangle are measured from its own origin. Its numbers are exact to
// the last bit wherever they are computed, so that a ray meets the surface where its hit is placed. Vertices are mixed and not edges, so that
// triangles that share a vertex find it in the same place.
PrimitiveRecord primitive_now(uint primitive) {
    PrimitiveRecord p = load_primitive(primitive);
    if (is_deforming(p.flags)) {
        Keys keys = keys_now(primitive);
        precise vec3 a = keys.before.vertex0 + keys.way * (keys.after.vertex0 - keys.before.vertex0);
        precise vec3 b = keys.before.vertex1 + keys.way * (keys.after.vertex1 - keys.before.vertex1);
        precise vec3 c = keys.before.vertex2 + keys.way * (keys.after.vertex2 - keys.before.vertex2);
        precise vec3 edge_u = b - a;
        precise vec3 edge_v = c - a;
        precise float longest = max(length(edge_u), max(length(edge_v), length(edge_u - edge_v)));
        p.origin = a;
        p.edge_u = edge_u;
        p.edge_v = edge_v;
        p.edge_tolerance = longest;
        p.plane = 0.0;
    }
    return p;
}

// Shading normal of a deforming triangle at the path's time, where each vertex's normal is transformed by a matrix before.
vec3 deformed_normal(uint primitive, vec2 uv, vec3 geometric_normal, mat3 transform) {
    Keys keys = keys_now(primitive);
    uvec3 before = uvec3(keys.before.normal0, keys.before.normal1, keys.before.normal2);
    uvec3 after = uvec3(keys.after.normal0, keys.after.normal1, keys.after.normal2);
    vec3 n = mix(interpolated_normal(before, uv, geometric_normal, transform),
                 interpolated_normal(after, uv, geometric_normal, transform), keys.way);
    float squared = dot(n, n);
    return squared > 1.0e-12 ? n * inversesqrt(squared) : geometric_normal;
}

#endif
