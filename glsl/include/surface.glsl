// What a ray found: position, normals, material and emitter of a hit.
#ifndef SURFACE_GLSL
#define SURFACE_GLSL
#include "bvh.glsl"
#include "intersect.glsl"
#include "octahedral.glsl"

// A hit's distance from what it must not fall behind: some 100 roundings of its coordinates and of its primitive's.
const float RAY_EPSILON = 1.0 / 131072.0;

struct Surface {
    vec3 position;
    float epsilon;        // how far a ray's origin leaves the surface, scene units
    vec3 geometric_normal;
    vec3 shading_normal;  // in the geometric one's half space or, interpolated, beyond it
    uint material;
    uint emitter;         // NONE where it does not emit
};

// A hit is drawn this far (in scene units) inside its primitive's edges, so that no rounding puts it beyond a wall that
// meets the primitive there.
vec2 inside_edges(vec2 uv, uint shape, vec3 edge_u, vec3 edge_v, float epsilon) {
    if (shape == SHAPE_TRIANGLE) {
        // Barycentric coordinates at that distance from each edge; scaled down where the triangle is too slender for it.
        vec3 edge_lengths = vec3(length(edge_v), length(edge_u), length(edge_u - edge_v));
        vec3 margin = edge_lengths * (epsilon / max(length(cross(edge_u, edge_v)), 1.0e-30));
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

Surface surface_at(Ray ray, Hit hit) {
    vec4 texel0 = fetch_primitive(hit.primitive, 0u);
    vec4 texel1 = fetch_primitive(hit.primitive, 1u);
    vec3 edge_u = texel1.xyz;
    vec3 edge_v = fetch_primitive(hit.primitive, 2u).xyz;
    uvec4 normals_and_material = fetch_attributes(hit.primitive, 0u);
    uint flags = floatBitsToUint(texel0.w);
    uint shape = flags & PRIMITIVE_SHAPE_MASK;

    Surface s;
    s.position = ray.origin + hit.t * ray.direction;
    s.epsilon = RAY_EPSILON * max(max_abs(s.position), texel1.w);
    if (HAS_SPHERES && shape == SHAPE_SPHERE) {
        s.geometric_normal = normalize(s.position - texel0.xyz);
        s.position = texel0.xyz + length(edge_u) * s.geometric_normal;
    } else {
        vec2 uv = inside_edges(hit.uv, shape, edge_u, edge_v, s.epsilon);
        s.geometric_normal = normalize(cross(edge_u, edge_v));
        s.position = texel0.xyz + uv.x * edge_u + uv.y * edge_v;
    }
    if ((flags & PRIMITIVE_FLIP_NORMAL) != 0u) s.geometric_normal = -s.geometric_normal;
    s.shading_normal = s.geometric_normal;
    if (HAS_VERTEX_NORMALS && (flags & PRIMITIVE_VERTEX_NORMALS) != 0u) {
        vec3 n = (1.0 - hit.uv.x - hit.uv.y) * octahedral_decode(normals_and_material.x) +
                 hit.uv.x * octahedral_decode(normals_and_material.y) + hit.uv.y * octahedral_decode(normals_and_material.z);
        float squared = dot(n, n);
        if (squared > 1.0e-12) s.shading_normal = n * inversesqrt(squared);
    }
    s.material = normals_and_material.w;
    s.emitter = fetch_attributes(hit.primitive, 2u).z;
    return s;
}

// A ray that leaves the surface in direction `wi`, from a point moved off it to the side that `wi` goes to.
Ray leave_surface(Surface s, vec3 wi) {
    vec3 off = dot(wi, s.geometric_normal) >= 0.0 ? s.geometric_normal : -s.geometric_normal;
    return Ray(s.position + s.epsilon * off, wi, MAX_DISTANCE);
}

#endif
