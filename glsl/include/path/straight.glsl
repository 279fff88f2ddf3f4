// Light that goes straight on through surfaces: through holes (`mask`, `null`) and through thin sheets of glass. A path passes
// such a surface by chance. A connection to a light is multiplied by the share that passes.
//
// Both are the same light, so that multiple importance sampling weights them against each other: a path that has gone straight
// on remembers the density of its direction at the last surface that has scattered it, and that surface's position and cell.
// Both count every surface that they cross as an edge.
//
// A smooth surface between two dielectrics bends light that it lets through. A connection sets out for its light in a straight line. Each
// such surface on its way refracts it, and it brings light if it meets its light all the same: behind a pane, whose sides are parallel, and
// often behind thin vessels. Behind lenses it would seldom do so, and is given up. A path that goes the same way meets the same light. Its
// weight needs the density with which emitter sampling draws the direction in which the path has set out, for the light that it has met.
#ifndef STRAIGHT_GLSL
#define STRAIGHT_GLSL
#include "geometry/surface.glsl"
#include "path/medium.glsl"
#include "path/scatterer.glsl"

// Whether some surface of the scene lets light go straight on.
bool lets_through() {
    return has_feature(FEATURE_OPACITY) || has_kind(BSDF_THIN_DIELECTRIC);
}

// Whether connections to lights go on through surfaces that refract them.
bool bends_light() {
    if (NEE) return has_feature(FEATURE_REFRACTED_CONNECTIONS);
    return false;
}

// Least cosine of the angle between the direction in which a connection has set out and its direction behind two refractions.
const float LEAST_COSINE = 0.98;

// Whether a connection is given up because it has strayed from its direction.
bool strays(uint refractions, vec3 direction, vec3 setting_out) {
    return refractions % 2u == 0u && dot(direction, setting_out) < LEAST_COSINE;
}

// Whether anything in the scene weakens light on its way without blocking it.
bool weakens_light() {
    return lets_through() || bends_light() || has_media();
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

// Whether light goes on behind a surface, straight or refracted, where a connection to a light meets it.
bool may_pass(uint material) {
    if (bends_light()) return has_flag(material, MATERIAL_LETS_THROUGH | MATERIAL_REFRACTS);
    return has_flag(material, MATERIAL_LETS_THROUGH);
}

// Whether a path that leaves a surface's scatterer in the direction `wi` is refracted as a connection to a light would be. `wi` is a
// sample of the scatterer.
bool is_refracted(Surface surface, Scatterer scatterer, vec3 wi) {
    if (!has_feature(FEATURE_REFRACTED_CONNECTIONS) || (has_media() && surface.material == NONE)) return false;
    return has_flag(surface.material, MATERIAL_REFRACTS) && dot(wi, scatterer.frame[2]) * scatterer.wo.z < 0.0;
}

// Ray that goes straight on behind a surface. No part of the way through a medium is left out.
Ray go_straight(Surface surface, vec3 direction) {
    bool skips = has_flag(surface.material, MATERIAL_HOLES);
    if (has_media()) skips = skips && !has_flag(surface.material, MATERIAL_BOUNDARY);
    return skips ? pass_surface(surface, direction) : leave_surface(surface, direction);
}

// Light that comes through a surface from behind.
struct Transmission {
    vec3 share;      // of the radiance from behind
    vec3 direction;  // where the light comes from, seen from the surface; world space
};

// Light that comes through a part of a surface and leaves it in the direction `wo`.
Transmission transmission_of_part(Surface surface, vec3 wo, uint material) {
    Scatterer scatterer = scatterer_of_part(surface, wo, material, -1.0);
    float opacity = has_feature(FEATURE_OPACITY) ? clamp(mixture_of(scatterer.bsdf).opacity, 0.0, 1.0) : 1.0;
    vec3 sheet = vec3(0.0);
    vec3 wi = -scatterer.wo;
    vec3 direction = -wo;
    if (is_kind(scatterer.bsdf, BSDF_THIN_DIELECTRIC) && !is_coated(scatterer.bsdf)) {
        sheet = straight_thin_dielectric(dielectric_of(scatterer.bsdf), scatterer.wo);
    }
    if (bends_light() && has_flag(material, MATERIAL_REFRACTS)) {
        BsdfSample behind = without_scaling(scatterer.bsdf, refracted(dielectric_of(scatterer.bsdf), scatterer.wo));
        sheet = behind.weight;
        wi = behind.wi;
        direction = scatterer.frame * wi;
    }
    if (has_relief()) sheet *= lit_share(scatterer, wi);
    return Transmission(vec3(1.0 - opacity) + opacity * sheet, direction);
}

// Part of a material, and the probability that a path meets it.
struct MaterialPart {
    uint material;
    float probability;
};

// Light that comes through a surface and leaves it in the direction `wo`: the mean over the material's parts, of which only whole
// materials refract. A material without parts takes one turn.
Transmission transmission_at(Surface surface, vec3 wo) {
    bool behind = dot(wo, surface.shading_normal) < 0.0;
    Transmission transmission = Transmission(vec3(0.0), -wo);
    MaterialPart parts[MAX_CHOICES + 1u];
    parts[0] = MaterialPart(surface.material, 1.0);
    uint count = 1u;
    uint left = has_choices() ? 1u << (MAX_CHOICES + 1u) : 1u;
    while (count > 0u && left > 0u) {
        --left;
        --count;
        MaterialPart part = parts[count];
        bool passes = true;
        uint kind = MATERIAL_KIND_MASK;
        if (has_choices()) {
            kind = material_kind_and_flags(part.material) & MATERIAL_KIND_MASK;
            passes = part.material == surface.material || has_flag(part.material, MATERIAL_LETS_THROUGH);
            passes = passes && part.probability > 0.0;
        }
        if (has_choices() && passes && kind == MATERIAL_BLEND && count < MAX_CHOICES) {
            float second_share = clamp(mixture_of(textured_bsdf(part.material, surface, wo)).second_share, 0.0, 1.0);
            parts[count] = MaterialPart(material_material0(part.material), part.probability * (1.0 - second_share));
            parts[count + 1u] = MaterialPart(material_material1_or_relief(part.material), part.probability * second_share);
            count += 2u;
        } else if (has_choices() && passes && kind == MATERIAL_SIDES) {
            uint side = behind ? material_material1_or_relief(part.material) : material_material0(part.material);
            parts[count] = MaterialPart(side, part.probability);
            ++count;
        } else if (passes) {
            Transmission of_part = transmission_of_part(surface, wo, part.material);
            transmission.share += part.probability * of_part.share;
            transmission.direction = of_part.direction;
        }
        if (count == 0u || left == 0u) break;
    }
    return transmission;
}

#endif
