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

// Sheen of microfibers over a surface.
struct Sheen {
    vec3 reflectance;  // factor of the light that the fibers reflect
    float roughness;   // from 0 to 1
    float table;       // address of the words of the lobe's table, a whole number
};

const Sheen NO_SHEEN = Sheen(vec3(0.0), 0.0, 0.0);

// Thin film over a surface that reflects.
struct Film {
    float thickness;  // in nanometers; 0 where there is no film
    float eta;        // index of refraction over that of the space above
};

const Film NO_FILM = Film(0.0, 1.0);

// Sheen as it is seen from one direction.
struct SheenLobe {
    vec3 albedo;        // share of light that the sheen reflects
    float kept;         // share of what lies below that is left
    float probability;  // of a sample of the sheen's own lobe
    vec2 toward;        // the direction along the surface, of length 1
    float stretch;      // the inverse transformation: factor of directions along the surface,
    float shift;        // and what it adds to them for a direction along the normal, toward the viewer
};

const SheenLobe NO_SHEEN_LOBE = SheenLobe(vec3(0.0), 1.0, 0.0, vec2(1.0, 0.0), 1.0, 0.0);

// Marks of the members of a kind's parameters: the color, the scalar or the flag of a Bsdf that holds a member. They mean nothing to
// the compiler. build/glsl/bsdfs.rs writes the function that makes the struct from a Bsdf, such as plastic_of.
#define COLOR(number)
#define SCALAR(number)
#define FLAG(flag)

// Parameters of a BSDF. Their meaning depends on the kind, whose file declares them. Scalar 3 is the opacity.
struct Bsdf {
    uint kind_and_flags;  // BSDF_* and MATERIAL_*
    vec3 color0;
    vec3 color1;
    vec3 color2;
    vec4 scalars0;
    vec4 scalars1;
    vec4 scalars2;
    Coating coating;      // valid for a material with MATERIAL_COATED
    Sheen sheen;          // valid for a material with MATERIAL_SHEEN
    SheenLobe sheen_lobe; // as the surface is seen
    Film film;
};

// Parameters of every kind with microfacets. The principled kinds have a roughness and a stretch in place of alpha.
struct Facets {
    SCALAR(0) float alpha_u;      // roughness along the tangent
    SCALAR(1) float alpha_v;      // roughness along the bitangent
    SCALAR(2) float eta;          // index of refraction, interior over exterior, of kinds whose facets transmit
    FLAG(MATERIAL_GGX) bool ggx;  // GGX facets; otherwise Beckmann's
};

// Roughness from which a BSDF of microfacets gets as many guided samples as a diffuse lobe. A smoother surface reflects less
// of what the guide draws.
const float GUIDED_ALPHA = 0.4;

// Factor of the guided part of a BSDF of microfacets. The authors' code guides all of them alike.
float guided_roughness(Facets facets) {
    return GUIDE_SET == GUIDE_SET_ALL ? min(max(facets.alpha_u, facets.alpha_v) / GUIDED_ALPHA, 1.0) : 1.0;
}

// Parameters of materials of any kind.
struct Mixture {
    SCALAR(0) float second_share;  // of a blend: probability of the second material
    SCALAR(3) float opacity;       // share of the incident light that meets the surface
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
