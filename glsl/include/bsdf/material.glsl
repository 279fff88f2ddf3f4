// Reader of a material's record: the BSDF at a point of a surface.
#ifndef MATERIAL_GLSL
#define MATERIAL_GLSL
#include "bsdf/bsdf.glsl"
#include "film/frame.glsl"
#include "shared/records.glsl"

// Whether the scene has a material of one of these kinds. Parameters that no kind in the scene reads are not fetched.
bool any_kind(uint kinds) {
    return (MATERIAL_KINDS & kinds) != 0u;
}

Coating coating(uint material) {
    return Coating(material_optical_thickness(material), material_coating_eta(material), material_coating_specular(material));
}

// A sheen takes the place of the coating in the record.
Sheen sheen(uint material) {
    return Sheen(material_optical_thickness(material), material_coating_eta(material), material_coating_specular(material).x);
}

// BSDF with the constants of the record. Textures multiply them later.
Bsdf untextured_bsdf(uint material) {
    Bsdf b;
    b.kind_and_flags = material_kind_and_flags(material);
    b.color0 = material_colors(material, 0u).rgb;
    b.color1 = any_kind(KINDS_WITH_COLOR1) ? material_colors(material, 1u).rgb : vec3(0.0);
    b.color2 = any_kind(KINDS_WITH_COLOR2) ? material_colors(material, 2u).rgb : vec3(0.0);
    bool scalars0 = any_kind(KINDS_WITH_SCALARS0 | (1u << MATERIAL_BLEND)) || has_feature(FEATURE_OPACITY);
    b.scalars0 = scalars0 ? material_scalars(material, 0u) : vec4(1.0);
    b.scalars1 = any_kind(KINDS_WITH_SCALARS1) ? material_scalars(material, 1u) : vec4(0.0);
    b.scalars2 = any_kind(KINDS_WITH_SCALARS2) ? material_scalars(material, 2u) : vec4(0.0);
    b.coating = NO_COATING;
    if (has_feature(FEATURE_COATING)) b.coating = coating(material);
    b.sheen = NO_SHEEN;
    b.sheen_lobe = NO_SHEEN_LOBE;
    if (has_feature(FEATURE_SHEEN)) b.sheen = sheen(material);
    b.film = NO_FILM;
    if (has_feature(FEATURE_FILM)) b.film = Film(material_colors(material, 0u).w, material_colors(material, 1u).w);
    return b;
}

#endif
