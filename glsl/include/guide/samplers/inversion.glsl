// What the samplers by inversion share: a bin that has been chosen, or the uniform share in its place.
#ifndef INVERSION_GLSL
#define INVERSION_GLSL
#include "guide/samplers/guide.glsl"

// A point of the map: uniform in the bin, or uniform on the hemisphere of n.
vec2 inverted_point(Guide guide, bool uniform_share, uint bin, vec2 u) {
    if (!uniform_share) return bin_point(bin, DIRECTION_RESOLUTION, u);
    vec2 p = 2.0 * u - 1.0;
    return dot(map_to_sphere(p), guide.n) < 0.0 ? map_antipode(p) : p;
}

#endif
