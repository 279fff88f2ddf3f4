// A scattering function at a point of a surface: its kind and its parameters, textures looked up.
#ifndef BSDF_PARAMETERS_GLSL
#define BSDF_PARAMETERS_GLSL
#include "shared/variant.glsl"

// A smooth layer over the surface.
struct Coating {
    vec3 optical_thickness;  // absorption times thickness
    float eta;               // interior over exterior
    vec3 specular_reflectance;
};

const Coating NO_COATING = Coating(vec3(0.0), 1.0, vec3(0.0));

// What the numbers mean depends on the kind:
//
// |           | diffuse, rough_diffuse | dielectrics            | conductors           | plastics              | principled     |
// | color0    | reflectance            | specular_reflectance   | specular_reflectance | diffuse_reflectance   | base_color     |
// | color1    |                        | specular_transmittance | eta                  | specular_reflectance  |                |
// | color2    |                        |                        | k                    |                       |                |
// | scalars0.x| alpha                  | alpha_u                | alpha_u              | alpha                 | roughness      |
// | scalars0.y|                        | alpha_v                | alpha_v              | alpha                 | anisotropic    |
// | scalars0.z|                        | eta                    |                      | eta                   | eta            |
// | scalars0.w| opacity                | opacity                | opacity              | opacity               | opacity        |
// | scalars1.x|                        |                        |                      | internal reflectance  | metallic       |
// | scalars1.y|                        |                        |                      | specular sampling     | spec_trans     |
// | scalars1.z|                        |                        |                      | transmittance table   | spec_tint      |
// | scalars1.w|                        |                        |                      |                       | sheen          |
// | scalars2  |                        |                        |                      |                       | sheen_tint, flatness, clearcoat, clearcoat_gloss |
//
// eta is interior over exterior; a conductor with eta = k = 0 reflects everything. "Internal reflectance" is the diffuse
// Fresnel reflectance from inside, "specular sampling" the share s / (s + d) of the mean albedos of the specular and the
// diffuse lobe, "transmittance table" (rough_plastic) the address of its words, a whole number.
struct Bsdf {
    uint kind_and_flags;  // BSDF_* and MATERIAL_*
    vec3 color0;
    vec3 color1;
    vec3 color2;
    vec4 scalars0;
    vec4 scalars1;
    vec4 scalars2;
    Coating coating;      // of what is MATERIAL_COATED
};

uint bsdf_kind(Bsdf b) {
    return b.kind_and_flags & MATERIAL_KIND_MASK;
}

// Whether the scattering function is of this kind; known to be false where the scene has none of it.
bool is_kind(Bsdf b, uint kind) {
    return has_kind(kind) && bsdf_kind(b) == kind;
}

bool bsdf_flag(Bsdf b, uint flag) {
    return (b.kind_and_flags & flag) != 0u;
}

// The lobe that a sample was drawn from.
const uint LOBE_NONE = 0u;     // no direction: the path ends
const uint LOBE_DIFFUSE = 1u;  // the one that a guide may replace
const uint LOBE_GLOSSY = 2u;
const uint LOBE_DELTA = 3u;    // one direction only; light that passes a thin sheet or a hole included

struct BsdfSample {
    vec3 wi;      // unit, local: z along the normal on the side of `wo`, or beyond it where light is transmitted
    uint lobe;
    vec3 weight;  // of LOBE_DELTA: f cos / probability. Others are weighed by eval_bsdf / pdf_bsdf
    float eta;    // index of refraction on the side of `wi` over that on the side of `wo`; 1 where the path does not cross
};

const BsdfSample NO_BSDF_SAMPLE = BsdfSample(vec3(0.0, 0.0, 1.0), LOBE_NONE, vec3(0.0), 1.0);

#endif
