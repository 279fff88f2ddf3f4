// Instances: groups of primitives that are stored once, in a space of their own, and shown in several places of the world.
#ifndef INSTANCE_GLSL
#define INSTANCE_GLSL
#include "geometry/bvh.glsl"
#include "geometry/intersect.glsl"
#include "geometry/motion.glsl"

bool is_instance(uint primitive) {
    return (primitive_flags(primitive) & PRIMITIVE_INSTANCE) != 0u;
}

// Whether an instance, if it is one, shows its group in another place than the group's.
bool is_moved(uint instance) {
    if (HAS_INSTANCES) return instance != NONE && (instance_flags(instance) & PRIMITIVE_UNMOVED) == 0u;
    return false;
}

// Transform of an instance.
struct Placement {
    mat3 local;   // rows of the matrix that turns directions of the world into the group's space, as columns
    mat3 world;   // matrix that turns directions of the group's space into the world
    vec3 origin;  // of the group's space, in the world
    float scale;  // factor by which the axis of the group's space grows that grows most
};

const Placement NO_PLACEMENT = Placement(mat3(0.0), mat3(0.0), vec3(0.0), 0.0);

// Length of a matrix's longest column.
float largest_axis(mat3 m) {
    return sqrt(max(dot(m[0], m[0]), max(dot(m[1], m[1]), dot(m[2], m[2]))));
}

// Transform of an instance that moves, at the path's time. Rows of the inverse are cross products of the columns, over the determinant.
Placement moving_placement(uint instance) {
    Pose pose = pose_at_moment(moving_motion(instance), moving_segments(instance), MOTION_SEGMENTS);
    mat3 world = pose.matrix;
    precise mat3 rows = mat3(plane_normal(world[1], world[2]), plane_normal(world[2], world[0]), plane_normal(world[0], world[1]));
    precise float inverse_determinant = 1.0 / dot(world[0], rows[0]);
    precise mat3 local = rows * inverse_determinant;
    return Placement(local, world, pose.origin, largest_axis(world));
}

Placement placement_of(uint instance) {
    if (MOTION_SEGMENTS != 0u && (instance_flags(instance) & PRIMITIVE_MOVING) != 0u) return moving_placement(instance);
    InstanceRecord i = load_instance(instance);
    PlacementRecord p = load_placement(instance);
    mat3 local = mat3(i.local_x, i.local_y, i.local_z);
    mat3 world = mat3(p.world_x, p.world_y, p.world_z);
    return Placement(local, world, vec3(p.origin_x, p.origin_y, p.origin_z), largest_axis(world));
}

// Point of the world, in the group's space. The difference to the origin is taken first: it is small where the point is near, however far
// the instance is from the world's origin.
vec3 to_group(Placement placement, vec3 point) {
    return (point - placement.origin) * placement.local;
}

// Sums of the magnitudes that to_group adds up, for bounds of its rounding.
vec3 terms_of_group(Placement placement, vec3 point) {
    vec3 d = abs(point - placement.origin);
    return vec3(dot(abs(placement.local[0]), d), dot(abs(placement.local[1]), d), dot(abs(placement.local[2]), d));
}

// The ray in the space of an instance. Its direction is not normalized, so that distances along it stay those of the world.
Ray into_instance(Ray ray, uint instance) {
    Placement placement = placement_of(instance);
    return Ray(to_group(placement, ray.origin), ray.direction * placement.local, ray.t_max);
}

// The primitive in the world. Distances to its plane are measured from its own origin.
PrimitiveRecord primitive_in_world(PrimitiveRecord p, Placement placement) {
    p.origin = placement.origin + placement.world * p.origin;
    p.edge_u = placement.world * p.edge_u;
    p.edge_v = placement.world * p.edge_v;
    p.edge_tolerance *= placement.scale;
    p.flags &= ~PRIMITIVE_LARGE;
    p.plane = 0.0;
    return p;
}

#endif
