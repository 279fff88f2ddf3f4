// Directions: sines and cosines, orthonormal bases, and cosine-weighted sampling of the hemisphere.
#ifndef DIRECTION_GLSL
#define DIRECTION_GLSL
#include "math/constants.glsl"

// Sine and cosine of x in [-pi/4, pi/4] by their Taylor series. The error is at most 2e-7; a driver's own can be 1e-5.
vec2 sin_cos_quarter(float x) {
    float x2 = x * x;
    float s = x * (1.0 + x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 * (1.0 / 362880.0)))));
    float c = 1.0 + x2 * (-0.5 + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0))));
    return vec2(s, c);
}

// Sine and cosine of an angle in whole turns. The magnitude may be some thousands.
vec2 sin_cos_turn(float turns) {
    float quarters = floor(4.0 * turns + 0.5);
    vec2 sc = sin_cos_quarter((0.5 * PI) * (4.0 * turns - quarters));
    int quadrant = int(quarters) & 3;
    if ((quadrant & 1) != 0) sc = vec2(sc.y, -sc.x);
    return quadrant >= 2 ? -sc : sc;
}

// Matrix to world space from a local frame whose z-axis is the unit vector `n` (Duff et al. 2017).
mat3 basis_from_normal(vec3 n) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

// Area-preserving map from the unit square to the unit disk (Shirley and Chiu 1997).
vec2 concentric_disk(vec2 u) {
    vec2 p = 2.0 * u - 1.0;
    bool x_leads = abs(p.x) > abs(p.y);
    float radius = x_leads ? p.x : p.y;
    float other = x_leads ? p.y : p.x;
    vec2 sc = sin_cos_quarter(radius == 0.0 ? 0.0 : (0.25 * PI) * other / radius);
    return radius * (x_leads ? sc.yx : sc);
}

// Direction about +z with density cos / pi per steradian.
vec3 sample_cosine_hemisphere(vec2 u) {
    vec2 d = concentric_disk(u);
    return vec3(d, sqrt(max(1.0 - dot(d, d), 0.0)));
}

float pdf_cosine_hemisphere(float cos_theta) {
    return max(cos_theta, 0.0) * INV_PI;
}

// Density of a direction that is drawn from one distribution or, with the probability `share`, from a second. `mix` would not do: with
// a share of 1 a device may compute first + (second - first), which is 0 where the second is tiny beside the first.
float density_of_choice(float first, float second, float share) {
    return (1.0 - share) * first + share * second;
}

// Angle of a vector in turns, in [0, 1).
float turns(vec2 v) {
    float angle = v == vec2(0.0) ? 0.0 : atan(v.y, v.x) * INV_TWO_PI;
    return angle < 0.0 ? angle + 1.0 : angle;
}

#endif
