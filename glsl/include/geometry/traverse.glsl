// Nearest hit and any hit of a ray: by traversal of the compressed wide BVH (Ylitie, Karras and Laine 2017), or by the ray queries of
// the device.
#ifndef TRAVERSE_GLSL
#define TRAVERSE_GLSL
#include "geometry/bvh.glsl"
#include "geometry/deforming.glsl"
#include "geometry/facing.glsl"
#include "geometry/instance.glsl"
#include "geometry/intersect.glsl"
#include "geometry/normals.glsl"

// Whether a ray meets the front of a flat shape, to which the shading normal points.
bool meets_front(vec3 direction, uint primitive, PrimitiveRecord p, vec2 uv) {
    vec3 n = plane_normal(p.edge_u, p.edge_v);
    if ((p.flags & PRIMITIVE_FLIP_NORMAL) != 0u) n = -n;
    bool interpolates = HAS_VERTEX_NORMALS && (p.flags & PRIMITIVE_VERTEX_NORMALS) != 0u;
    if (interpolates && is_deforming(p.flags)) n = deformed_normal(primitive, uv, n, mat3(1.0));
    else if (interpolates) n = interpolated_normal(attribute_normals(primitive), uv, n);
    return dot(n, direction) < 0.0;
}

// Tests one primitive, which an instance shows or none. `ray` is in the primitive's space, and `world_ray` is the same in the world, where
// spheres are met. A hit nearer than `hit.t` replaces `hit`. Returns whether that happened.
bool intersect_primitive(Ray ray, Ray world_ray, uint instance, uint primitive, inout Hit hit) {
    PrimitiveRecord p = primitive_now(primitive);
    if (HAS_INSTANCES && instance != NONE) p.edge_tolerance *= length(ray.direction);
    uint shape = p.flags & PRIMITIVE_SHAPE_MASK;
    float t = hit.t;
    vec2 uv = hit.uv;
    bool closer;
    if (HAS_SPHERES && shape == SHAPE_SPHERE) {
        if (HAS_PLACED_SPHERES && is_moved(instance)) {
            PrimitiveRecord shown = primitive_in_world(load_primitive(primitive), placement_of(instance));
            p.origin = shown.origin;
            p.edge_tolerance = shown.edge_tolerance;
        }
        if (is_facing(p)) {
            closer = !is_passed(p) && intersect_flat(world_ray, turned_disk(p), SHAPE_DISK, t, uv);
        } else {
            closer = intersect_sphere(world_ray, p.origin, p.edge_tolerance, t, uv);
        }
    } else {
        closer = intersect_flat(ray, p, shape, t, uv);
    }
    if (HAS_FRONT_ONLY && (p.flags & PRIMITIVE_FRONT_ONLY) != 0u) {
        closer = closer && meets_front(ray.direction, primitive, p, uv);
    }
    if (closer) hit = Hit(t, uv, primitive, instance);
    return closer;
}

#ifdef RAY_QUERIES
#include "geometry/ray_query.glsl"
#else
// Ray in the form that the box test needs.
struct NodeRay {
    vec3 origin;
    vec3 inverse_direction;
    bvec3 negative;
    uint octant_inverse4;  // 7 - octant, in every byte; turns a child's slot into its front-to-back position
};

// Least magnitude of a direction's component before it is inverted. It prevents 0 * infinity in the slab test.
const float MIN_DIRECTION = 1.0e-20;
// Relative rounding error of the slab test's two terms. Boxes grow by this share, so that no box is missed.
const float BOX_SLACK = 2.4e-7;

NodeRay node_ray(Ray ray) {
    NodeRay r;
    r.origin = ray.origin;
    r.negative = lessThan(ray.direction, vec3(0.0));
    vec3 safe = max(abs(ray.direction), vec3(MIN_DIRECTION));
    r.inverse_direction = mix(1.0 / safe, -1.0 / safe, r.negative);
    uint octant = (r.negative.x ? 0u : 4u) | (r.negative.y ? 0u : 2u) | (r.negative.z ? 0u : 1u);
    r.octant_inverse4 = octant * 0x01010101u;
    return r;
}

// Maximum of two floats by their bits. The comparison is exact where both are >= 0; a negative float is less than any
// other.
float max_as_int(float a, float b) {
    return intBitsToFloat(max(floatBitsToInt(a), floatBitsToInt(b)));
}

float min_as_int(float a, float b) {
    return intBitsToFloat(min(floatBitsToInt(a), floatBitsToInt(b)));
}

float byte_to_float(uint word, int shift) {
    return float(int((word >> shift) & 0xffu));
}

