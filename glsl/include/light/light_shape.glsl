// Sampling of points on emitting primitives, and the density of the direction to such a point, per steradian.
#ifndef LIGHT_SHAPE_GLSL
#define LIGHT_SHAPE_GLSL
#include "math/direction.glsl"
#include "math/equal_area.glsl"
#include "shared/variant.glsl"

// Coordinates (u, v) of a point that is uniform in area on a flat shape.
vec2 sample_flat(uint shape, vec2 u) {
    if (shape == SHAPE_PARALLELOGRAM) return 2.0 * u - 1.0;
    if (shape == SHAPE_DISK) return concentric_disk(u);
    float root = sqrt(u.x);
    return vec2(1.0 - root, root * u.y);
}

// Inverse of sample_flat.
vec2 square_of_flat(uint shape, vec2 uv) {
    if (shape == SHAPE_PARALLELOGRAM) return 0.5 * uv + 0.5;
    if (shape == SHAPE_DISK) return disk_to_square(uv);
    float root = max(1.0 - uv.x, 0.0);
    return vec2(root * root, uv.y / max(root, 1.0e-20));
}

float flat_area(uint shape, vec3 edge_u, vec3 edge_v) {
    float factor = shape == SHAPE_PARALLELOGRAM ? 4.0 : (shape == SHAPE_DISK ? PI : 0.5);
    return factor * length(cross(edge_u, edge_v));
}

// Density, per steradian, of the direction to a point that is uniform on a surface of this area.
float pdf_area(vec3 from, vec3 position, vec3 normal, float area) {
    vec3 d = position - from;
    float squared = dot(d, d);
    float cosine = abs(dot(d, normal)) * inversesqrt(max(squared, 1.0e-37));
    return squared / max(area, 1.0e-37) / max(cosine, 1.0e-20);
}

// Whether a sphere is sampled by the cone that it fills. A point on or inside the sphere has no such cone.
bool sees_cone(vec3 from, vec3 center, float radius) {
    vec3 d = center - from;
    return dot(d, d) > 1.001 * radius * radius;
}

// 1 - cos of the cone's half angle, in a form without cancellation for a distant sphere.
float cone_height(float squared_sine) {
    return squared_sine / (1.0 + sqrt(max(1.0 - squared_sine, 0.0)));
}

// Unit vector from a sphere's center to a point of it. Seen from outside, the point is uniform in the solid angle of
// the sphere; seen from inside, uniform in area.
vec3 sample_sphere(vec3 from, vec3 center, float radius, vec2 u) {
    vec3 d = center - from;
    float squared = dot(d, d);
    if (!sees_cone(from, center, radius)) return square_to_sphere(2.0 * u - 1.0);
    float height = u.x * cone_height(radius * radius / squared);
    float squared_sine = height * (2.0 - height);
    vec2 sine_cosine = sin_cos_turn(u.y);
    mat3 frame = basis_from_normal(d * inversesqrt(squared));
    float cosine = 1.0 - height;
    // The distance is that of the near intersection. The maximum guards the root against rounding where the direction
    // lies on the cone.
    float root = sqrt(max(radius * radius - squared * squared_sine, 0.0));
    float distance = sqrt(squared) * cosine - root;
    // The point relative to the center, in a form that does not cancel for a small far sphere.
    vec3 outward = frame * vec3(distance * sqrt(squared_sine) * sine_cosine.yx,
                                -(sqrt(squared) * squared_sine + cosine * root));
    return normalize(outward / radius);
}

float pdf_sphere(vec3 from, vec3 position, vec3 center, float radius) {
    vec3 d = center - from;
    if (!sees_cone(from, center, radius)) {
        return pdf_area(from, position, (position - center) / radius, 4.0 * PI * radius * radius);
    }
    return INV_TWO_PI / cone_height(radius * radius / dot(d, d));
}

#endif
