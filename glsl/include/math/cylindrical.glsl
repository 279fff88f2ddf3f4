// Lambert's cylindrical equal-area map between the square [-1, 1]^2 and the sphere. The coordinates of a direction are
// its azimuth over pi and its z.
#ifndef CYLINDRICAL_GLSL
#define CYLINDRICAL_GLSL
#include "math/equal_area.glsl"

// Unit direction for a point of the square.
vec3 cylinder_to_sphere(vec2 p) {
    vec2 sc = sin_cos_turn(0.5 * p.x);
    float planar = sqrt(max((1.0 - p.y) * (1.0 + p.y), 0.0));
    return vec3(planar * sc.y, planar * sc.x, p.y);
}

// Point of the square for a unit direction.
vec2 sphere_to_cylinder(vec3 w) {
    return vec2(2.0 * turns_of(w.xy), clamp(w.z, -1.0, 1.0));
}

// Point of the square for the opposite direction.
vec2 cylinder_antipode(vec2 p) {
    return vec2(p.x < 0.0 ? p.x + 1.0 : p.x - 1.0, -p.y);
}

#endif