// Bits of one child in the hit mask; 0 where the ray misses the child's box.
uint child_bits(int shift, uint near_x, uint near_y, uint near_z, uint far_x, uint far_y, uint far_z, vec3 scale,
                vec3 near_offset, vec3 far_offset, float t_max, uint bits4, uint index4) {
    float entry = max_as_int(max_as_int(byte_to_float(near_x, shift) * scale.x + near_offset.x,
                                        byte_to_float(near_y, shift) * scale.y + near_offset.y),
                             max_as_int(byte_to_float(near_z, shift) * scale.z + near_offset.z, 0.0));
    // A negative exit distance is less than every entry distance, so the order among negative numbers does not matter.
    float exit = min_as_int(min_as_int(byte_to_float(far_x, shift) * scale.x + far_offset.x,
                                       byte_to_float(far_y, shift) * scale.y + far_offset.y),
                            min_as_int(byte_to_float(far_z, shift) * scale.z + far_offset.z, t_max));
    uint bits = ((bits4 >> shift) & 0xffu) << ((index4 >> shift) & 0xffu);
    return entry <= exit ? bits : 0u;
}

// Hit mask of four children. Bits 31 to 24 are inner nodes in front-to-back order, bits 23 to 0 are primitives.
uint intersect_children4(uint meta4, uint low_x, uint high_x, uint low_y, uint high_y, uint low_z, uint high_z,
                         NodeRay ray, vec3 scale, vec3 near_offset, vec3 far_offset, float t_max) {
    // The low five bits of an inner child's meta byte hold 24 to 31: bits 3 and 4 are both set.
    uint inner4 = ((meta4 & (meta4 << 1u)) & 0x10101010u) >> 4u;
    uint index4 = (meta4 ^ (ray.octant_inverse4 & (inner4 * 0xffu))) & 0x1f1f1f1fu;
    uint bits4 = (meta4 >> 5u) & 0x07070707u;
    uint near_x = ray.negative.x ? high_x : low_x, far_x = ray.negative.x ? low_x : high_x;
    uint near_y = ray.negative.y ? high_y : low_y, far_y = ray.negative.y ? low_y : high_y;
    uint near_z = ray.negative.z ? high_z : low_z, far_z = ray.negative.z ? low_z : high_z;
    uint mask = 0u;
    for (int shift = 0; shift < 32; shift += 8) {
        mask |= child_bits(shift, near_x, near_y, near_z, far_x, far_y, far_z, scale, near_offset, far_offset, t_max,
                           bits4, index4);
    }
    return mask;
}

// Hit mask of a node's eight children. `child_base` and `primitive_base` are the indices of the first child and
// primitive.
uint intersect_node(uint node, NodeRay ray, float t_max, out uint child_base, out uint primitive_base, out uint inner_mask) {
    uvec4 header = fetch_node(node, 0u);
    uvec4 bases = fetch_node(node, 1u);
    uvec4 x = fetch_node(node, 2u);
    uvec4 y = fetch_node(node, 3u);
    uvec4 z = fetch_node(node, 4u);
    child_base = bases.x;
    primitive_base = bases.y;
    inner_mask = header.w >> 24u;
    // The biased exponents of the quantization grid, shifted into place, are floats.
    vec3 cell = uintBitsToFloat(uvec3(header.w & 0xffu, (header.w >> 8u) & 0xffu, (header.w >> 16u) & 0xffu) << 23u);
    vec3 scale = cell * ray.inverse_direction;
    vec3 offset = (uintBitsToFloat(header.xyz) - ray.origin) * ray.inverse_direction;
    vec3 slack = BOX_SLACK * (abs(offset) + 255.0 * abs(scale));
    return intersect_children4(bases.z, x.x, x.z, y.x, y.z, z.x, z.z, ray, scale, offset - slack, offset + slack, t_max) |
           intersect_children4(bases.w, x.y, x.w, y.y, y.w, z.y, z.w, ray, scale, offset - slack, offset + slack, t_max);
}

bool has_nodes(uint group_mask) {
    return group_mask > 0x00ffffffu;
}

// Number of nodes that a ray visits before their primitives are tested. All lanes of a subgroup wait for the one with the most
// primitives. The sums of two nodes differ less between lanes than the numbers of single nodes. `traverse` keeps two groups.
const uint NODES_AT_ONCE = 2u;

