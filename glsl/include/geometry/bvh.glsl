// Set 1, Bvh: nodes and primitives. Only this file and ray_query.glsl read the set. Two back ends have the same meaning:
// texel buffers, which are faster on devices that emulate loads one component at a time, and storage buffers, for
// scenes that exceed the limits of texel buffers.
#ifndef BVH_GLSL
#define BVH_GLSL
#include "generated/geometry.glsl"
#include "shared/records.glsl"
#include "shared/sets.glsl"

#ifdef TEXEL_READS
layout(set = BVH_SET, binding = 0) uniform usamplerBuffer bvh_nodes;
layout(set = BVH_SET, binding = 1) uniform usamplerBuffer bvh_primitives;
layout(set = BVH_SET, binding = 2) uniform usamplerBuffer bvh_attributes;

uvec4 fetch_node(uint node, uint texel) {
    return texelFetch(bvh_nodes, int(node * NODE_TEXELS + texel));
}

// Primitives are fetched as integers. Read as floats, the flags would be denormal numbers, which a texture unit may
// flush to 0.
uvec4 primitive_texel(uint primitive, uint texel) {
    return texelFetch(bvh_primitives, int(primitive * PRIMITIVE_TEXELS + texel));
}

uvec4 attribute_texel(uint primitive, uint texel) {
    return texelFetch(bvh_attributes, int(primitive * ATTRIBUTE_TEXELS + texel));
}

// Texel of the segment of a motion that begins at the texel `first` of the primitives' buffer.
uvec4 motion_texel(uint first, uint texel) {
    return texelFetch(bvh_primitives, int(first + texel));
}
#else
layout(scalar, set = BVH_SET, binding = 0) restrict readonly buffer BvhNodes { uvec4 bvh_nodes[]; };
layout(scalar, set = BVH_SET, binding = 1) restrict readonly buffer BvhPrimitives { uvec4 bvh_primitives[]; };
layout(scalar, set = BVH_SET, binding = 2) restrict readonly buffer BvhAttributes { uvec4 bvh_attributes[]; };

uvec4 fetch_node(uint node, uint texel) {
    return bvh_nodes[node * NODE_TEXELS + texel];
}

uvec4 primitive_texel(uint primitive, uint texel) {
    return bvh_primitives[primitive * PRIMITIVE_TEXELS + texel];
}

uvec4 attribute_texel(uint primitive, uint texel) {
    return bvh_attributes[primitive * ATTRIBUTE_TEXELS + texel];
}

uvec4 motion_texel(uint first, uint texel) {
    return bvh_primitives[first + texel];
}
#endif

// Instances lie among the primitives, in records of the same size.
uvec4 instance_texel(uint instance, uint texel) {
    return primitive_texel(instance, texel);
}

uvec4 moving_texel(uint instance, uint texel) {
    return primitive_texel(instance, texel);
}

uvec4 deforming_texel(uint primitive, uint texel) {
    return primitive_texel(primitive, texel);
}

// Texel of the key of a deforming triangle that begins at the texel `first` of the primitives' buffer.
uvec4 key_texel(uint first, uint texel) {
    return motion_texel(first, texel);
}

uvec4 placement_texel(uint instance, uint texel) {
    return attribute_texel(instance, texel);
}

#endif
