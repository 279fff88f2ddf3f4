// Where a path goes from a surface: to where its BSDF or a guide sends it.
#ifndef GUIDING_GLSL
#define GUIDING_GLSL
#include "bsdf.glsl"
#include "frame.glsl"
#include "guided_direction.glsl"
#include "relief.glsl"

struct DirectionSample {
    vec3 wi;         // world space
    vec3 weight;     // f cos / pdf; zero where the sample is invalid
    float pdf;       // per steradian; 0 where no other sampler can draw the direction
    float eta;       // index of refraction behind `wi` over that in front, where light is transmitted; else 1
    uint bin;        // direction bin of `wi`; 0 without a guide
    float radiance;  // L of that bin
    bool lost;       // a guided direction points below the surface, where nothing is scattered
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

Guide guide_at(Scatterer x) {
    if (SAMPLER == SAMPLER_BSDF) return NO_GUIDE;
    return guide_of(x.cell, x.frame[2]);
}

bool is_guided(Guide guide) {
    return SAMPLER != SAMPLER_BSDF && is_filled(guide.entry);
}

// Density of the local direction `wi` where the diffuse lobe is sampled.
float pdf_diffuse_lobe(Scatterer x, Guide guide, vec3 wi) {
    if (!is_guided(guide)) return pdf_cosine_hemisphere(wi.z);
    return pdf_guide(guide, x.frame * wi);
}

// Share of the samples that a guide takes of a scattering function without a diffuse lobe. The authors' code guides two of
// them; a dielectric keeps a tenth for the side that no hemisphere of the guide reaches.
float guided_share(Bsdf b) {
    float share = 0.0;
    // A coating reflects into a single direction besides, which no guide draws.
    if (bsdf_flag(b, MATERIAL_COATED)) return share;
    if (GUIDE_SET == GUIDE_SET_AUTHORS && is_kind(b, BSDF_ROUGH_CONDUCTOR)) share = 1.0;
    if (GUIDE_SET == GUIDE_SET_AUTHORS && is_kind(b, BSDF_ROUGH_DIELECTRIC)) share = 0.9;
    return share;
}

// Density of the local direction `wi` where the guide, or else the diffuse lobe's own sampler, has density `guide_density`.
float pdf_mixture(Scatterer x, Guide guide, vec3 wi, float guide_density) {
    float pdf = pdf_bsdf(x.bsdf, x.wo, wi, guide_density);
    if (GUIDE_SET == GUIDE_SET_AUTHORS && is_guided(guide)) pdf = mix(pdf, guide_density, guided_share(x.bsdf));
    return pdf;
}

// Density with which sample_direction draws the local direction `wi`, other than by a lobe of single directions.
float pdf_direction(Scatterer x, Guide guide, vec3 wi) {
    return pdf_mixture(x, guide, wi, pdf_diffuse_lobe(x, guide, wi));
}

// Density of a sample; likewise.
float sample_pdf(Scatterer x, Guide guide, BsdfSample s, float guide_density) {
    bool spread = s.lobe == LOBE_DIFFUSE || s.lobe == LOBE_GLOSSY;
    return spread ? pdf_mixture(x, guide, s.wi, guide_density) : 0.0;
}

// f cos / pdf of a sample.
vec3 sample_weight(Scatterer x, BsdfSample s, float pdf) {
    if (s.lobe == LOBE_DELTA) return has_relief() ? s.weight * relief_shadowing(x.upright, s.wi) : s.weight;
    return pdf > 0.0 ? eval_scatterer(x, s.wi) / (pdf * PDF_TAMPER) : vec3(0.0);
}

// The BSDF's own sample; with a grid at work, also what that holds for its direction.
DirectionSample sample_direction_bsdf(Scatterer x, Guide guide, BsdfSample s) {
    vec3 wi = x.frame * s.wi;
    float pdf = sample_pdf(x, guide, s, pdf_diffuse_lobe(x, guide, s.wi));
    DirectionSample result = DirectionSample(wi, sample_weight(x, s, pdf), pdf, s.eta, 0u, 0.0, false, 0u, false);
    if (SAMPLER != SAMPLER_BSDF) {
        result.bin = direction_bin(wi);
        result.radiance = radiance(radiance_index(x.cell, result.bin));
    }
    return result;
}

// Index of refraction behind a guided direction over that in front.
float refraction(Scatterer x, vec3 wi) {
    bool transmits = GUIDE_SET == GUIDE_SET_AUTHORS && is_kind(x.bsdf, BSDF_ROUGH_DIELECTRIC) && x.wo.z * wi.z < 0.0;
    float eta = x.bsdf.scalars0.z;
    return transmits ? (x.wo.z > 0.0 ? eta : 1.0 / eta) : 1.0;
}

// A guided direction in place of the lobe's that the guide stands for.
DirectionSample sample_direction_guided(RandomKey key, uint vertex, float choice, Scatterer x, Guide guide, BsdfSample s) {
    GuidedSample guided = sample_guide(key, vertex, choice, guide);
    s.wi = guided.wi * x.frame;
    float pdf = sample_pdf(x, guide, s, guided.pdf);
    vec3 weight = sample_weight(x, s, pdf);
    bool lost = s.wi.z <= 0.0 && max_component(weight) == 0.0;
    float eta = refraction(x, s.wi);
    return DirectionSample(guided.wi, weight, pdf, eta, guided.bin, guided.radiance, lost, guided.tries, guided.overrun);
}

// Draws the direction in which a path leaves a surface.
DirectionSample sample_direction(RandomKey key, uint vertex, vec4 u, Scatterer x, Guide guide) {
    float share = guided_share(x.bsdf);
    bool replaced = u.z < share;
    if (GUIDE_SET == GUIDE_SET_AUTHORS && is_guided(guide) && share < 1.0) u.z = max(u.z - share, 0.0) / (1.0 - share);
    BsdfSample s = sample_bsdf(x.bsdf, x.wo, u.xyz);
    if (x.passes) s = BsdfSample(-x.wo, LOBE_DELTA, vec3(1.0), 1.0);
    bool guidable = s.lobe == LOBE_DIFFUSE;
    if (GUIDE_SET == GUIDE_SET_AUTHORS && replaced && !x.passes) {
        guidable = true;
        if (is_guided(guide)) s.lobe = LOBE_GLOSSY;
    }
    if (is_guided(guide) && guidable) return sample_direction_guided(key, vertex, u.x, x, guide, s);
    if (SAMPLER != SAMPLER_BSDF && guidable) mark_guide(guide);
    return sample_direction_bsdf(x, guide, s);
}

#endif
