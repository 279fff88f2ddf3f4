// What a path meets at a surface: which of several materials, with its textures looked up, in its local frame.
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

Bsdf textured_bsdf(uint material, vec2 uv) {
    Bsdf b = untextured_bsdf(material);
    if (has_feature(FEATURE_TEXTURES)) apply_textures(b, material, uv);
    return b;
}

// The first of two with the probability `share`, else the second. `u` in [0, 1) serves for the next choice.
bool choose_first(inout float u, float share) {
    bool first = u < share;
    u = first ? u / share : (u - share) / (1.0 - share);
    u = min(u, 1.0 - 1.0 / 16777216.0);
    return first;
}

// The one that scatters of the materials that `material` chooses between: a blend by chance, two sides by where `wo` is.
uint chosen_material(uint material, bool behind, vec2 uv, inout float u) {
    bool more = true;
    for (uint i = 0u; i < MAX_CHOICES && more; ++i) {
        uvec4 head = fetch_material(material, MATERIAL_HEAD);
        uint kind = head.x & MATERIAL_KIND_MASK;
        bool first = !behind;
        if (has_kind(MATERIAL_BLEND)) {
            float second_share = clamp(textured_bsdf(material, uv).scalars0.x, 0.0, 1.0);
            if (kind == MATERIAL_BLEND) first = choose_first(u, 1.0 - second_share);
        }
        more = kind == MATERIAL_BLEND || kind == MATERIAL_SIDES;
        material = more ? (first ? head.y : head.z) : material;
    }
    return material;
}

// The tilted frame of a bump or normal map, in the frame `upright`, whose normal is on the front.
mat3 tilted_frame(Surface s, mat3 upright, uint material, vec3 wo) {
    uvec4 head = fetch_material(material, MATERIAL_HEAD);
    vec3 n = vec3(0.0, 0.0, 1.0);
    if (has_feature(FEATURE_BUMP) && (head.x & MATERIAL_BUMP) != 0u) {
        vec2 gradient = uintBitsToFloat(head.w) * texture_gradient(head.z, s.uv);
        n = bump_normal(s.dp_du * upright, s.dp_dv * upright, gradient, s.geometric_normal * upright);
    }
    if (has_feature(FEATURE_NORMAL_MAP) && (head.x & MATERIAL_NORMAL_MAP) != 0u) {
        n = mapped_normal(sample_texture(head.z, s.uv).rgb);
    }
    return relief_frame(n, wo);
}

// Mirrors the frame of a two-sided surface that is met from behind. Which of two normals a direction lies behind, and the
// angle between them, do not change.
void mirror_behind(inout Scatterer x) {
    if (x.wo.z >= 0.0 || !bsdf_flag(x.bsdf, MATERIAL_TWO_SIDED)) return;
    x.frame[2] = -x.frame[2];
    x.wo.z = -x.wo.z;
    x.upright.xy = -x.upright.xy;
}

// What the surface is as it is met from direction `wo`. Behind a two-sided surface the frame is mirrored; the material then
// scatters as on the front.
Scatterer scatterer_at(Surface s, vec3 wo, RandomKey key, uint vertex) {
    Scatterer x;
    uint material = s.material;
    float u = 0.0;
    if (has_choices() || has_feature(FEATURE_OPACITY)) u = unit_floats(random_bits(key, vertex, RANDOM_MATERIAL)).x;
    if (has_choices()) material = chosen_material(material, dot(wo, s.shading_normal) < 0.0, s.uv, u);
    x.bsdf = textured_bsdf(material, s.uv);
    x.passes = has_feature(FEATURE_OPACITY) && u >= x.bsdf.scalars0.w;
    x.frame = shading_frame(s);
    x.upright = vec3(0.0, 0.0, 1.0);
    mat3 front = x.frame;
    x.wo = wo * x.frame;
    bool relief_outside = has_feature(FEATURE_RELIEF_OUTSIDE) && bsdf_flag(x.bsdf, MATERIAL_RELIEF_OUTSIDE);
    if (!relief_outside) mirror_behind(x);
    if (has_relief() && !x.passes) {
        mat3 tilted = tilted_frame(s, front, material, x.wo);
        x.frame = x.frame * tilted;
        x.wo = x.wo * tilted;
        x.upright = upright_in(tilted);
    }
    if (relief_outside) mirror_behind(x);
    x.cell = cell_at(s.position);
    return x;
}

#endif
