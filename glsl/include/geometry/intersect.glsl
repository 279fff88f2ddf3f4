// Intersection of a ray with a primitive.
#ifndef INTERSECT_GLSL
#define INTERSECT_GLSL
#include "math/constants.glsl"
#include "records/geometry.glsl"
#include "shared/kept.glsl"
#include "shared/variant.glsl"

struct Ray {
    vec3 origin;
    vec3 direction;  // unit; in the space of an instance, the image of a unit vector
    float t_max;
};

struct Hit {
    KEPT(hit) float t;  // distance along the ray
    KEPT(hit) vec2 uv;  // coordinates in the primitive's parameterization
    KEPT(hit) uint primitive;
    uint instance;  // that shows the primitive, or NONE
};

Hit no_hit(float t_max) {
    return Hit(t_max, vec2(0.0), NONE, NONE);
}

// Tolerance of the edge tests, per unit of distance and of edge length. The numerators of Moeller and Trumbore's test
// carry a rounding error of about 2^-24 of |origin - vertex| |edge|. Accepting hits by that much outside an edge closes
// the gap between neighboring triangles. A larger tolerance does harm: a grazing ray that passes just beside a ridge
// would hit the back of the triangle beyond the ridge. Measured in tests/render/closed.rs: no gap in 7 * 10^8 rays; 4
// of 10^7 rays hit such ridges, and 18 of 10^7 with a tolerance of 4e-7.
const float EDGE_SLACK = 1.0e-7;

// Cross product of a flat shape's edges. Its rounding is exact to the last bit, because the host computes the plane's
// constant from the same normal.
vec3 plane_normal(vec3 edge_u, vec3 edge_v) {
    precise vec3 n = edge_u.yzx * edge_v.zxy - edge_u.zxy * edge_v.yzx;
    return n;
}

// Position of a point relative to the one from which distances to a flat shape's plane are measured: the shape's own
// origin, or the world's for a shape that is large beside its distance from there.
vec3 from_anchor(vec3 point, PrimitiveRecord p) {
    return (p.flags & PRIMITIVE_LARGE) != 0u ? point : point - p.origin;
}

// Intersects the three flat shapes: the edge tests of Moeller and Trumbore (1997), and the distance by the plane's
// equation. Returns whether the hit (t, uv) was replaced by a nearer one.
bool intersect_flat(Ray ray, PrimitiveRecord p, uint shape, inout float t, inout vec2 uv) {
    vec3 n = plane_normal(p.edge_u, p.edge_v);
    vec3 offset = ray.origin - p.origin;
    vec3 moment = cross(offset, ray.direction);
    float inverse = 1.0 / dot(ray.direction, n);
    float u = -dot(moment, p.edge_v) * inverse;
    float v = dot(moment, p.edge_u) * inverse;
    float distance = (p.plane - dot(n, from_anchor(ray.origin, p))) * inverse;
    float slack = EDGE_SLACK * p.edge_tolerance * (abs(offset.x) + abs(offset.y) + abs(offset.z)) * abs(inverse);
    float outside;
    if (shape == SHAPE_TRIANGLE) outside = max(-min(u, v), u + v - 1.0);
    else if (shape == SHAPE_PARALLELOGRAM) outside = max(abs(u), abs(v)) - 1.0;
    else outside = sqrt(u * u + v * v) - 1.0;
    // A ray along the plane makes these values NaN or infinite, and then every comparison with them is false.
    bool closer = outside <= slack && distance > 0.0 && distance < t && slack < 1.0;
    if (closer) {
        t = distance;
        uv = vec2(u, v);
    }
    return closer;
}

// Square of the distance from a sphere's center, minus the square of the radius. The result errs by about 2^-44 of the
// squares, because differences and products keep what rounding takes from them (Dekker 1971, Knuth's two-sum): so it
// has the right sign close to a large sphere.
float sphere_excess(vec3 point, vec3 center, float radius) {
    precise vec3 difference = point - center;
    precise vec3 taken = difference - point;
    precise vec3 lost = (point - (difference - taken)) - (center + taken);
    vec4 x = vec4(difference, radius);
    precise vec4 shifted = 4097.0 * x;
    precise vec4 high = shifted - (shifted - x);
    precise vec4 low = x - high;
    precise vec4 square = x * x;
    precise vec4 rest = ((high * high - square) + 2.0 * high * low) + low * low;
    precise float sum_xy = square.x + square.y;
    precise float part_y = sum_xy - square.x;
    precise float rest_xy = (square.x - (sum_xy - part_y)) + (square.y - part_y);
    precise float sum_xyz = sum_xy + square.z;
    precise float part_z = sum_xyz - sum_xy;
    precise float rest_xyz = (sum_xy - (sum_xyz - part_z)) + (square.z - part_z);
    precise float sum = sum_xyz - square.w;
    precise float part_w = sum - sum_xyz;
    precise float rest_sum = (sum_xyz - (sum - part_w)) - (square.w + part_w);
    precise float rests = (rest_xy + rest_xyz + rest_sum) + (rest.x + rest.y + rest.z - rest.w);
    precise float excess = sum + (rests + 2.0 * dot(difference, lost));
    return excess;
}

// Intersects a sphere. The nearer root comes from the product of the two roots, and the discriminant from the distance
// of the ray from the center, so that neither cancels for a far origin (Hearn and Baker; Haines et al. 2019, "Precision
// Improvements for Ray/Sphere Intersection"). For an origin near the sphere, whose ray runs along it, the usual
// discriminant is the better one. Returns whether the hit (t, uv) was replaced by a nearer one.
bool intersect_sphere(Ray ray, vec3 center, float radius, inout float t, inout vec2 uv) {
    vec3 offset = ray.origin - center;
    float b = -dot(offset, ray.direction);
    vec3 perpendicular = offset + b * ray.direction;
    float squared = dot(perpendicular, perpendicular);
    float c = sphere_excess(ray.origin, center, radius);
    float discriminant = b * b < squared ? b * b - c : radius * radius - squared;
    float root = sqrt(max(discriminant, 0.0));
    float q = b + (b < 0.0 ? -root : root);
    float t0 = min(c / q, q);
    float t1 = max(c / q, q);
    float distance = t0 > 0.0 ? t0 : t1;
    bool closer = discriminant >= 0.0 && distance > 0.0 && distance < t;
    if (closer) {
        t = distance;
        uv = vec2(0.0);
    }
    return closer;
}

#endif
