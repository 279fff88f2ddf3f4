// Draws the direction in which a path leaves a surface, from the BSDF or from a guide, and gives its density.
#ifndef GUIDING_GLSL
#define GUIDING_GLSL
#include "bsdf/bsdf.glsl"
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
    float radiance;  // learned radiance L of that bin
    bool lost;       // a guided direction points below the surface, which scatters nothing there
    uint tries;      // proposals of a guided sample; 0 where the BSDF was sampled
    bool overrun;    // the driver cut a loop short
    ShareEvidence evidence;  // for the share that cells learn
};

// A surface as it scatters at the point where a path meets it.
struct Scatterer {
    Bsdf bsdf;
    mat3 frame;    // world from local; z along the shading normal, on the side of `wo` where the surface is two-sided
    vec3 wo;       // local direction to where the path comes from
    vec3 upright;  // local shading normal before a bump or normal map tilts the frame
    bool passes;   // the point is a hole: the path goes straight on
    uint cell;     // of the guide
};

bool has_relief() {
    return has_feature(FEATURE_BUMP | FEATURE_NORMAL_MAP);
}

// Share of the light from the local direction `wi` that a bump or normal map leaves.
float lit_share(Scatterer scatterer, vec3 wi) {
    float share = relief_shadowing(scatterer.upright, wi);
    bool unshadowed = has_feature(FEATURE_RELIEF_UNSHADOWED) && bsdf_flag(scatterer.bsdf, MATERIAL_RELIEF_UNSHADOWED);
    if (unshadowed) share = is_on_one_side(scatterer.upright, wi) ? 1.0 : 0.0;
    return share;
}

// f cos, for the local direction `wi`.
vec3 eval_scatterer(Scatterer scatterer, vec3 wi) {
    vec3 f = eval_bsdf(scatterer.bsdf, scatterer.wo, wi);
    return has_relief() ? f * lit_share(scatterer, wi) : f;
}

bool is_guided(Guide guide) {
    return uses_guide() && is_filled(guide);
}

// BSDFs without a diffuse lobe are guided as a whole: one-sample multiple importance sampling mixes their own samples with
// the guide's.
bool guides_whole() {
    return GUIDE_SET != GUIDE_SET_DIFFUSE;
}

// Part of the samples of a BSDF without a diffuse lobe in which the guide has a share. A coating also reflects into a single
// direction, which a guide cannot draw.
float guided_part(Bsdf bsdf) {
    return bsdf_flag(bsdf, MATERIAL_COATED) ? 0.0 : guided_part_bsdf_of_kind(bsdf);
}

Guide guide_at(Scatterer scatterer) {
    if (!uses_guide()) return NO_GUIDE;
    bool whole = guides_whole() && guided_part(scatterer.bsdf) > 0.0;
    return guide_of(scatterer.cell, scatterer.frame[2], whole ? SHARE_OF_WHOLES : SHARE_OF_LOBES);
}

// Share of a BSDF's samples that the guide draws. Samplers that descend leave the BSDF its own share of the guided part, for a
// descent does not reach all directions.
float guided_share(Bsdf bsdf, Guide guide) {
    return descends() ? guided_part(bsdf) * (1.0 - guide.bsdf_share) : guided_part(bsdf);
}

// Density of the guide's directions, per steradian.
struct GuideDensity {
    float over_lobe;   // where the guide stands for a diffuse lobe
    float over_whole;  // where the guide has a share of a whole BSDF
};

// Both densities of the local direction `wi`. `density` is the sampler's: of the descent, or of the guide mixed with its
// uniform share.
GuideDensity guide_density_of(Scatterer scatterer, Guide guide, vec3 wi, float density) {
    if (!is_guided(guide)) return GuideDensity(pdf_cosine_hemisphere(wi.z), 0.0);
    if (descends()) return GuideDensity(product_density(guide, scatterer.frame * wi, density), density);
    return GuideDensity(density, density);
}

// Density of the local direction `wi`: of the BSDF's own samples mixed with the guide's, whose density is given.
float pdf_mixture(Scatterer scatterer, Guide guide, vec3 wi, GuideDensity density) {
    float pdf = pdf_bsdf(scatterer.bsdf, scatterer.wo, wi, density.over_lobe);
    if (guides_whole() && is_guided(guide)) pdf = density_of_choice(pdf, density.over_whole, guided_share(scatterer.bsdf, guide));
    return pdf;
}

