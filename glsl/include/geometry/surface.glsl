// Surface at a hit: position, normals, texture coordinates, material and emitter.
#ifndef SURFACE_GLSL
#define SURFACE_GLSL
#include "geometry/bvh.glsl"
#include "geometry/deforming.glsl"
#include "geometry/facing.glsl"
#include "math/direction.glsl"
#include "geometry/instance.glsl"
#include "geometry/intersect.glsl"
#include "geometry/normals.glsl"

// Half of a float's spacing: the largest relative error of one rounding.
const float ROUNDING = 1.0 / 16777216.0;

struct Surface {
    vec3 position;
    float epsilon;        // distance by which a ray's origin is moved off the surface, scene units
    float size;           // longest edge of the primitive, or radius of the sphere
    vec3 geometric_normal;
    vec3 shading_normal;  // usually in the half space of the geometric normal; interpolated normals can leave it
    uint material;
    uint emitter;         // NONE where it does not emit
    vec2 uv;              // texture coordinates; zero where nothing in the scene reads them
    vec3 dp_du;           // derivatives of the position by u and v, scene units; zero without FEATURE_TANGENTS
    vec3 dp_dv;
};

const Surface NO_SURFACE = Surface(vec3(0.0), 0.0, 0.0, vec3(0.0), vec3(0.0), NONE, NONE, vec2(0.0), vec3(0.0), vec3(0.0));

// Whether anything in the scene reads texture coordinates.
bool has_texture_coordinates() {
    return has_feature(FEATURE_TEXTURES | FEATURE_TEXTURED_EMITTERS | FEATURE_TANGENTS);
}

// Moves the coordinates of a hit inside its primitive's edges by the distance `epsilon` (scene units). A wall that
// meets the primitive at an edge then stays on the right side of the hit, however its position is rounded.
// `inverse_area` is one over the length of the edges' cross product.
vec2 inside_edges(vec2 uv, uint shape, vec3 edge_u, vec3 edge_v, float inverse_area, float epsilon) {
    if (shape == SHAPE_TRIANGLE) {
        // Margins are the barycentric coordinates at that distance from each edge. A slender triangle gets smaller
        // margins.
        vec3 edge_lengths = vec3(length(edge_v), length(edge_u), length(edge_u - edge_v));
        vec3 margin = edge_lengths * (epsilon * inverse_area);
        float room = 1.0 - (margin.x + margin.y + margin.z);
        if (room < 0.25) {
            margin = edge_lengths * (0.75 / max(edge_lengths.x + edge_lengths.y + edge_lengths.z, 1.0e-30));
            room = 0.25;
        }
        vec2 beyond = max(uv - margin.xy, vec2(0.0));
        return margin.xy + beyond * min(1.0, room / max(beyond.x + beyond.y, 1.0e-30));
    }
    vec2 margin = min(epsilon * inversesqrt(vec2(dot(edge_u, edge_u), dot(edge_v, edge_v))), vec2(0.25));
    if (shape == SHAPE_PARALLELOGRAM) return clamp(uv, margin - 1.0, 1.0 - margin);
    return uv * min(1.0, (1.0 - max(margin.x, margin.y)) * inversesqrt(dot(uv, uv)));
}

// Interpolates a triangle's texture coordinates. Where the coordinates are degenerate, any two tangents will do.
void parametrize_triangle(inout Surface s, vec2 barycentric, PrimitiveRecord p, AttributeRecord attributes) {
    vec2 du = attributes.uv1 - attributes.uv0;
    vec2 dv = attributes.uv2 - attributes.uv0;
    s.uv = attributes.uv0 + barycentric.x * du + barycentric.y * dv;
    if (!has_feature(FEATURE_TANGENTS)) return;
    float determinant = du.x * dv.y - du.y * dv.x;
    mat3 any = basis_from_normal(normalize(cross(p.edge_u, p.edge_v)));
    s.dp_du = determinant != 0.0 ? (dv.y * p.edge_u - du.y * p.edge_v) / determinant : any[0];
    s.dp_dv = determinant != 0.0 ? (du.x * p.edge_v - dv.x * p.edge_u) / determinant : any[1];
}

// Texture coordinates of a parallelogram: the unit square.
void parametrize_parallelogram(inout Surface s, vec2 at, vec3 edge_u, vec3 edge_v) {
    s.uv = 0.5 * at + 0.5;
    s.dp_du = 2.0 * edge_u;
    s.dp_dv = 2.0 * edge_v;
}

