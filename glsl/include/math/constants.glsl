#ifndef CONSTANTS_GLSL
// Numbers and small functions that every other file uses.
#define CONSTANTS_GLSL

const float PI = 3.14159265358979;
const float INV_PI = 0.318309886183791;
const float INV_TWO_PI = 0.159154943091895;
// Upper bound on the length of a ray. It is finite, so that no comparison depends on how a device treats infinities.
const float MAX_DISTANCE = 3.0e38;

float mean_rgb(vec3 c) {
    return (c.r + c.g + c.b) * (1.0 / 3.0);
}

// Relative luminance of linear sRGB, with Mitsuba's coefficients.
float luminance(vec3 c) {
    return dot(c, vec3(0.212671, 0.715160, 0.072169));
}

float max_component(vec3 v) {
    return max(v.x, max(v.y, v.z));
}

float max_abs(vec3 v) {
    return max_component(abs(v));
}

// Whether `x` is neither NaN nor infinite. The test is on bits, because a compiler may assume that floats are finite.
bool is_finite(float x) {
    return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u;
}

bool is_finite(vec3 v) {
    return is_finite(v.x) && is_finite(v.y) && is_finite(v.z);
}

#endif
