// Colors in linear sRGB.
#ifndef COLOR_GLSL
#define COLOR_GLSL

// With Mitsuba's digits.
float luminance(vec3 color) {
    return dot(color, vec3(0.212671, 0.715160, 0.072169));
}

#endif