// Texture coordinates of a disk: the radius in [0, 1], and the angle in turns.
void parametrize_disk(inout Surface s, vec2 at, vec3 edge_u, vec3 edge_v) {
    float radius = length(at);
    vec2 outward = radius > 0.0 ? at / radius : vec2(1.0, 0.0);
    s.uv = vec2(radius, turns(at));
    s.dp_du = outward.x * edge_u + outward.y * edge_v;
    s.dp_dv = (2.0 * PI) * (at.x * edge_v - at.y * edge_u);
}

// Texture coordinates of a sphere: the azimuth in turns, and the angle from the z-axis in half turns. `outward` is the
// unit vector from the center. `handedness` gives the direction of the y-axis: a mirrored sphere shows its texture
// mirrored.
void parametrize_sphere(inout Surface s, vec3 outward, vec3 edge_u, vec3 edge_v, float handedness) {
    float radius = length(edge_u);
    mat3 axes = mat3(edge_u, cross(edge_v, edge_u) * (handedness / radius), edge_v);
    vec3 at = (outward * axes) / radius;
    float across = length(at.xy);
    vec2 azimuth = across > 0.0 ? at.xy / across : vec2(1.0, 0.0);
    s.uv = vec2(turns(at.xy), atan(across, at.z) * INV_PI);
    s.dp_du = (2.0 * PI) * (axes * vec3(-at.y, at.x, 0.0));
    s.dp_dv = PI * (axes * vec3(at.z * azimuth, -across));
}

// Matrix from the local frame to world space. The local z-axis is the shading normal. With FEATURE_TANGENTS the local
// x-axis runs along dp_du.
mat3 shading_frame(Surface s) {
    mat3 frame = basis_from_normal(s.shading_normal);
    if (!has_feature(FEATURE_TANGENTS)) return frame;
    vec3 tangent = s.dp_du - s.shading_normal * dot(s.shading_normal, s.dp_du);
    float squared = dot(tangent, tangent);
    if (squared > 1.0e-12 * dot(s.dp_du, s.dp_du)) {
        frame[0] = tangent * inversesqrt(squared);
        frame[1] = cross(s.shading_normal, frame[0]);
    }
    return frame;
}

// Matrix from the local frame of a fiber to world space, with FEATURE_TANGENTS. The local y-axis runs along the fiber, to where one texture
// coordinate grows. It is perpendicular to the direction in which the other grows, around the fiber.
mat3 fiber_frame(Surface s, bool along_u) {
    vec3 n = s.shading_normal;
    vec3 around = along_u ? s.dp_dv : s.dp_du;
    vec3 across = around - n * dot(n, around);
    float squared = dot(across, across);
    mat3 frame = basis_from_normal(n);
    if (squared > 1.0e-12 * dot(around, around)) {
        frame[0] = across * inversesqrt(squared);
        frame[1] = cross(n, frame[0]);
    }
    bool is_turned = dot(frame[1], along_u ? s.dp_du : s.dp_dv) < 0.0;
    return is_turned ? mat3(-frame[0], -frame[1], n) : frame;
}

// Bound of the distance between a point of a flat shape's plane, as it is rounded, and the plane as the next ray will
// meet it. `n` is the unit normal, `inverse_area` one over the length of the edges' cross product. The terms are the roundings of the
// point and of the ray's origin, those of the plane's equation at both, and those of the normal's components, which
// matter by the shape's extent. Each is zero where its factors are: a floor at the height 0 needs no distance at all.
float plane_error(vec3 point, vec3 n, float inverse_area, PrimitiveRecord p) {
    vec3 from_origin = abs(point);
    vec3 u = abs(p.edge_u), v = abs(p.edge_v);
    vec3 extent = u + v;
    bool large = (p.flags & PRIMITIVE_LARGE) != 0u;
    vec3 reach = large ? min(vec3(4.0 * max_component(from_origin)), extent) : extent;
    vec3 normal_error = u.yzx * v.zxy + u.zxy * v.yzx;
    float of_equation = dot(abs(n), 4.0 * from_origin + 20.0 * (large ? from_origin : extent));
    return ROUNDING * (of_equation + 4.0 * inverse_area * dot(normal_error, reach));
}

// Unit normal of a flat shape, and one over the area that its edges span.
vec3 unit_plane_normal(vec3 edge_u, vec3 edge_v, out float inverse_area) {
    vec3 n = plane_normal(edge_u, edge_v);
    // Two steps, because squares of small or large edges leave a float's range.
    float scale = 1.0 / max(max_abs(n), 1.0e-37);
    n *= scale;
    float inverse_length = inversesqrt(dot(n, n));
    inverse_area = scale * inverse_length;
    return n * inverse_length;
}

