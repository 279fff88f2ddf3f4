// Hue, saturation and value, or lightness, of colors. A hue is counted in turns.
#ifndef COLOR_MODELS_GLSL
#define COLOR_MODELS_GLSL

// Hue of a color whose largest component is `most`, in [0, 1).
float hue_of(vec3 color, float most, float span) {
    vec3 below = (vec3(most) - color) / span;
    float sixths = color.x == most ? below.z - below.y : (color.y == most ? 2.0 + below.x - below.z : 4.0 + below.y - below.x);
    float hue = sixths / 6.0;
    return hue < 0.0 ? hue + 1.0 : hue;
}

vec3 hsv_from_rgb(vec3 color) {
    float most = max(color.x, max(color.y, color.z));
    float span = most - min(color.x, min(color.y, color.z));
    float saturation = most != 0.0 ? span / most : 0.0;
    return vec3(saturation != 0.0 ? hue_of(color, most, span) : 0.0, saturation, most);
}

vec3 rgb_from_hsv(vec3 hsv) {
    float hue = hsv.x == 1.0 ? 0.0 : 6.0 * hsv.x;
    float sextant = floor(hue);
    float f = hue - sextant;
    float v = hsv.z;
    float low = v * (1.0 - hsv.y);
    float falling = v * (1.0 - hsv.y * f);
    float rising = v * (1.0 - hsv.y * (1.0 - f));
    if (hsv.y == 0.0) return vec3(v);
    if (sextant == 0.0) return vec3(v, rising, low);
    if (sextant == 1.0) return vec3(falling, v, low);
    if (sextant == 2.0) return vec3(low, v, rising);
    if (sextant == 3.0) return vec3(low, falling, v);
    if (sextant == 4.0) return vec3(rising, low, v);
    return vec3(v, low, falling);
}

vec3 hsl_from_rgb(vec3 color) {
    float most = max(color.x, max(color.y, color.z));
    float least = min(color.x, min(color.y, color.z));
    float lightness = min(1.0, 0.5 * (most + least));
    if (most == least) return vec3(0.0, 0.0, lightness);
    float span = most - least;
    float saturation = lightness > 0.5 ? span / (2.0 - most - least) : span / (most + least);
    return vec3(hue_of(color, most, span), saturation, lightness);
}

vec3 rgb_from_hsl(vec3 hsl) {
    float hue = 6.0 * hsl.x;
    vec3 shares = clamp(vec3(abs(hue - 3.0) - 1.0, 2.0 - abs(hue - 2.0), 2.0 - abs(hue - 4.0)), 0.0, 1.0);
    float chroma = (1.0 - abs(2.0 * hsl.z - 1.0)) * hsl.y;
    return (shares - 0.5) * chroma + hsl.z;
}

#endif
