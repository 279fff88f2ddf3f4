// BSDF at a point of a surface: its kind and its parameters, with textures applied.
#ifndef BSDF_PARAMETERS_GLSL
#define BSDF_PARAMETERS_GLSL
#include "shared/variant.glsl"

// Smooth dielectric layer over a surface.
struct Coating {
    vec3 optical_thickness;  // absorption times thickness
    float eta;               // interior over exterior
    vec3 specular_reflectance;
};

const Coating NO_COATING = Coating(vec3(0.0), 1.0, vec3(0.0));

// Parameters of a BSDF. Their meaning depends on the kind:
//
// |           | diffuse, rough_diffuse | dielectrics            | conductors           | plastics              | principled, principled_thin | phong, ward           |
// | color0    | reflectance            | specular_reflectance   | specular_reflectance | diffuse_reflectance   | base_color                  | diffuse_reflectance   |
// | color1    |                        | specular_transmittance | eta                  | specular_reflectance  |                             | specular_reflectance  |
// | color2    |                        |                        | k                    |                       |                             |                       |
// | scalars0.x| alpha                  | alpha_u                | alpha_u              | alpha, alpha_u        | roughness                   | exponent; alpha_u     |
// | scalars0.y|                        | alpha_v                | alpha_v              | alpha, alpha_v        | anisotropic                 | alpha_v of ward       |
// | scalars0.z|                        | eta                    |                      | eta                   | eta                         |                       |
// | scalars0.w| opacity                | opacity                | opacity              | opacity               | opacity                     | opacity               |
// | scalars1.x|                        |                        |                      | internal reflectance  | metallic; thin: diff_trans / 2 | WARD_* of ward     |
// | scalars1.y|                        |                        |                      | specular sampling     | spec_trans                  | specular sampling     |
// | scalars1.z|                        |                        |                      | transmittance table   | spec_tint                   |                       |
// | scalars1.w|                        |                        |                      |                       | sheen                       |                       |
// | scalars2  |                        |                        |                      |                       | sheen_tint, flatness; not thin: clearcoat, clearcoat_gloss | |
//
// eta is interior over exterior. A conductor with eta = k = 0 reflects all light. "Internal reflectance" is the diffuse
// Fresnel reflectance from inside. "Specular sampling" is the share s / (s + d), where s and d are the mean albedos of
// the specular and the diffuse lobe. "Transmittance table" (rough_plastic) is the address of the table's words, a whole
// number.
struct Bsdf {
    uint kind_and_flags;  // BSDF_* and MATERIAL_*
    vec3 color0;
    vec3 color1;
    vec3 color2;
    vec4 scalars0;
    vec4 scalars1;
    vec4 scalars2;
    Coating coating;      // valid for a material with MATERIAL_COATED
};

uint bsdf_kind(Bsdf b) {
    return b.kind_and_flags & MATERIAL_KIND_MASK;
}

// Whether the BSDF is of this kind. Specialization makes this false where no material of the scene has the kind.
bool is_kind(Bsdf b, uint kind) {
    return has_kind(kind) && bsdf_kind(b) == kind;
}

bool bsdf_flag(Bsdf b, uint flag) {
    return (b.kind_and_flags & flag) != 0u;
}

// Lobe from which a sample was drawn.
const uint LOBE_NONE = 0u;     // no direction: the path ends
const uint LOBE_DIFFUSE = 1u;  // a guide may sample this lobe instead of the BSDF
const uint LOBE_GLOSSY = 2u;
const uint LOBE_DELTA = 3u;    // a single direction; includes light that passes a thin sheet or a hole

struct BsdfSample {
    vec3 wi;      // unit, local: on the normal's side for reflection, behind the surface for transmission
    uint lobe;
    vec3 weight;  // f cos / probability, for LOBE_DELTA only; other lobes have the weight eval_bsdf / pdf_bsdf
    float eta;    // refractive index on the side of `wi` over that on the side of `wo`; 1 for reflection
};

const BsdfSample NO_BSDF_SAMPLE = BsdfSample(vec3(0.0, 0.0, 1.0), LOBE_NONE, vec3(0.0), 1.0);

#endif
