// Points of surfaces at other times than that of the path that has met them.
#ifndef COURSE_GLSL
#define COURSE_GLSL
#include "geometry/surface.glsl"

// Point of a primitive that moves with it.
struct SurfacePoint {
    Hit hit;
    vec3 at;  // coordinates in the axes of a sphere, as shares of its radius
};

// Primitive of a hit in the world, at the time `moment`.
PrimitiveRecord placed_primitive(Hit hit) {
    PrimitiveRecord p = primitive_now(hit.primitive);
    if (is_moved(hit.instance)) p = primitive_in_world(p, placement_of(hit.instance));
    return p;
}

// Axes of a sphere in the world, each as long as the radius.
mat3 axes_of_sphere(PrimitiveRecord p) {
    return mat3(p.edge_u, cross(p.edge_v, p.edge_u) / p.edge_tolerance, p.edge_v);
}

bool is_round(uint flags) {
    return (flags & PRIMITIVE_SHAPE_MASK) == SHAPE_SPHERE || (flags & PRIMITIVE_FACING) != 0u;
}

// The point of a hit at the time of its path, at which it lies at `position`.
SurfacePoint point_of_hit(Hit hit, vec3 position) {
    SurfacePoint point = SurfacePoint(hit, vec3(0.0));
    PrimitiveRecord p = placed_primitive(hit);
    if (is_round(p.flags)) point.at = (position - p.origin) * axes_of_sphere(p) / (p.edge_tolerance * p.edge_tolerance);
    return point;
}

// Position of the point at the time `moment`.
vec3 place_of_point(SurfacePoint point) {
    PrimitiveRecord p = placed_primitive(point.hit);
    if (is_round(p.flags)) return p.origin + axes_of_sphere(p) * point.at;
    return p.origin + point.hit.uv.x * p.edge_u + point.hit.uv.y * p.edge_v;
}

#endif
