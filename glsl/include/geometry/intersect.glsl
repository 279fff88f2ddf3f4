// Ray against primitive and ray against box.
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
    vec2 uv;         // of the primitive's parameterization
    uint primitive;
};

// The edge tests' slack, per unit of distance and of edge length. Moeller and Trumbore's numerators carry an error of
// some 2^-24 of |origin - vertex| |edge|; accepting that much outside an edge closes the gap between neighbors. It must
// not be more: a grazing ray that passes just beside a ridge would find the back of the triangle beyond it. Measured in
// tests/render/closed.rs: no gap in 7 * 10^8 rays, such ridges hit by 4 of 10^7 (by 18 with a slack of 4e-7).
const float EDGE_SLACK = 1.0e-7;

// Moeller and Trumbore 1997, for the three flat shapes at once. Returns whether `hit` was improved.
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
    // A zero determinant makes these NaN or infinite, and every comparison with them fails.
    bool closer = outside <= slack && distance > 0.0 && distance < t && slack < 1.0;
    if (closer) {
        t = distance;
        uv = vec2(u, v);
    }
    return closer;
}

// A sphere, by the numerically stable form of Haines et al. 2019 ("Precision Improvements for Ray/Sphere Intersection").
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