// Density with which sample_direction draws the local direction `wi`. Lobes of single directions are left out.
float pdf_direction(Scatterer scatterer, Guide guide, vec3 wi) {
    vec3 world = scatterer.frame * wi;
    float density = descends() ? pdf_descent(guide, world) : pdf_guide(guide, world);
    return pdf_mixture(scatterer, guide, wi, guide_density_of(scatterer, guide, wi, density));
}

// Density of a sample; 0 for a lobe of single directions. `density` is the sampler's, see guide_density_of.
float sample_pdf(Scatterer scatterer, Guide guide, BsdfSample bsdf_sample, float density) {
    bool spread = bsdf_sample.lobe == LOBE_DIFFUSE || bsdf_sample.lobe == LOBE_GLOSSY;
    return spread
        ? pdf_mixture(scatterer, guide, bsdf_sample.wi, guide_density_of(scatterer, guide, bsdf_sample.wi, density))
        : 0.0;
}

// f cos / pdf of a sample.
vec3 sample_weight(Scatterer scatterer, BsdfSample bsdf_sample, float pdf) {
    if (bsdf_sample.lobe == LOBE_DELTA) {
        vec3 weight = bsdf_sample.weight;
        return has_relief() ? weight * lit_share(scatterer, bsdf_sample.wi) : weight;
    }
    return pdf > 0.0 ? eval_scatterer(scatterer, bsdf_sample.wi) / pdf : vec3(0.0);
}

// Turns the BSDF's own sample into a direction. With a guide, its bin of the direction is looked up for learning.
DirectionSample sample_direction_bsdf(Scatterer scatterer, Guide guide, BsdfSample bsdf_sample) {
    vec3 wi = scatterer.frame * bsdf_sample.wi;
    float density = uses_guide() ? pdf_guide(guide, wi) : 0.0;
    float pdf = sample_pdf(scatterer, guide, bsdf_sample, density);
    vec3 weight = sample_weight(scatterer, bsdf_sample, pdf);
    DirectionSample result = DirectionSample(wi, weight, pdf, bsdf_sample.eta, 0u, 0.0, false, 0u, false, NO_EVIDENCE);
    if (uses_guide()) {
        result.bin = direction_bin(wi);
        result.radiance = radiance(radiance_index(scatterer.cell, result.bin));
    }
    return result;
}

// Index of refraction behind the guided local direction `wi` over that in front; 1 where no light is transmitted or it scales no radiance.
float refraction(Scatterer scatterer, vec3 wi) {
    bool transmits = guides_whole() && is_kind(scatterer.bsdf, BSDF_ROUGH_DIELECTRIC) && scatterer.wo.z * wi.z < 0.0;
    if (is_unscaled(scatterer.bsdf)) transmits = false;
    float eta = facets_of(scatterer.bsdf).eta;
    return transmits ? (scatterer.wo.z > 0.0 ? eta : 1.0 / eta) : 1.0;
}

// Draws a guided direction in place of `bsdf_sample`, whose lobe the guide stands for.
DirectionSample sample_direction_guided(
    RandomKey key, uint vertex, float choice, Scatterer scatterer, Guide guide, BsdfSample bsdf_sample) {
    GuidedSample guided = sample_guide(key, vertex, choice, guide);
    bsdf_sample.wi = guided.wi * scatterer.frame;
    float pdf = sample_pdf(scatterer, guide, bsdf_sample, guided.pdf);
    vec3 weight = sample_weight(scatterer, bsdf_sample, pdf);
    bool lost = bsdf_sample.wi.z <= 0.0 && max_component(weight) == 0.0;
    float eta = refraction(scatterer, bsdf_sample.wi);
    return DirectionSample(
        guided.wi, weight, pdf, eta, guided.bin, guided.radiance, lost, guided.tries, guided.overrun, NO_EVIDENCE);
}

// The BSDF's sample; in a hole, the direction straight on.
BsdfSample sample_scatterer(Scatterer scatterer, vec3 u) {
    BsdfSample bsdf_sample = sample_bsdf(scatterer.bsdf, scatterer.wo, u);
    return scatterer.passes ? BsdfSample(-scatterer.wo, LOBE_DELTA, vec3(1.0), 1.0) : bsdf_sample;
}

