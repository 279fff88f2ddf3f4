// Disks that face the point which they light, as Blender's lamps with soft falloff do. Such a disk is stored as a sphere of its radius,
// which holds it however it is turned.
//
// Light has come from the same disk however it was found. So a disk faces the place where a path was last scattered, not where its ray
// starts behind a surface that has let the path through.
#ifndef FACING_GLSL
#define FACING_GLSL
#include "math/direction.glsl"
#include "records/geometry.glsl"
#include "shared/variant.glsl"

// Point that the disks face now.
vec3 faced = vec3(0.0);
// Whether the ray under way comes straight from the camera.
bool is_camera_ray = false;

// Turns all facing disks to a point, for rays from there.
void turn_disks(vec3 to, bool from_camera) {
    if (HAS_FACING_DISKS) {
        faced = to;
        is_camera_ray = from_camera;
    }
}

bool is_facing(PrimitiveRecord p) {
    return HAS_FACING_DISKS && (p.flags & PRIMITIVE_FACING) != 0u;
}

// Whether the ray under way passes a facing disk.
bool is_passed(PrimitiveRecord p) {
    return is_camera_ray && (p.flags & PRIMITIVE_UNSEEN) != 0u;
}

// A facing disk, which lies in the world, as the flat disk that the rays under way meet. Its front is the side of the point that it faces.
PrimitiveRecord turned_disk(PrimitiveRecord p) {
    vec3 d = faced - p.origin;
    mat3 frame = basis_from_normal(d * inversesqrt(max(dot(d, d), 1.0e-37)));
    p.flags = SHAPE_DISK;
    p.edge_u = p.edge_tolerance * frame[0];
    p.edge_v = p.edge_tolerance * frame[1];
    p.plane = 0.0;
    return p;
}

#endif
