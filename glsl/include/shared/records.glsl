// Numbers in the records that are read as texels. The folder records declares the records.
#ifndef RECORDS_GLSL
#define RECORDS_GLSL

// Texels of a node of the compressed wide BVH (Ylitie et al. 2017).
const uint NODE_TEXELS = 5u;

// Maximum number of a material's links to textures. A link is parameter << LINK_PARAMETER_SHIFT | texture, or NONE.
const uint TEXTURE_LINKS = 8u;
// Position of the parameter number in a link to a texture: the texture multiplies that parameter.
const uint LINK_PARAMETER_SHIFT = 24u;

// Maximum depth of nested blends and two-sided materials.
const uint MAX_CHOICES = 8u;
// Minimum roughness alpha of a microfacet surface.
const float MIN_ALPHA = 1.0e-4;
// Number of entries of a rough plastic's transmittance table.
const uint TRANSMITTANCE_ENTRIES = 64u;

#endif
