// Makes the scatterer of a surface: chooses among the material's parts, looks up textures, sets up the local frame.
#ifndef SCATTERER_GLSL
#define SCATTERER_GLSL
#include "guide/grid/cells.glsl"
#include "path/guiding.glsl"
#include "bsdf/material.glsl"
#include "random/random.glsl"
#include "geometry/relief.glsl"
#include "geometry/surface.glsl"
#include "shared/records.glsl"
#include "texture/textures.glsl"

bool has_choices() {
    return has_kind(MATERIAL_BLEND) || has_kind(MATERIAL_SIDES);
}

// Point of a surface that is met from the direction `wo`, in world space.
TexturePoint texture_point(Surface surface, vec3 wo) {
    return TexturePoint(surface.uv, surface.position, surface.geometric_normal, surface.shading_normal, wo);
}

Bsdf textured_bsdf(uint material, Surface surface, vec3 wo) {
    Bsdf bsdf = untextured_bsdf(material);
    if (has_feature(FEATURE_TEXTURES)) apply_textures(bsdf, material, texture_point(surface, wo));
    return bsdf;
}

// Chooses the first of two with the probability `share`. `u` in [0, 1) is stretched to serve for the next choice.
bool choose_first(inout float u, float share) {
    bool first = u < share;
    u = first ? u / share : (u - share) / (1.0 - share);
    u = min(u, 1.0 - 1.0 / 16777216.0);
    return first;
}

// The material that scatters, of those that the surface's material chooses between: a blend chooses by chance, two sides by the side that
// is met.
uint chosen_material(Surface surface, vec3 wo, inout float u) {
    bool behind = dot(wo, surface.shading_normal) < 0.0;
    uint material = surface.material;
    bool more = true;
    for (uint i = 0u; i < MAX_CHOICES && more; ++i) {
        uint kind = material_kind_and_flags(material) & MATERIAL_KIND_MASK;
        bool first = !behind;
        if (has_kind(MATERIAL_BLEND)) {
            float second_share = clamp(mixture_of(textured_bsdf(material, surface, wo)).second_share, 0.0, 1.0);
            if (kind == MATERIAL_BLEND) first = choose_first(u, 1.0 - second_share);
        }
        more = kind == MATERIAL_BLEND || kind == MATERIAL_SIDES;
        material = more ? (first ? material_material0(material) : material_material1_or_relief(material)) : material;
    }
    return material;
}

// The frame that a bump or normal map tilts, relative to the frame `upright`, whose normal is on the front. The surface is met from
// the direction `wo` in that frame, which is `world_wo` in world space.
mat3 tilted_frame(Surface surface, mat3 upright, uint material, vec3 wo, vec3 world_wo) {
    uint flags = material_kind_and_flags(material);
    uint relief = material_material1_or_relief(material);
    vec3 n = vec3(0.0, 0.0, 1.0);
    if (has_feature(FEATURE_BUMP) && (flags & MATERIAL_BUMP) != 0u) {
        vec2 gradient = material_relief_scale(material) *
            height_gradient(relief, texture_point(surface, world_wo), surface.dp_du, surface.dp_dv);
        n = bump_normal(surface.dp_du * upright, surface.dp_dv * upright, gradient, surface.geometric_normal * upright);
    }
    if (has_feature(FEATURE_NORMAL_MAP) && (flags & MATERIAL_NORMAL_MAP) != 0u) {
        n = mapped_normal(sample_pattern(relief, surface.uv).rgb);
    }
    if (has_feature(FEATURE_RELIEF_RAISED) && (flags & MATERIAL_RELIEF_RAISED) != 0u && dot(n, n) > 0.0) {
        vec3 surface_normal = surface.geometric_normal * upright;
        n = raised_normal(normalize(n), dot(surface_normal, wo) < 0.0 ? -surface_normal : surface_normal, wo);
    }
    return relief_frame(n, wo);
}

// Mirrors the frame of a two-sided surface that is met from behind, so that the material scatters as on the front. The angle
// between the two normals stays, and so does the side of each on which a direction lies.
void mirror_behind(inout Scatterer scatterer) {
    if (scatterer.wo.z >= 0.0 || !bsdf_flag(scatterer.bsdf, MATERIAL_TWO_SIDED)) return;
    scatterer.frame[2] = -scatterer.frame[2];
    scatterer.wo.z = -scatterer.wo.z;
    scatterer.upright.xy = -scatterer.upright.xy;
}

// The scatterer of a surface whose material has no choices, or of the part that was chosen. The surface is met from the
// direction `wo`, in world space. It has a hole where `u` is not below its opacity.
Scatterer scatterer_of_part(Surface surface, vec3 wo, uint material, float u) {
    Scatterer scatterer;
    scatterer.bsdf = textured_bsdf(material, surface, wo);
    scatterer.passes = has_feature(FEATURE_OPACITY) && u >= mixture_of(scatterer.bsdf).opacity;
    scatterer.frame = shading_frame(surface);
    if (is_kind(scatterer.bsdf, BSDF_HAIR)) {
        scatterer.frame = fiber_frame(surface, bsdf_flag(scatterer.bsdf, MATERIAL_ALONG_U));
    }
    scatterer.upright = vec3(0.0, 0.0, 1.0);
    scatterer.cell = cell_at(surface.position);
    mat3 front = scatterer.frame;
    scatterer.wo = wo * scatterer.frame;
    bool relief_outside = has_feature(FEATURE_RELIEF_OUTSIDE) && bsdf_flag(scatterer.bsdf, MATERIAL_RELIEF_OUTSIDE);
    if (!relief_outside) mirror_behind(scatterer);
    if (has_relief() && !scatterer.passes) {
        mat3 tilted = tilted_frame(surface, front, material, scatterer.wo, wo);
        scatterer.frame = scatterer.frame * tilted;
        scatterer.wo = scatterer.wo * tilted;
        scatterer.upright = upright_in(tilted);
    }
    if (relief_outside) mirror_behind(scatterer);
    return scatterer;
}

// The scatterer of a surface that is met from the direction `wo`, in world space.
Scatterer scatterer_at(Surface surface, vec3 wo, RandomKey key, uint vertex) {
    uint material = surface.material;
    float u = 0.0;
    if (has_choices() || has_feature(FEATURE_OPACITY)) u = unit_floats(random_bits(key, vertex, RANDOM_MATERIAL)).x;
    if (has_choices()) material = chosen_material(surface, wo, u);
    Scatterer scatterer = scatterer_of_part(surface, wo, material, u);
    if (has_feature(FEATURE_SHEEN)) cover_by_sheen(scatterer.bsdf, scatterer.wo);
    return scatterer;
}

#endif
