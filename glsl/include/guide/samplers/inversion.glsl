// Parts that both samplers by inversion share.
#ifndef INVERSION_GLSL
#define INVERSION_GLSL
#include "guide/samplers/guide.glsl"

// Point of the map: uniform in the bin, or for the uniform share uniform on the hemisphere of n.
vec2 inverted_point(Guide guide, bool uniform_share, uint bin, vec2 u) {
    if (!uniform_share) return bin_point(bin, DIRECTION_RESOLUTION, u);
    vec2 p = 2.0 * u - 1.0;
    return dot(map_to_sphere(p), guide.n) < 0.0 ? map_antipode(p) : p;
}

#endif
