// Equal-area map between the square [-1, 1]^2 and the sphere (Shirley and Chiu 1997; Clarberg 2008). The diamond
// |x| + |y| <= 1 is the upper hemisphere. The four corners fold down to the lower hemisphere.
#ifndef EQUAL_AREA_GLSL
#define EQUAL_AREA_GLSL
#include "math/direction.glsl"

float sign_not_zero(float x) {
    return x < 0.0 ? -1.0 : 1.0;
}

// Unit direction for a point of the square.
vec3 square_to_sphere(vec2 p) {
    vec2 a = abs(p);
    float signed_distance = 1.0 - (a.x + a.y);
    float r = 1.0 - abs(signed_distance);
    // Azimuth within the quadrant, measured from the quadrant's middle, in [-pi/4, pi/4].
    vec2 sc = sin_cos_quarter(r == 0.0 ? 0.0 : (0.25 * PI) * (a.y - a.x) / r);
    float planar = r * sqrt(max(2.0 - r * r, 0.0));
    const float half_sqrt2 = 0.70710678118655;
    float x = planar * half_sqrt2 * (sc.y - sc.x);
    float y = planar * half_sqrt2 * (sc.y + sc.x);
    return vec3(sign_not_zero(p.x) * x, sign_not_zero(p.y) * y, sign_not_zero(signed_distance) * (1.0 - r * r));
}

// 2 / pi * atan(x) for x in [0, 1], within 2e-8 before rounding (Abramowitz and Stegun 1964, 4.4.49).
float quadrant_fraction(float x) {
    float x2 = x * x;
    float p = -0.0161657367 + x2 * 0.0028662257;
    p = 0.0429096138 + x2 * p;
    p = -0.0752896400 + x2 * p;
    p = 0.1065626393 + x2 * p;
    p = -0.1420889944 + x2 * p;
    p = 0.1999355085 + x2 * p;
    p = -0.3333314528 + x2 * p;
    return (2.0 / PI) * x * (1.0 + x2 * p);
}

// Angle from the x-axis to a point of the plane, in whole turns, in [-1/2, 1/2].
float turns_of(vec2 p) {
    vec2 a = abs(p);
    float high = max(a.x, a.y);
    float fraction = high == 0.0 ? 0.0 : quadrant_fraction(min(a.x, a.y) / high);
    float quarters = a.y > a.x ? 1.0 - fraction : fraction;
    if (p.x < 0.0) quarters = 2.0 - quarters;
    return p.y < 0.0 ? -0.25 * quarters : 0.25 * quarters;
}

// Point of the square for a unit direction.
vec2 sphere_to_square(vec3 w) {
    vec3 a = abs(w);
    // This is sqrt(1 - |z|) in a form without cancellation at the poles.
    float r = sqrt(dot(a.xy, a.xy) / (1.0 + a.z));
    float high = max(a.x, a.y);
    float fraction = high == 0.0 ? 0.0 : quadrant_fraction(min(a.x, a.y) / high);
    float v = r * (a.x < a.y ? 1.0 - fraction : fraction);
    vec2 p = vec2(r - v, v);
    if (w.z < 0.0) p = vec2(1.0 - p.y, 1.0 - p.x);
    return vec2(sign_not_zero(w.x) * p.x, sign_not_zero(w.y) * p.y);
}

// Point of the unit square that concentric_disk (direction.glsl) maps to a point of the unit disk.
vec2 disk_to_square(vec2 p) {
    vec2 a = abs(p);
    bool x_leads = a.x > a.y;
    float high = max(a.x, a.y);
    float fraction = high == 0.0 ? 0.0 : 2.0 * quadrant_fraction(min(a.x, a.y) / high);
    float radius = length(p);
    vec2 square = radius * (x_leads ? vec2(1.0, fraction) : vec2(fraction, 1.0));
    return 0.5 + 0.5 * vec2(sign_not_zero(p.x) * square.x, sign_not_zero(p.y) * square.y);
}

// Point of the square for the opposite direction. The function rearranges the square rigidly, so areas are preserved.
vec2 antipode(vec2 p) {
    vec2 a = abs(p);
    return vec2(-sign_not_zero(p.x) * (1.0 - a.y), -sign_not_zero(p.y) * (1.0 - a.x));
}

#endif
