// Numbers in the records that are read as texels. The folder records declares the records.
#ifndef RECORDS_GLSL
#define RECORDS_GLSL

// Texels of a node of the compressed wide BVH (Ylitie et al. 2017).
const uint NODE_TEXELS = 5u;

// Maximum number of a material's links to textures. A link is parameter << LINK_PARAMETER_SHIFT | texture, or NONE.
const uint TEXTURE_LINKS = 8u;
// Position of the parameter number in a link to a texture: the texture multiplies that parameter.
const uint LINK_PARAMETER_SHIFT = 24u;

// Number of values that a program of textures holds at the same time.
const uint PROGRAM_REGISTERS = 16u;
// Maximum number of instructions of a program.
const uint MAX_PROGRAM_LENGTH = 256u;
// Positions in the first word of an instruction, from the lowest bit: the operation, the register that takes the result, the first
// of three operands, and the number of words that follow. An operand has PROGRAM_OPERAND_BITS bits.
const uint PROGRAM_OUTPUT_SHIFT = 8u;
const uint PROGRAM_OPERAND_SHIFT = 12u;
const uint PROGRAM_OPERAND_BITS = 5u;
const uint PROGRAM_LENGTH_SHIFT = 27u;
// Maximum number of octaves of a noise.
const uint MAX_OCTAVES = 32u;

// Maximum depth of nested blends and two-sided materials.
const uint MAX_CHOICES = 8u;
// Minimum roughness alpha of a microfacet surface.
const float MIN_ALPHA = 1.0e-4;
// Number of entries of a rough plastic's transmittance table.
const uint TRANSMITTANCE_ENTRIES = 64u;
// Number of roughnesses, and of cosines, in the table of the sheen's lobe, and of words of an entry.
const uint SHEEN_ENTRIES = 32u;
const uint SHEEN_WORDS = 2u;
// The tables of a measured BSDF begin with numbers of words: the azimuths of the viewer, its elevations, and the parts in which the azimuths
// were measured, or 0 where the surface may be turned. Then come a record for each of the grids, all azimuths, all elevations, and the grids.
const uint MEASURED_AZIMUTHS = 0u;
const uint MEASURED_ELEVATIONS = 1u;
const uint MEASURED_PARTS = 2u;
const uint MEASURED_HEAD_WORDS = 3u;
// Number of the grids of a measured BSDF, and which is which: colors of samples, from red to blue, the density of normals, the projected area,
// the brightness of samples, and the density of normals that the viewer sees. Both last ones have, after the numbers of a grid, the
// distributions of the columns of each row and the distribution of the rows.
const uint MEASURED_GRIDS = 7u;
const uint MEASURED_COLORS = 0u;
const uint MEASURED_NORMALS = 3u;
const uint MEASURED_AREA = 4u;
const uint MEASURED_BRIGHTNESS = 5u;
const uint MEASURED_VISIBLE_NORMALS = 6u;
// Words of the record of a grid: columns, rows, words between the grids of two directions of the viewer, and the place of the first.
const uint MEASURED_GRID_WORDS = 4u;

#endif
