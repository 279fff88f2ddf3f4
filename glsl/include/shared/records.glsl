// Sizes of the records that are read as texels, and the positions of their fields. A texel is four words.
#ifndef RECORDS_GLSL
#define RECORDS_GLSL

// Texels of a node of the compressed wide BVH (Ylitie et al. 2017).
const uint NODE_TEXELS = 5u;
// Texels of a primitive. In order: origin and flags; edge_u and edge tolerance; edge_v.
const uint PRIMITIVE_TEXELS = 3u;
// Texels of a primitive's attributes. In order: vertex normals and material; texture coordinates; texture coordinates,
// emitter and light.
const uint ATTRIBUTE_TEXELS = 3u;
// Texels of a material's record. bsdf/material.glsl reads them.
const uint MATERIAL_TEXELS = 11u;
// Texels of a texture's record. texture/textures.glsl reads them.
const uint TEXTURE_TEXELS = 5u;

// Texel of a material's kind and flags, its first material, its second material or relief texture, and its relief
// scale.
const uint MATERIAL_HEAD = 0u;
// First texel of a material's three colors.
const uint MATERIAL_COLORS = 1u;
// First texel of a material's twelve scalars.
const uint MATERIAL_SCALARS = 4u;
// First texel of a material's links to textures.
const uint MATERIAL_LINKS = 7u;
// First texel of a material's coating. The first texel holds optical thickness and eta, the second the specular
// reflectance.
const uint MATERIAL_COATING = 9u;

// Maximum number of a material's links to textures. A link is parameter << LINK_PARAMETER_SHIFT | texture, or NONE.
const uint TEXTURE_LINKS = 8u;
// Position of the parameter number in a link to a texture: the texture multiplies that parameter.
const uint LINK_PARAMETER_SHIFT = 24u;

// Texel of a texture's flags, the address of its first word, its width and its height.
const uint TEXTURE_HEAD = 0u;
// First texel of the two rows of the affine map from the surface's coordinates. The fourth word of the first row is the
// factor of texels that are stored as halves.
const uint TEXTURE_TO_UV = 1u;
// First texel of the two colors of a checkerboard.
const uint TEXTURE_COLORS = 3u;

// Maximum depth of nested blends and two-sided materials.
const uint MAX_CHOICES = 8u;
// Minimum roughness alpha of a microfacet surface.
const float MIN_ALPHA = 1.0e-4;
// Number of entries of a rough plastic's transmittance table.
const uint TRANSMITTANCE_ENTRIES = 64u;

#endif
