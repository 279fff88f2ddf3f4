// Sheen of microfibers over any surface (Zeltner, Burley and Chiang 2022). Its lobe is a cosine lobe under a linear transformation, which
// depends on the direction of `wo` and on the roughness (Heitz et al. 2016). The layer dims what lies below it by its own albedo, as in
// Cycles. It is not reciprocal, because both follow `wo` alone. It covers the front of a surface.
#ifndef SHEEN_GLSL
#define SHEEN_GLSL
#include "bsdf/diffuse.glsl"
#include "film/frame.glsl"
#include "math/direction.glsl"
#include "shared/records.glsl"

// Largest probability of the sheen's own lobe: a guide has its share also where nothing lies below.
const float MOST_SHEEN = 0.75;

// Entry of the table: the stretch, the shift with the other sign, and the albedo of a white sheen.
vec3 sheen_entry(uint address) {
    return vec3(unpackUnorm2x16(table_word(address)), unpackUnorm2x16(table_word(address + 1u)).x);
}

// Interpolates the table, whose rows are roughnesses and whose columns are cosines of `wo`.
vec3 sheen_numbers(Sheen s, float cos_theta) {
    vec2 position = clamp(vec2(cos_theta, s.roughness), 0.0, 1.0) * float(SHEEN_ENTRIES - 1u);
    uvec2 entry = min(uvec2(position), uvec2(SHEEN_ENTRIES - 2u));
    vec2 share = position - vec2(entry);
    uint first = uint(s.table) + SHEEN_WORDS * (entry.y * SHEEN_ENTRIES + entry.x);
    uint second = first + SHEEN_WORDS * SHEEN_ENTRIES;
    vec3 low = mix(sheen_entry(first), sheen_entry(first + SHEEN_WORDS), share.x);
    vec3 high = mix(sheen_entry(second), sheen_entry(second + SHEEN_WORDS), share.x);
    return mix(low, high, share.y);
}

// The sheen of a surface as it is seen from `wo`.
SheenLobe sheen_lobe_of(Bsdf b, vec3 wo) {
    vec3 numbers = sheen_numbers(b.sheen, wo.z);
    float sine = length(wo.xy);
    SheenLobe lobe;
    lobe.albedo = numbers.z * b.sheen.reflectance;
    lobe.kept = max(1.0 - max_component(lobe.albedo), 0.0);
    // A diffuse surface sheds less light the darker it is. Other surfaces may have a white lobe.
    float below = lobe.kept * (is_kind(b, BSDF_DIFFUSE) ? max_component(b.color0) : 1.0);
    lobe.probability = min((1.0 - lobe.kept) / max(1.0 - lobe.kept + below, 1.0e-20), MOST_SHEEN);
    lobe.toward = sine > 1.0e-6 ? wo.xy / sine : vec2(1.0, 0.0);
    lobe.stretch = max(numbers.x, 1.0e-3);
    lobe.shift = -numbers.y;
    return lobe;
}

// Finds the lobe of a surface's sheen. Where no sheen is seen, the lobe reflects nothing.
void cover_by_sheen(inout Bsdf b, vec3 wo) {
    if (bsdf_flag(b, MATERIAL_SHEEN) && wo.z > 0.0) b.sheen_lobe = sheen_lobe_of(b, wo);
}

// Density of the sheen's lobe, per steradian.
float pdf_sheen(SheenLobe lobe, vec3 wi) {
    float along = dot(lobe.toward, wi.xy);
    float across = lobe.toward.x * wi.y - lobe.toward.y * wi.x;
    vec3 original = vec3(lobe.stretch * along + lobe.shift * wi.z, lobe.stretch * across, wi.z);
    float size = lobe.stretch / max(dot(original, original), 1.0e-20);
    return INV_PI * max(wi.z, 0.0) * size * size;
}

BsdfSample sample_sheen(SheenLobe lobe, vec2 u) {
    vec3 original = sample_cosine_hemisphere(u);
    vec2 w = vec2(original.x - lobe.shift * original.z, original.y) / lobe.stretch;
    vec2 turned = vec2(w.x * lobe.toward.x - w.y * lobe.toward.y, w.x * lobe.toward.y + w.y * lobe.toward.x);
    vec3 wi = normalize(vec3(turned, original.z));
    return BsdfSample(wi, wi.z > 0.0 ? LOBE_GLOSSY : LOBE_NONE, vec3(0.0), 1.0);
}

#endif
