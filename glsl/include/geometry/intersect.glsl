// Intersection of a ray with a primitive.
#ifndef INTERSECT_GLSL
#define INTERSECT_GLSL
#include "math/constants.glsl"
#include "shared/variant.glsl"

struct Ray {
    vec3 origin;
    vec3 direction;  // unit
    float t_max;
};

struct Hit {
    float t;         // distance along the ray
    vec2 uv;         // coordinates in the primitive's parameterization
    uint primitive;
};

// Tolerance of the edge tests, per unit of distance and of edge length. The numerators of Moeller and Trumbore's test
// carry a rounding error of about 2^-24 of |origin - vertex| |edge|. Accepting hits by that much outside an edge closes
// the gap between neighboring triangles. A larger tolerance does harm: a grazing ray that passes just beside a ridge
// would hit the back of the triangle beyond the ridge. Measured in tests/render/closed.rs: no gap in 7 * 10^8 rays; 4
// of 10^7 rays hit such ridges, and 18 of 10^7 with a tolerance of 4e-7.
const float EDGE_SLACK = 1.0e-7;

// Intersects the three flat shapes (Moeller and Trumbore 1997). Returns whether the hit (t, uv) was replaced by a
// nearer one.
bool intersect_flat(Ray ray, vec4 texel0, vec4 texel1, vec3 edge_v, uint shape, inout float t, inout vec2 uv) {
    vec3 edge_u = texel1.xyz;
    vec3 p = cross(ray.direction, edge_v);
    float determinant = dot(edge_u, p);
    vec3 offset = ray.origin - texel0.xyz;
    vec3 q = cross(offset, edge_u);
    float inverse = 1.0 / determinant;
    float u = dot(offset, p) * inverse;
    float v = dot(ray.direction, q) * inverse;
    float distance = dot(edge_v, q) * inverse;
    float slack = EDGE_SLACK * texel1.w * (abs(offset.x) + abs(offset.y) + abs(offset.z)) * abs(inverse);
    float outside;
    if (shape == SHAPE_TRIANGLE) outside = max(-min(u, v), u + v - 1.0);
    else if (shape == SHAPE_PARALLELOGRAM) outside = max(abs(u), abs(v)) - 1.0;
    else outside = sqrt(u * u + v * v) - 1.0;
    // A zero determinant makes these values NaN or infinite, and then every comparison with them is false.
    bool closer = outside <= slack && distance > 0.0 && distance < t && slack < 1.0;
    if (closer) {
        t = distance;
        uv = vec2(u, v);
    }
    return closer;
}

// Intersects a sphere by the numerically stable form of Haines et al. 2019 ("Precision Improvements for Ray/Sphere
// Intersection"). Returns whether the hit (t, uv) was replaced by a nearer one.
bool intersect_sphere(Ray ray, vec3 center, float radius, inout float t, inout vec2 uv) {
    vec3 offset = ray.origin - center;
    float b = -dot(offset, ray.direction);
    vec3 perpendicular = offset + b * ray.direction;
    float discriminant = radius * radius - dot(perpendicular, perpendicular);
    float root = sqrt(max(discriminant, 0.0));
    float q = b + (b < 0.0 ? -root : root);
    float c = dot(offset, offset) - radius * radius;
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
