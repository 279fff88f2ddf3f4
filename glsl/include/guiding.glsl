// The switch over the samplers: where a path goes from a surface.
#ifndef GUIDING_GLSL
#define GUIDING_GLSL
#include "bsdf.glsl"
#include "equal_area.glsl"
#include "frame.glsl"
#include "rejection_mix.glsl"
#include "relief.glsl"
#include "surface.glsl"

struct DirectionSample {
    vec3 wi;         // world space
    vec3 weight;     // f cos / pdf; zero where the sample is invalid
    float eta;       // index of refraction behind `wi` over that in front, where light is transmitted; else 1
    uint bin;        // direction bin of `wi`; 0 without a guide
    float radiance;  // L of that bin
    bool below;      // a guided direction points below the surface
    uint tries;      // proposals of a guided sample; 0 where the BSDF was sampled
    bool overrun;
};

// Cell of a point of the scene.
uint grid_cell(vec3 position) {
    vec3 cells = (position - scene().bounds_min) * scene().cells_per_unit;
    uvec3 cell = uvec3(clamp(cells, vec3(0.0), vec3(float(GRID_RESOLUTION) - 0.5)));
    return (cell.z * GRID_RESOLUTION + cell.y) * GRID_RESOLUTION + cell.x;
}

// What a surface is at the point where a path meets it.
struct Scatterer {
    Bsdf bsdf;
    mat3 frame;  // world from local; z along the shading normal, on the side of `wo` where the surface is two-sided
    vec3 wo;     // local
    vec3 upright;  // local: the shading normal that a bump or normal map has tilted the frame against
    bool passes;   // the path goes straight on through a hole
    uint cell;
};

bool has_relief() {
    return has_feature(FEATURE_BUMP | FEATURE_NORMAL_MAP);
}

// f cos.
vec3 eval_scatterer(Scatterer x, vec3 wi) {
    vec3 f = eval_bsdf(x.bsdf, x.wo, wi);
    return has_relief() ? f * relief_shadowing(x.upright, wi) : f;
}

// f cos / pdf of a direction that was drawn with density `diffuse_density` where its lobe is the diffuse one.
vec3 sample_weight(Scatterer x, BsdfSample s, float diffuse_density) {
    if (s.lobe == LOBE_NONE) return vec3(0.0);
    if (s.lobe == LOBE_DELTA) return has_relief() ? s.weight * relief_shadowing(x.upright, s.wi) : s.weight;
    float pdf = pdf_bsdf(x.bsdf, x.wo, s.wi, diffuse_density) * PDF_TAMPER;
    return pdf > 0.0 ? eval_scatterer(x, s.wi) / pdf : vec3(0.0);
}

// The BSDF's own sample; with a grid at work, also what that holds for its direction.
DirectionSample sample_direction_bsdf(Scatterer x, BsdfSample s) {
    vec3 wi = x.frame * s.wi;
    vec3 weight = sample_weight(x, s, pdf_cosine_hemisphere(s.wi.z));
    DirectionSample result = DirectionSample(wi, weight, s.eta, 0u, 0.0, false, 0u, false);
    if (SAMPLER != SAMPLER_BSDF) {
        result.bin = direction_bin(wi, DIRECTION_RESOLUTION);
        result.radiance = radiance(radiance_index(x.cell, result.bin));
    }
    return result;
}

// A guided direction in place of the diffuse lobe's; that lobe has been chosen, and other lobes are sampled as ever.
DirectionSample sample_direction_guided(RandomKey key, uint vertex, float choice, Scatterer x, BsdfSample s) {
    vec3 n = x.frame[2];
    uint normal_bin = direction_bin(n, NORMAL_RESOLUTION);
    vec3 nb = bin_center(normal_bin, NORMAL_RESOLUTION);
    uint index = normalization_index(x.cell, normal_bin);
    NormalizationEntry entry = normalization_entry(index);
    if (!is_filled(entry)) {
        mark_entry(index);
        return sample_direction_bsdf(x, s);
    }
    GuidedSample guided = sample_rejection_mix(key, vertex, choice, x.cell, nb, n, entry);
    DirectionSample result;
    if (s.lobe == LOBE_DIFFUSE) {
        s.wi = guided.wi * x.frame;
        vec3 weight = s.wi.z > 0.0 ? sample_weight(x, s, guided.pdf) : vec3(0.0);
        result = DirectionSample(guided.wi, weight, 1.0, guided.bin, guided.radiance, s.wi.z <= 0.0, guided.tries, guided.overrun);
    } else {
        vec3 wi = x.frame * s.wi;
        vec3 weight = sample_weight(x, s, pdf_rejection_mix(x.cell, nb, n, wi, entry));
        uint bin = direction_bin(wi, DIRECTION_RESOLUTION);
        result = DirectionSample(wi, weight, s.eta, bin, radiance(radiance_index(x.cell, bin)), false, 0u, false);
    }
    return result;
}

// Draws the direction in which a path leaves a surface.
DirectionSample sample_direction(RandomKey key, uint vertex, vec4 u, Scatterer x) {
    BsdfSample s = sample_bsdf(x.bsdf, x.wo, u.xyz);
    if (x.passes) s = BsdfSample(-x.wo, LOBE_DELTA, vec3(1.0), 1.0);
    if (SAMPLER == SAMPLER_BSDF) return sample_direction_bsdf(x, s);
    return sample_direction_guided(key, vertex, u.x, x, s);
}

#endif
