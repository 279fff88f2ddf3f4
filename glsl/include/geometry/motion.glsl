// Transforms that depend on time. Between two keys, the origin travels along a line, a rotation about an axis turns evenly, and the
// stretch before it grows evenly (Shoemake and Duff 1992), as in pbrt and Mitsuba. src/scene/motion.rs makes the segments.
#ifndef MOTION_GLSL
#define MOTION_GLSL
#include "geometry/bvh.glsl"
#include "math/direction.glsl"
#include "random/random.glsl"
#include "shared/variant.glsl"

// Whether a path has a time.
bool has_time() {
    if (HAS_DEFORMING) return true;
    return (MOTION_SEGMENTS | CAMERA_SEGMENTS) != 0u;
}

// Time of the path under way: 0 where the shutter opens, 1 where it closes. It is the same for all edges and shadow rays of the path.
float moment = 0.0;

// Sets the time to that of the path with this key.
void set_moment(RandomKey key) {
    if (has_time()) moment = unit_float(random_bits(key, 0u, RANDOM_TIME).x);
}

// Affine transform of a moment.
struct Pose {
    mat3 matrix;
    vec3 origin;
};

// Transform at the path's time by a motion of `count` segments, `most` at most. The products are exact to the last bit wherever they are
// computed, so that a ray meets the surface where its hit is placed.
Pose pose_at_moment(uint first, uint count, uint most) {
    uint at = first;
    for (uint i = 1u; i < most; ++i) {
        uint next = first + min(i, count - 1u) * MOTION_TEXELS;
        if (motion_start(next) <= moment) at = next;
    }
    MotionRecord m = load_motion(at);
    precise float s = (moment - m.start) * m.per_time;
    precise vec2 sc = sin_cos_turn(s * m.turns);
    precise mat3 stretch =
        mat3(m.stretch_x + s * m.growth_x, m.stretch_y + s * m.growth_y, m.stretch_z + s * m.growth_z);
    vec3 a = m.axis;
    precise vec3 b = (1.0 - sc.y) * a;
    precise mat3 turn = mat3(sc.y + b.x * a.x, b.x * a.y + sc.x * a.z, b.x * a.z - sc.x * a.y,
                             b.y * a.x - sc.x * a.z, sc.y + b.y * a.y, b.y * a.z + sc.x * a.x,
                             b.z * a.x + sc.x * a.y, b.z * a.y - sc.x * a.x, sc.y + b.z * a.z);
    precise mat3 matrix = turn * stretch;
    precise vec3 origin = m.origin + s * m.travel;
    return Pose(matrix, origin);
}

#endif
