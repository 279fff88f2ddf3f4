// Shading normals of triangles that have normals at their vertices.
#ifndef NORMALS_GLSL
#define NORMALS_GLSL
#include "math/octahedral.glsl"

// The normal that the vertices' normals give at a point of a triangle, or the geometric normal where they cancel.
// `normals` are those of the vertices, in octahedral encoding.
vec3 interpolated_normal(uvec3 normals, vec2 uv, vec3 geometric_normal) {
    vec3 n = (1.0 - uv.x - uv.y) * octahedral_decode(normals.x) + uv.x * octahedral_decode(normals.y) +
             uv.y * octahedral_decode(normals.z);
    float squared = dot(n, n);
    return squared > 1.0e-12 ? n * inversesqrt(squared) : geometric_normal;
}

// The interpolated normal where each vertex's normal is transformed by a matrix before.
vec3 interpolated_normal(uvec3 normals, vec2 uv, vec3 geometric_normal, mat3 transform) {
    vec3 n = (1.0 - uv.x - uv.y) * normalize(transform * octahedral_decode(normals.x)) +
             uv.x * normalize(transform * octahedral_decode(normals.y)) +
             uv.y * normalize(transform * octahedral_decode(normals.z));
    float squared = dot(n, n);
    return squared > 1.0e-12 ? n * inversesqrt(squared) : geometric_normal;
}

#endif
