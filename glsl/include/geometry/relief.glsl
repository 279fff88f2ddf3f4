// Bump maps and normal maps: shading frames that are tilted against the surface's frame, as in Mitsuba 3. Vectors are
// in the surface's local frame unless a comment says that they are in the tilted frame.
#ifndef RELIEF_GLSL
#define RELIEF_GLSL
#include "math/constants.glsl"

// Normal of a surface that is displaced by a height with the given gradient in u and v (Blinn 1978). The result is not
// normalized and points to the side of the geometric normal.
vec3 bump_normal(vec3 dp_du, vec3 dp_dv, vec2 gradient, vec3 geometric_normal) {
    vec3 n = cross(vec3(dp_du.xy, gradient.x), vec3(dp_dv.xy, gradient.y));
    return dot(n, geometric_normal) < 0.0 ? -n : n;
}

// Normal that a color of a normal map encodes, not normalized.
vec3 mapped_normal(vec3 color) {
    return 2.0 * color - 1.0;
}

// Tilted frame whose z-axis is the direction of the normal `n`. A normal that faces away from `wo` is rotated by half a
// turn about the surface's normal (Schuessler et al. 2017). The x-axis is the surface's x-axis, projected onto the
// tilted plane.
mat3 relief_frame(vec3 n, vec3 wo) {
    if (wo.z * dot(wo, n) <= 0.0) n.xy = -n.xy;
    float squared = dot(n, n);
    n = squared > 0.0 ? n * inversesqrt(squared) : vec3(0.0, 0.0, 1.0);
    vec3 tangent = vec3(1.0, 0.0, 0.0) - n * n.x;
    squared = dot(tangent, tangent);
    tangent = squared > 0.0 ? tangent * inversesqrt(squared) : vec3(0.0, 1.0, 0.0);
    return mat3(tangent, cross(n, tangent), n);
}

// Normal of the surface, in the tilted frame.
vec3 upright_in(mat3 frame) {
    return vec3(frame[0].z, frame[1].z, frame[2].z);
}

// The normal `n` of a facet where its mirror direction of `wo` leaves the surface. Otherwise the normal of the same plane, between `n` and
// the surface's normal, whose mirror direction just leaves it, as in Cycles. `surface_normal` is on the side of `wo`. All have length 1.
//
// In that plane the mirror direction of a normal at the angle a to the surface's has the height x sin(2 a) + z cos(2 a) over the surface,
// where `wo` is x along the surface and z above it.
vec3 raised_normal(vec3 n, vec3 surface_normal, vec3 wo) {
    float z = dot(wo, surface_normal);
    float least = min(0.9 * z, 0.01);
    vec3 along = n - dot(n, surface_normal) * surface_normal;
    float squared = dot(along, along);
    bool leaves = dot(2.0 * dot(n, wo) * n - wo, surface_normal) >= least || squared == 0.0;
    along *= inversesqrt(max(squared, 1.0e-37));
    float x = dot(wo, along);
    float angle = 0.5 * (atan(x, z) + acos(clamp(least * inversesqrt(max(x * x + z * z, 1.0e-20)), -1.0, 1.0)));
    return leaves ? n : cos(angle) * surface_normal + sin(angle) * along;
}

// Whether `wi` is above the surface in both frames, or below it in both. `wi` and `upright` are in the tilted frame.
bool is_on_one_side(vec3 upright, vec3 wi) {
    return dot(upright, wi) * wi.z > 0.0;
}

// Shadowing factor of the light from `wi`, in [0, 1] (Conty Estevez et al. 2019). The factor is 0 where `wi` is above
// the surface in only one of the two frames. It falls at grazing angles, so that the shadows of tilted facets end
// softly. `wi` and `upright` are in the tilted frame.
float relief_shadowing(vec3 upright, vec3 wi) {
    float cos_wi = dot(upright, wi);
    float tan2_tilt = 1.0 / max(upright.z * upright.z, 1.0e-20) - 1.0;
    float tan2_wi = 1.0 / max(cos_wi * cos_wi, 1.0e-20) - 1.0;
    float alpha2 = clamp(0.125 * tan2_tilt, 0.0, 1.0);
    return cos_wi * wi.z > 0.0 ? 2.0 / (1.0 + sqrt(1.0 + alpha2 * max(tan2_wi, 0.0))) : 0.0;
}

#endif
