// Record of a volume: a grid of values through which a medium varies. src/encode/volumes.rs writes it. Volumes lie behind the materials, in
// the same buffer of texels.
#ifndef RECORDS_VOLUME_GLSL
#define RECORDS_VOLUME_GLSL

// Grid of values. In the space of the grid, the voxel i lies between i and i + 1 along each axis.
struct VolumeRecord {
    vec4 grid_x;    // first row of the affine matrix from the world to the space of the grid
    vec4 grid_y;    // second row
    vec4 grid_z;    // third row
    uvec3 size;     // number of voxels along each axis
    uint flags;     // VOLUME_* flags
    uvec3 blocks;   // number of blocks of voxels along each axis; each block has a majorant of the medium's extinction
    uint address;   // address of the first voxel's word: one word for a number, three for a color
    float side;     // voxels along each side of a block
    uint majorants; // address of the first majorant, of every color channel the largest, scale included
    uvec2 unused;   // fills the texel
};

#endif
