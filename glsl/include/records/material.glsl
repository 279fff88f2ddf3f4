// Record of a material. src/encode/materials.rs writes it.
#ifndef RECORDS_MATERIAL_GLSL
#define RECORDS_MATERIAL_GLSL

// BSDF with its modifiers, or a choice between two materials. The files of the folder bsdf say what colors and scalars mean. The records
// of media follow those of all materials: a phase function, with the extinction as color 1 and the albedo as color 2, the volumes that
// multiply them, or NONE, as material0 and material1_or_relief, the emitted radiance as the coating's specular reflectance, and its volume
// as the word of media.
struct MaterialRecord {
    uint kind_and_flags;       // BSDF_* or MATERIAL_BLEND, MATERIAL_SIDES, and MATERIAL_* flags
    uint material0;            // first material of a blend or of two sides
    uint material1_or_relief;  // second material; otherwise the texture of a bump or normal map, or NONE
    float relief_scale;        // factor of a bump map's heights
    vec4 colors[3];            // colors; the fourth components of the first two are the thickness of a film and its index of refraction
    vec4 scalars[3];           // scalar parameters
    uvec4 links[2];            // links from parameters to textures: parameter << LINK_PARAMETER_SHIFT | texture, or NONE
    vec3 optical_thickness;    // optical thickness of the coating, or reflectance of the sheen
    float coating_eta;         // index of refraction of the coating, interior over exterior, or roughness of the sheen
    vec3 coating_specular;     // specular reflectance of the coating; its first number is the address of the sheen's table
    uint media;                // of a boundary: the medium inside, and above EXTERIOR_MEDIUM_SHIFT the medium outside
};

#endif
