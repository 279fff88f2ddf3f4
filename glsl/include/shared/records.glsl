// Sizes of records that are read as texels, each of four words, and places in them.
#ifndef RECORDS_GLSL
#define RECORDS_GLSL

// Texels of a compressed wide BVH node (Ylitie et al. 2017).
const uint NODE_TEXELS = 5u;
// Texels of a primitive: origin and flags, edge_u and edge tolerance, edge_v.
const uint PRIMITIVE_TEXELS = 3u;
// Texels of a primitive's attributes: vertex normals, texture coordinates, material and emitter.
const uint ATTRIBUTE_TEXELS = 3u;
// Texels of a material. See bsdf/material.glsl.
const uint MATERIAL_TEXELS = 11u;
// Texels of a texture. See texture/textures.glsl.
const uint TEXTURE_TEXELS = 5u;

// First texel of a material's kind and flags, second material, texture and scale of a bump or normal map.
const uint MATERIAL_HEAD = 0u;
// First texel of a material's three colors.
const uint MATERIAL_COLORS = 1u;
// First texel of a material's twelve numbers.
const uint MATERIAL_SCALARS = 4u;
// First texel of a material's links to textures.
const uint MATERIAL_LINKS = 7u;
// First texel of a material's coating: optical thickness and eta; specular reflectance.
const uint MATERIAL_COATING = 9u;

// Links to textures that a material has: parameter << LINK_PARAMETER_SHIFT | texture, or NONE.
const uint TEXTURE_LINKS = 8u;
// The upper bits of a link to a texture say which parameter it multiplies.
const uint LINK_PARAMETER_SHIFT = 24u;

// First texel of a texture's kind, address of the first word, width and height.
const uint TEXTURE_HEAD = 0u;
// First texel of two rows of the map from the surface's coordinates; beside the first, the factor of halves.
const uint TEXTURE_TO_UV = 1u;
// First texel of the two colors of a checkerboard.
const uint TEXTURE_COLORS = 3u;

// Choices within choices of materials that are followed.
const uint MAX_CHOICES = 8u;
// Least roughness of a microfacet surface.
const float MIN_ALPHA = 1.0e-4;
// Numbers of a rough plastic's table of transmittances.
const uint TRANSMITTANCE_ENTRIES = 64u;

#endif