// Position of a hit on a flat shape, and the distance by which rays start off it. The position has two forms: along the
// ray, and by the coordinates in the shape, clamped inside the shape's edges. The second suits each component unless the
// shape is far larger than the component. The result is then moved into the plane.
void place_on_plane(inout Surface s, Ray ray, Hit hit, uint shape, PrimitiveRecord p) {
    float inverse_area;
    vec3 n = unit_plane_normal(p.edge_u, p.edge_v, inverse_area);
    s.geometric_normal = n;

    vec3 along_ray = ray.origin + hit.t * ray.direction;
    float t_error = 8.0 * dot(abs(n), abs(from_anchor(ray.origin, p))) / max(abs(dot(n, ray.direction)), 1.0e-6);
    vec3 error_along_ray = 16.0 * (abs(ray.origin) + (hit.t + t_error) * abs(ray.direction));
    vec3 error_in_shape = abs(p.origin) + abs(hit.uv.x * p.edge_u) + abs(hit.uv.y * p.edge_v);
    s.epsilon = plane_error(along_ray, n, inverse_area, p);
    float margin = s.epsilon + 32.0 * ROUNDING * max_component(min(error_in_shape, error_along_ray));
    vec2 uv = inside_edges(hit.uv, shape, p.edge_u, p.edge_v, inverse_area, margin);
    vec3 in_shape = p.origin + uv.x * p.edge_u + uv.y * p.edge_v;
    s.position = mix(in_shape, along_ray, lessThan(error_along_ray, error_in_shape));
    s.position -= (dot(n, from_anchor(s.position, p)) - p.plane * inverse_area) * n;
}

// Position of a hit on a flat shape that an instance shows, and the distance by which rays start off it. `p` is the primitive in its group's
// space, and `shown` the same in the world. The two forms of the position are those of place_on_plane. The result is moved
// into the plane as rays through the instance meet it, in the group's space. So the roundings of the two matrices, and of
// one against the other, do not lift it off. What remains is the rounding of a point that goes into the group's space.
void place_in_instance(
    inout Surface s, Ray ray, Hit hit, uint shape, PrimitiveRecord p, PrimitiveRecord shown, Placement placement) {
    float inverse_area;
    vec3 n = unit_plane_normal(p.edge_u, p.edge_v, inverse_area);
    // The inverse transpose turns the normal. Distances to the plane grow by one over the length of its result.
    vec3 turned = placement.local * n;
    float growth = inversesqrt(dot(turned, turned));
    s.geometric_normal = growth * turned;

    vec3 along_ray = ray.origin + hit.t * ray.direction;
    vec3 terms = terms_of_group(placement, ray.origin) + abs(p.origin);
    float t_error = 8.0 * growth * dot(abs(n), terms) / max(abs(dot(s.geometric_normal, ray.direction)), 1.0e-6);
    vec3 error_along_ray = 16.0 * (abs(ray.origin) + (hit.t + t_error) * abs(ray.direction));
    vec3 coordinates = abs(p.origin) + abs(hit.uv.x * p.edge_u) + abs(hit.uv.y * p.edge_v);
    vec3 error_in_shape = abs(placement.origin) + abs(placement.world[0]) * coordinates.x +
                          abs(placement.world[1]) * coordinates.y + abs(placement.world[2]) * coordinates.z;
    s.epsilon = ROUNDING * (4.0 * dot(abs(s.geometric_normal), abs(along_ray)) +
                            10.0 * growth * dot(abs(n), terms_of_group(placement, along_ray))) +
                growth * plane_error(to_group(placement, along_ray), n, inverse_area, p);
    float margin = s.epsilon + 32.0 * ROUNDING * max_component(min(error_in_shape, error_along_ray));
    float area = length(cross(shown.edge_u, shown.edge_v));
    vec2 uv = inside_edges(hit.uv, shape, shown.edge_u, shown.edge_v, 1.0 / max(area, 1.0e-37), margin);
    vec3 in_shape = placement.origin + placement.world * (p.origin + uv.x * p.edge_u + uv.y * p.edge_v);
    s.position = mix(in_shape, along_ray, lessThan(error_along_ray, error_in_shape));
    float off = dot(n, from_anchor(to_group(placement, s.position), p)) - p.plane * inverse_area;
    s.position -= (off * growth) * s.geometric_normal;
}

