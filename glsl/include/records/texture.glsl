// Record of a texture. src/encode/textures writes it.
#ifndef RECORDS_TEXTURE_GLSL
#define RECORDS_TEXTURE_GLSL

// Image, pattern or program, and how a surface's coordinates lead to it.
struct TextureRecord {
    uint kind;       // TEXTURE_*
    uint address;    // address of the first word of the image or the program; the upper bits hold the page
    uvec2 size;      // width and height of the image, in texels; of a program the instructions, and 1 where it reads the position
    vec3 u_row;      // first row of the affine map from the surface's coordinates
    float scale;     // factor of texels that are stored as halves
    vec3 v_row;      // second row of the affine map
    uint unused;     // fills the texel
    vec4 colors[2];  // colors of a checkerboard; the fourth component is 1. Least and largest value of a program
};

#endif