// Evidence of a sample for the BSDF's share. `density` is the descent's; where `whole` is true, the guide has a share of a
// whole BSDF.
ShareEvidence evidence_of(
    Scatterer scatterer, Guide guide, BsdfSample bsdf_sample, float density, bool whole, vec3 weight, float pdf) {
    float of_both = whole ? pdf : product_density(guide, scatterer.frame * bsdf_sample.wi, density);
    float part = whole ? guided_part(scatterer.bsdf) : 1.0;
    float of_guide = of_both > 0.0 ? (1.0 - guide.bsdf_share) * density / of_both : 0.0;
    uint share = share_index(guide.cell, whole ? SHARE_OF_WHOLES : SHARE_OF_LOBES);
    return ShareEvidence(share, part * mean_rgb(weight), of_guide);
}

// Draws the direction with a sampler that descends, which keeps or replaces the BSDF's own direction. All lanes take one
// flow.
DirectionSample sample_direction_descent(vec3 u, vec4 u_guide, Scatterer scatterer, Guide guide) {
    BsdfSample bsdf_sample = sample_scatterer(scatterer, u);
    float whole_share = guides_whole() && !scatterer.passes ? guided_share(scatterer.bsdf, guide) : 0.0;
    bool guidable = bsdf_sample.lobe == LOBE_DIFFUSE || whole_share > 0.0;
    bool follows = guidable && is_guided(guide);
    if (guidable && !follows) mark_guide(guide);
    float own_share = whole_share > 0.0 ? 1.0 - whole_share : guide.bsdf_share;
    GuidedSample guided = sample_descent(u_guide, guide, follows, own_share, scatterer.frame * bsdf_sample.wi);
    bool replaced = guided.tries > 0u;
    if (replaced) {
        uint lobe = whole_share > 0.0 ? LOBE_GLOSSY : bsdf_sample.lobe;
        bsdf_sample = BsdfSample(guided.wi * scatterer.frame, lobe, vec3(0.0), 1.0);
    }
    if (replaced) bsdf_sample.eta = refraction(scatterer, bsdf_sample.wi);
    float pdf = sample_pdf(scatterer, guide, bsdf_sample, guided.pdf);
    vec3 weight = sample_weight(scatterer, bsdf_sample, pdf);
    bool lost = follows && bsdf_sample.wi.z <= 0.0 && max_component(weight) == 0.0;
    ShareEvidence evidence = NO_EVIDENCE;
    if (learns_share() && follows && pdf > 0.0) {
        evidence = evidence_of(scatterer, guide, bsdf_sample, guided.pdf, whole_share > 0.0, weight, pdf);
    }
    uint tries = follows ? 1u : 0u;
    return DirectionSample(
        guided.wi, weight, pdf, bsdf_sample.eta, guided.bin, guided.radiance, lost, tries, false, evidence);
}

// Draws the direction in which a path leaves a surface. A guide stands for diffuse lobes, and has a share of BSDFs that are
// guided as a whole.
DirectionSample sample_direction(RandomKey key, uint vertex, vec4 u, Scatterer scatterer, Guide guide) {
    if (descends()) {
        vec4 u_guide = unit_floats(random_bits(key, vertex, RANDOM_TRIES));
        return sample_direction_descent(u.xyz, u_guide, scatterer, guide);
    }
    float share = guided_share(scatterer.bsdf, guide);
    bool replaced = u.z < share;
    if (guides_whole() && is_guided(guide) && share < 1.0) u.z = max(u.z - share, 0.0) / (1.0 - share);
    BsdfSample bsdf_sample = sample_scatterer(scatterer, u.xyz);
    bool guidable = bsdf_sample.lobe == LOBE_DIFFUSE;
    if (guides_whole() && replaced && !scatterer.passes) {
        guidable = true;
        if (is_guided(guide)) bsdf_sample.lobe = LOBE_GLOSSY;
    }
    if (is_guided(guide) && guidable) return sample_direction_guided(key, vertex, u.x, scatterer, guide, bsdf_sample);
    if (uses_guide() && guidable) mark_guide(guide);
    return sample_direction_bsdf(scatterer, guide, bsdf_sample);
}

#endif
