// Traversal by the device. Its ray queries (VK_KHR_ray_query) find elements of an acceleration structure, and `intersect_primitive`
// decides whether and where the ray hits their primitives. The device alone decides which of two opaque triangles is nearer. So a hit has
// the bits that the traversal in compute gives it, unless the device's rounding decides which of two primitives is hit.
//
// src/encode/query_geometry.rs describes the structure. Its triangles are a little larger than those of the scene, so that rounding
// in the device leaves no gap between neighbors.
#ifndef RAY_QUERY_GLSL
#define RAY_QUERY_GLSL

layout(set = BVH_SET, binding = 3) uniform accelerationStructureEXT bvh_structure;
// Index of the first element of each part of the structure, then the primitive of each element.
layout(scalar, set = BVH_SET, binding = 4) restrict readonly buffer BvhElements { uint bvh_elements[]; };

uint primitive_of(int part, int element) {
    return bvh_elements[bvh_elements[part] + uint(element)];
}

// Largest number of candidates of a ray, as a multiple of the number of elements. A device may name an element more than once.
const uint MOST_CANDIDATES = 4u;

// Hit of a ray by the structure; `refused` where the device found an opaque triangle that `intersect_primitive` does not hit. With
// `gl_RayFlagsNoOpaqueEXT` in `flags`, every triangle is a candidate, and none is refused.
Hit query_structure(Ray ray, uint flags, out bool refused, inout bool overrun) {
    Hit miss = no_hit(ray.t_max);
    Hit hit = miss;
    uint left = MOST_CANDIDATES * uint(bvh_elements.length());
    rayQueryEXT query;
    rayQueryInitializeEXT(query, bvh_structure, flags, 0xffu, ray.origin, 0.0, ray.direction, ray.t_max);
    // The query steps at the loop's head only, for a step past its end is not allowed.
    while (left > 0u && rayQueryProceedEXT(query)) {
        --left;
        uint primitive = primitive_of(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false),
                                      rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
        bool has_hit = rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
        Hit candidate = miss;
        if (has_hit) candidate.t = rayQueryGetIntersectionTEXT(query, true);
        if (intersect_primitive(ray, ray, NONE, primitive, candidate)) {
            hit = candidate;
            if (rayQueryGetIntersectionTypeEXT(query, false) == gl_RayQueryCandidateIntersectionTriangleEXT) {
                rayQueryConfirmIntersectionEXT(query);
            } else {
                rayQueryGenerateIntersectionEXT(query, candidate.t);
            }
        }
    }
    overrun = overrun || left == 0u;
    refused = false;
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) return miss;
    uint primitive = primitive_of(rayQueryGetIntersectionInstanceCustomIndexEXT(query, true),
                                  rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
    if (primitive == hit.primitive) return hit;
    refused = !intersect_primitive(ray, ray, NONE, primitive, miss);
    return miss;
}

// Nearest hit of `ray`; with `any_hit` the first hit that the device finds. `overrun` is set where a ray has too many candidates. A
// ray with coordinates that are no finite numbers hits nothing, and no device is asked about it.
Hit traverse(Ray ray, bool any_hit, inout bool overrun) {
    if (!is_finite(ray.origin) || !is_finite(ray.direction)) return no_hit(ray.t_max);
    uint flags = any_hit ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT;
    bool refused;
    Hit hit = query_structure(ray, flags, refused, overrun);
    // The ray passes close beside the edge of a triangle.
    if (refused) hit = query_structure(ray, flags | gl_RayFlagsNoOpaqueEXT, refused, overrun);
    return hit;
}

#endif