// Nearest hit of `ray`; with `any_hit` the first hit that the traversal finds. `overrun` is set where the driver ended
// the loop early or where the stack was too small.
//
// Instances are leaves of the hierarchy of the world. Those that the ray finds at a node wait until the node's primitives are tested.
// Then the ray goes down into each, in its space, through the hierarchy of its group, and comes back.
Hit traverse(Ray ray, bool any_hit, inout bool overrun) {
    Hit hit = no_hit(ray.t_max);
    NodeRay nodes = node_ray(ray);
    // The instance that the ray is in, the ray in its space, and the number of groups on the stack that belong to the world.
    uint instance = NONE;
    Ray local = ray;
    uint of_world = 0u;
    // Instances that wait: the primitives' base index and mask.
    uint waiting_base = 0u, waiting = 0u;
    // A group is a base index and a mask of its children that are still to be visited. The root is a group of its own.
    uint stack_base[STACK_SIZE];
    uint stack_mask[STACK_SIZE];
    uint stack_count = 0u;
    uint group_base = 0u;
    uint group_mask = 0x80000000u;
    // The condition stands at the loop's head because SwiftShader keeps per lane only what the heads of loops read. It also
    // stands at the end, because lavapipe leaves a loop only there: without it, the body runs once more for no lane. Both
    // hold for all loops whose lanes end at different times.
    while (has_nodes(group_mask) && !(any_hit && hit.primitive != NONE)) {
        // Primitives found at the first node, and those found later at the second one.
        uint primitives = 0u, later_primitives = 0u;
        uint primitive_base = 0u, later_base = 0u;
        uint nodes_left = HAS_INSTANCES && instance == NONE ? 1u : NODES_AT_ONCE;
        while (has_nodes(group_mask) && nodes_left > 0u) {
            --nodes_left;
            uint slot = uint(findMSB(group_mask));
            uint child =
                group_base + bitCount(group_mask & ~(0xffffffffu << ((slot - 24u) ^ (nodes.octant_inverse4 & 7u))));
            group_mask &= ~(1u << slot);
            if (has_nodes(group_mask)) {
                // The host sizes the stack by the depth of the tree. A group that finds no room is reported as an overrun.
                overrun = overrun || stack_count == STACK_SIZE;
                stack_count = min(stack_count, STACK_SIZE - 1u);
                stack_base[stack_count] = group_base;
                stack_mask[stack_count] = group_mask;
                ++stack_count;
            }
            uint found_base, inner_mask;
            uint mask = intersect_node(child, nodes, hit.t, group_base, found_base, inner_mask);
            group_mask = (mask & 0xff000000u) | inner_mask;
            uint found = mask & 0x00ffffffu;
            bool is_first = primitives == 0u;
            later_primitives = is_first ? later_primitives : found;
            later_base = is_first ? later_base : found_base;
            primitives = is_first ? found : primitives;
            primitive_base = is_first ? found_base : primitive_base;
            if (!has_nodes(group_mask) && stack_count > of_world) {
                --stack_count;
                group_base = stack_base[stack_count];
                group_mask = stack_mask[stack_count];
            }
            if (!has_nodes(group_mask) || nodes_left == 0u) break;
        }
        while (primitives != 0u) {
            uint bit = uint(findLSB(primitives));
            primitives &= primitives - 1u;
            if (HAS_INSTANCES && instance == NONE && is_instance(primitive_base + bit)) {
                waiting_base = primitive_base;
                waiting |= 1u << bit;
            } else if (intersect_primitive(local, ray, instance, primitive_base + bit, hit) && any_hit) {
                // A ray that asks for any hit needs no second one.
                primitives = later_primitives = 0u;
            }
            if (primitives == 0u) {
                primitives = later_primitives;
                primitive_base = later_base;
                later_primitives = 0u;
            }
            if (primitives == 0u) break;
        }
        overrun = overrun || primitives != 0u;
        if (HAS_INSTANCES && (instance == NONE ? waiting != 0u : !has_nodes(group_mask))) {
            if (instance == NONE && has_nodes(group_mask)) {
                overrun = overrun || stack_count == STACK_SIZE;
                stack_count = min(stack_count, STACK_SIZE - 1u);
                stack_base[stack_count] = group_base;
                stack_mask[stack_count] = group_mask;
                ++stack_count;
            }
            if (waiting != 0u) {
                instance = waiting_base + uint(findLSB(waiting));
                waiting &= waiting - 1u;
                local = into_instance(ray, instance);
                of_world = stack_count;
                group_base = instance_root(instance);
                group_mask = 0x80000000u;
            } else {
                instance = NONE;
                local = ray;
                of_world = 0u;
                group_mask = 0u;
                if (stack_count > 0u) {
                    --stack_count;
                    group_base = stack_base[stack_count];
                    group_mask = stack_mask[stack_count];
                }
            }
            nodes = node_ray(local);
        }
        if (!has_nodes(group_mask) || (any_hit && hit.primitive != NONE)) break;
    }
    overrun = overrun || (has_nodes(group_mask) && !(any_hit && hit.primitive != NONE));
    return hit;
}

#endif
#endif
