// Traversal by the device. Its ray queries (VK_KHR_ray_query) find candidates in an acceleration structure, and `intersect_primitive`
// decides. So a hit has the bits that the traversal in compute gives it, unless rounding decides which of two primitives is nearer.
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

// Hit of a ray by the structure; `refused` where the device found an opaque triangle that `intersect_primitive` does not hit. With
// `gl_RayFlagsNoOpaqueEXT` in `flags`, every triangle is a candidate, and none is refused.
Hit query_structure(Ray ray, uint flags, out bool refused) {
    Hit miss = Hit(ray.t_max, vec2(0.0), NONE);
    Hit hit = miss;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, bvh_structure, flags, 0xffu, ray.origin, 0.0, ray.direction, ray.t_max);
    while (rayQueryProceedEXT(query)) {
        uint primitive = primitive_of(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false),
                                      rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
        bool has_hit = rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
        Hit candidate = miss;
        if (has_hit) candidate.t = rayQueryGetIntersectionTEXT(query, true);
        if (intersect_primitive(ray, primitive, candidate)) {
            hit = candidate;
            if (rayQueryGetIntersectionTypeEXT(query, false) == gl_RayQueryCandidateIntersectionTriangleEXT) {
                rayQueryConfirmIntersectionEXT(query);
            } else {
                rayQueryGenerateIntersectionEXT(query, candidate.t);
            }
        }
    }
    refused = false;
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) return miss;
    uint primitive = primitive_of(rayQueryGetIntersectionInstanceCustomIndexEXT(query, true),
                                  rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
    if (primitive == hit.primitive) return hit;
    refused = !intersect_primitive(ray, primitive, miss);
    return miss;
}

// Nearest hit of `ray`; with `any_hit` the first hit that the device finds. A device ends its queries by itself, so `overrun` stays
// as it is.
Hit traverse(Ray ray, bool any_hit, inout bool overrun) {
    uint flags = any_hit ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT;
    bool refused;
    Hit hit = query_structure(ray, flags, refused);
    // The ray passes close beside the edge of a triangle.
    if (refused) hit = query_structure(ray, flags | gl_RayFlagsNoOpaqueEXT, refused);
    return hit;
}

#endif