// Position of a hit on a sphere, moved onto it, and the distance by which rays start off it: two roundings of the
// coordinates, and what sphere_excess errs by.
void place_on_sphere(inout Surface s, Ray ray, Hit hit, vec3 center, float radius) {
    vec3 point = ray.origin + hit.t * ray.direction;
    vec3 outward = point - center;
    float from_center = length(outward);
    s.geometric_normal = outward / max(from_center, 1.0e-37);
    s.position = point - sphere_excess(point, center, radius) / max(from_center + radius, 1.0e-37) * s.geometric_normal;
    s.epsilon = 6.0 * ROUNDING * dot(abs(s.geometric_normal), abs(s.position)) + 1.0e-12 * radius;
}

Surface surface_at(Ray ray, Hit hit) {
    PrimitiveRecord p = primitive_now(hit.primitive);
    AttributeRecord attributes = load_attribute(hit.primitive);
    uint shape = p.flags & PRIMITIVE_SHAPE_MASK;

    Placement placement = NO_PLACEMENT;
    PrimitiveRecord in_group = p;
    bool moved = is_moved(hit.instance);
    if (moved) {
        placement = placement_of(hit.instance);
        p = primitive_in_world(in_group, placement);
    }
    bool facing = is_facing(p);
    if (facing) {
        p = turned_disk(p);
        shape = SHAPE_DISK;
    }

    Surface s = NO_SURFACE;
    s.size = p.edge_tolerance;
    if (HAS_SPHERES && shape == SHAPE_SPHERE) {
        place_on_sphere(s, ray, hit, p.origin, p.edge_tolerance);
        // The center and the radius are rounded products.
        if (HAS_PLACED_SPHERES && moved) s.epsilon += 16.0 * ROUNDING * (dot(vec3(1.0), abs(p.origin)) + p.edge_tolerance);
        if (has_texture_coordinates()) parametrize_sphere(s, s.geometric_normal, p.edge_u, p.edge_v, attributes.uv0.x);
    } else {
        if (moved && !facing) {
            place_in_instance(s, ray, hit, shape, in_group, p, placement);
        } else {
            place_on_plane(s, ray, hit, shape, p);
        }
        if (HAS_FACING_DISKS && facing && moved) {
            s.epsilon += 16.0 * ROUNDING * (dot(vec3(1.0), abs(p.origin)) + p.edge_tolerance);
        }
        if (has_texture_coordinates()) {
            if (shape == SHAPE_TRIANGLE) parametrize_triangle(s, hit.uv, p, attributes);
            if (shape == SHAPE_PARALLELOGRAM) parametrize_parallelogram(s, hit.uv, p.edge_u, p.edge_v);
            if (shape == SHAPE_DISK) parametrize_disk(s, hit.uv, p.edge_u, p.edge_v);
        }
    }
    if ((p.flags & PRIMITIVE_FLIP_NORMAL) != 0u) s.geometric_normal = -s.geometric_normal;
    s.shading_normal = s.geometric_normal;
    if (HAS_VERTEX_NORMALS && (p.flags & PRIMITIVE_VERTEX_NORMALS) != 0u) {
        s.shading_normal = moved
            ? interpolated_normal(attributes.normals, hit.uv, s.geometric_normal, placement.local)
            : interpolated_normal(attributes.normals, hit.uv, s.geometric_normal);
        if (is_deforming(p.flags)) {
            mat3 transform = moved ? placement.local : mat3(1.0);
            s.shading_normal = deformed_normal(hit.primitive, hit.uv, s.geometric_normal, transform);
        }
    }
    s.material = attributes.material;
    s.emitter = attributes.emitter;
    return s;
}

// Ray that leaves the surface in direction `wi`. Its origin is moved off the surface to the side of `wi`.
Ray leave_surface(Surface s, vec3 wi) {
    vec3 off = dot(wi, s.geometric_normal) >= 0.0 ? s.geometric_normal : -s.geometric_normal;
    return Ray(s.position + s.epsilon * off, wi, MAX_DISTANCE);
}

// Ray that continues straight on through a hole of a surface. Its origin is moved behind the surface by Mitsuba 3's
// RayEpsilon times one more than the largest coordinate, but by a hundredth of the primitive at most. Blinds and leaves
// are often modeled as two layers a tiny distance apart; the ray passes both layers at once, as in Mitsuba 3.
Ray pass_surface(Surface s, vec3 wi) {
    s.epsilon = max(s.epsilon, min(8.94e-5 * (1.0 + max_abs(s.position)), 0.01 * s.size));
    return leave_surface(s, wi);
}

#endif
