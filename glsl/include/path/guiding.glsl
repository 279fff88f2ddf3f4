// Where a path goes from a surface: to where its BSDF or a guide sends it.
#ifndef GUIDING_GLSL
#define GUIDING_GLSL
#include "bsdf/bsdf.glsl"
#include "guide/grid/cells.glsl"
#include "film/frame.glsl"
#include "guide/samplers/guided_direction.glsl"
#include "geometry/relief.glsl"
#include "guide/learners/share_learning.glsl"

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
    ShareEvidence evidence;
};

// What a guide knows a point of a surface by: its cell, or the first node of its quadtree.
uint cell_at(vec3 position) {
    if (SAMPLER == SAMPLER_BSDF) return 0u;
    return SAMPLER == SAMPLER_QUADTREE ? quadtree_at(position) : grid_cell(position);
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


bool is_guided(Guide guide) {
    return SAMPLER != SAMPLER_BSDF && is_filled(guide);
}

// Whether scattering functions without a diffuse lobe are guided, too: as a whole, by one-sample multiple importance sampling.
bool guides_whole() {
    return GUIDE_SET != GUIDE_SET_DIFFUSE;
}

// Roughness from which a guide takes a facet distribution as it takes a diffuse lobe. The smoother the surface, the less of
// what the guide draws lies where it reflects.
const float GUIDED_ALPHA = 0.4;

// Part of the samples of a scattering function without a diffuse lobe that a guide has its share of. The authors' code guides
// two of them; a dielectric keeps a tenth for the side that no hemisphere of the guide reaches.
float guided_part(Bsdf b) {
    float share = 0.0;
    // A coating reflects into a single direction besides, which no guide draws.
    if (bsdf_flag(b, MATERIAL_COATED)) return share;
    float roughness = GUIDE_SET == GUIDE_SET_ALL ? min(max(b.scalars0.x, b.scalars0.y) / GUIDED_ALPHA, 1.0) : 1.0;
    if (is_kind(b, BSDF_ROUGH_CONDUCTOR)) share = roughness;
    if (is_kind(b, BSDF_ROUGH_DIELECTRIC)) share = GUIDE_SET == GUIDE_SET_ALL ? 0.5 * roughness : 0.9;
    if (is_kind(b, BSDF_PRINCIPLED) && GUIDE_SET == GUIDE_SET_ALL) share = 0.5;
    return share;
}

Guide guide_at(Scatterer x) {
    if (SAMPLER == SAMPLER_BSDF) return NO_GUIDE;
    bool whole = guides_whole() && guided_part(x.bsdf) > 0.0;
    return guide_of(x.cell, x.frame[2], whole ? SHARE_OF_WHOLES : SHARE_OF_LOBES);
}

// Share of the samples that a guide takes of it. A descent has no share of its own that covers all directions.
float guided_share(Bsdf b, Guide guide) {
    return descends() ? guided_part(b) * (1.0 - guide.bsdf_share) : guided_part(b);
}

// What the guide itself has of a density: that of a mixture, or the descent's.
struct GuideDensity {
    float over_lobe;   // where it stands for a diffuse lobe
    float over_whole;  // where it has a share of a whole scattering function
};

// Where `density` is what the sampler says of a sample, the descent's or that of a mixture.
GuideDensity guide_density_of(Scatterer x, Guide guide, vec3 wi, float density) {
    if (!is_guided(guide)) return GuideDensity(pdf_cosine_hemisphere(wi.z), 0.0);
    if (descends()) return GuideDensity(product_density(guide, x.frame * wi, density), density);
    return GuideDensity(density, density);
}

// Density of the local direction `wi` where the guide has this one.
float pdf_mixture(Scatterer x, Guide guide, vec3 wi, GuideDensity density) {
    float pdf = pdf_bsdf(x.bsdf, x.wo, wi, density.over_lobe);
    if (guides_whole() && is_guided(guide)) pdf = mix(pdf, density.over_whole, guided_share(x.bsdf, guide));
    return pdf;
}

// Density with which sample_direction draws the local direction `wi`, other than by a lobe of single directions.
float pdf_direction(Scatterer x, Guide guide, vec3 wi) {
    vec3 world = x.frame * wi;
    float density = descends() ? pdf_descent(guide, world) : pdf_guide(guide, world);
    return pdf_mixture(x, guide, wi, guide_density_of(x, guide, wi, density));
}

// Density of a sample; likewise.
float sample_pdf(Scatterer x, Guide guide, BsdfSample s, float density) {
    bool spread = s.lobe == LOBE_DIFFUSE || s.lobe == LOBE_GLOSSY;
    return spread ? pdf_mixture(x, guide, s.wi, guide_density_of(x, guide, s.wi, density)) : 0.0;
}

// f cos / pdf of a sample.
vec3 sample_weight(Scatterer x, BsdfSample s, float pdf) {
    if (s.lobe == LOBE_DELTA) return has_relief() ? s.weight * relief_shadowing(x.upright, s.wi) : s.weight;
    return pdf > 0.0 ? eval_scatterer(x, s.wi) / pdf : vec3(0.0);
}

// The BSDF's own sample; with a grid at work, also what that holds for its direction.
DirectionSample sample_direction_bsdf(Scatterer x, Guide guide, BsdfSample s) {
    vec3 wi = x.frame * s.wi;
    float density = SAMPLER == SAMPLER_BSDF ? 0.0 : pdf_guide(guide, wi);
    float pdf = sample_pdf(x, guide, s, density);
    vec3 weight = sample_weight(x, s, pdf);
    DirectionSample result = DirectionSample(wi, weight, pdf, s.eta, 0u, 0.0, false, 0u, false, NO_EVIDENCE);
    if (SAMPLER != SAMPLER_BSDF) {
        result.bin = direction_bin(wi);
        result.radiance = radiance(radiance_index(x.cell, result.bin));
    }
    return result;
}

// Index of refraction behind a guided direction over that in front.
float refraction(Scatterer x, vec3 wi) {
    bool transmits = guides_whole() && is_kind(x.bsdf, BSDF_ROUGH_DIELECTRIC) && x.wo.z * wi.z < 0.0;
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
    return DirectionSample(
        guided.wi, weight, pdf, eta, guided.bin, guided.radiance, lost, guided.tries, guided.overrun, NO_EVIDENCE);
}

BsdfSample sample_scatterer(Scatterer x, vec3 u) {
    BsdfSample s = sample_bsdf(x.bsdf, x.wo, u);
    return x.passes ? BsdfSample(-x.wo, LOBE_DELTA, vec3(1.0), 1.0) : s;
}

// What a sample says of the share that it was drawn by, where `density` is the descent's.
ShareEvidence evidence_of(Scatterer x, Guide guide, BsdfSample s, float density, bool whole, vec3 weight, float pdf) {
    float of_both = whole ? pdf : product_density(guide, x.frame * s.wi, density);
    float part = whole ? guided_part(x.bsdf) : 1.0;
    float of_guide = of_both > 0.0 ? (1.0 - guide.bsdf_share) * density / of_both : 0.0;
    uint share = share_index(guide.cell, whole ? SHARE_OF_WHOLES : SHARE_OF_LOBES);
    return ShareEvidence(share, part * mean_rgb(weight), of_guide);
}

// sample_direction of samplers that descend: the surface's own direction is kept or replaced, in one flow.
DirectionSample sample_direction_descent(vec3 u, vec4 u_guide, Scatterer x, Guide guide) {
    BsdfSample s = sample_scatterer(x, u);
    float whole_share = guides_whole() && !x.passes ? guided_share(x.bsdf, guide) : 0.0;
    bool guidable = s.lobe == LOBE_DIFFUSE || whole_share > 0.0;
    bool follows = guidable && is_guided(guide);
    if (guidable && !follows) mark_guide(guide);
    float own_share = whole_share > 0.0 ? 1.0 - whole_share : guide.bsdf_share;
    GuidedSample guided = sample_descent(u_guide, guide, follows, own_share, x.frame * s.wi);
    bool replaced = guided.tries > 0u;
    if (replaced) s = BsdfSample(guided.wi * x.frame, whole_share > 0.0 ? LOBE_GLOSSY : s.lobe, vec3(0.0), 1.0);
    if (replaced) s.eta = refraction(x, s.wi);
    float pdf = sample_pdf(x, guide, s, guided.pdf);
    vec3 weight = sample_weight(x, s, pdf);
    bool lost = follows && s.wi.z <= 0.0 && max_component(weight) == 0.0;
    ShareEvidence evidence = NO_EVIDENCE;
    if (learns_share() && follows && pdf > 0.0) evidence = evidence_of(x, guide, s, guided.pdf, whole_share > 0.0, weight, pdf);
    uint tries = follows ? 1u : 0u;
    return DirectionSample(guided.wi, weight, pdf, s.eta, guided.bin, guided.radiance, lost, tries, false, evidence);
}

// Draws the direction in which a path leaves a surface.
DirectionSample sample_direction(RandomKey key, uint vertex, vec4 u, Scatterer x, Guide guide) {
    if (descends()) {
        vec4 u_guide = unit_floats(random_bits(key, vertex, RANDOM_TRIES));
        return sample_direction_descent(u.xyz, u_guide, x, guide);
    }
    float share = guided_share(x.bsdf, guide);
    bool replaced = u.z < share;
    if (guides_whole() && is_guided(guide) && share < 1.0) u.z = max(u.z - share, 0.0) / (1.0 - share);
    BsdfSample s = sample_scatterer(x, u.xyz);
    bool guidable = s.lobe == LOBE_DIFFUSE;
    if (guides_whole() && replaced && !x.passes) {
        guidable = true;
        if (is_guided(guide)) s.lobe = LOBE_GLOSSY;
    }
    if (is_guided(guide) && guidable) return sample_direction_guided(key, vertex, u.x, x, guide, s);
    if (SAMPLER != SAMPLER_BSDF && guidable) mark_guide(guide);
    return sample_direction_bsdf(x, guide, s);
}

#endif
