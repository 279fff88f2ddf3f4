// Light that goes straight on through surfaces: through holes (`mask`, `null`) and through thin sheets of glass. A path passes
// such a surface by chance. A connection to a light is multiplied by the share that passes.
//
// Both are the same light, so that multiple importance sampling weights them against each other: a path that has gone straight
// on remembers the density of its direction at the last surface that has scattered it, and that surface's position and cell.
// Both count every surface that they cross as an edge.
#ifndef STRAIGHT_GLSL
#define STRAIGHT_GLSL
#include "geometry/surface.glsl"
#include "path/medium.glsl"
#include "path/scatterer.glsl"

// Whether some surface of the scene lets light go straight on.
bool lets_through() {
    return has_feature(FEATURE_OPACITY) || has_kind(BSDF_THIN_DIELECTRIC);
}

// Whether anything in the scene weakens light on its way without blocking it.
bool weakens_light() {
    return lets_through() || has_media();
}

bool has_flag(uint material, uint flag) {
    return (material_kind_and_flags(material) & flag) != 0u;
}

// Whether a path that leaves the scatterer in the direction `wi` goes straight on. `wi` is a sample of the scatterer.
bool goes_straight(Scatterer scatterer, vec3 wi) {
    if (!lets_through()) return false;
    bool crosses = dot(wi, scatterer.frame[2]) * scatterer.wo.z < 0.0;
    return scatterer.passes || (is_kind(scatterer.bsdf, BSDF_THIN_DIELECTRIC) && !is_coated(scatterer.bsdf) && crosses);
}

// Ray that goes straight on behind a surface. No part of the way through a medium is left out.
Ray go_straight(Surface surface, vec3 direction) {
    bool skips = has_flag(surface.material, MATERIAL_HOLES);
    if (has_media()) skips = skips && !has_flag(surface.material, MATERIAL_BOUNDARY);
    return skips ? pass_surface(surface, direction) : leave_surface(surface, direction);
}

// Share of the light from behind a part of a surface that goes straight on in the direction `wo`.
vec3 straight_share_of_part(Surface surface, vec3 wo, uint material) {
    Scatterer scatterer = scatterer_of_part(surface, wo, material, -1.0);
    float opacity = has_feature(FEATURE_OPACITY) ? clamp(mixture_of(scatterer.bsdf).opacity, 0.0, 1.0) : 1.0;
    vec3 sheet = vec3(0.0);
    if (is_kind(scatterer.bsdf, BSDF_THIN_DIELECTRIC) && !is_coated(scatterer.bsdf)) {
        sheet = straight_thin_dielectric(dielectric_of(scatterer.bsdf), scatterer.wo);
        if (has_relief()) sheet *= relief_shadowing(scatterer.upright, -scatterer.wo);
    }
    return vec3(1.0 - opacity) + opacity * sheet;
}

// Part of a material, and the probability that a path meets it.
struct MaterialPart {
    uint material;
    float probability;
};

// Share of the light from behind a surface that goes straight on in the direction `wo`: the mean over the material's parts.
vec3 straight_share(Surface surface, vec3 wo) {
    if (!has_choices()) return straight_share_of_part(surface, wo, surface.material);
    bool behind = dot(wo, surface.shading_normal) < 0.0;
    vec3 share = vec3(0.0);
    MaterialPart parts[MAX_CHOICES + 1u];
    parts[0] = MaterialPart(surface.material, 1.0);
    uint count = 1u;
    uint left = 1u << (MAX_CHOICES + 1u);
    while (count > 0u && left > 0u) {
        --left;
        --count;
        MaterialPart part = parts[count];
        uint kind = material_kind_and_flags(part.material) & MATERIAL_KIND_MASK;
        uint first = material_material0(part.material);
        uint second = material_material1_or_relief(part.material);
        bool passes = has_flag(part.material, MATERIAL_LETS_THROUGH) && part.probability > 0.0;
        if (passes && kind == MATERIAL_BLEND && count < MAX_CHOICES) {
            float second_share = clamp(mixture_of(textured_bsdf(part.material, surface, wo)).second_share, 0.0, 1.0);
            parts[count] = MaterialPart(first, part.probability * (1.0 - second_share));
            parts[count + 1u] = MaterialPart(second, part.probability * second_share);
            count += 2u;
        } else if (passes && kind == MATERIAL_SIDES) {
            parts[count] = MaterialPart(behind ? second : first, part.probability);
            ++count;
        } else if (passes) {
            share += part.probability * straight_share_of_part(surface, wo, part.material);
        }
        if (count == 0u || left == 0u) break;
    }
    return share;
}

#endif
