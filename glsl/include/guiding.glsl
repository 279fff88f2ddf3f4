// The switch over the samplers: where a path goes from a surface.
#ifndef GUIDING_GLSL
#define GUIDING_GLSL
#include "bsdf.glsl"
#include "equal_area.glsl"
#include "frame.glsl"
#include "rejection_mix.glsl"
#include "surface.glsl"

struct DirectionSample {
    vec3 wi;         // world space
    vec3 weight;     // f cos / pdf; zero where the sample is invalid
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

DirectionSample sample_direction_bsdf(Material m, mat3 frame, vec2 u) {
    vec3 local = sample_bsdf(m, u);
    float pdf = pdf_bsdf(m, local) * PDF_TAMPER;
    vec3 weight = local.z > 0.0 ? eval_bsdf(m, local) / pdf : vec3(0.0);
    return DirectionSample(frame * local, weight, 0u, 0.0, false, 0u, false);
}

DirectionSample sample_direction_guided(RandomKey key, uint vertex, vec4 u, Material m, mat3 frame, uint cell) {
    vec3 n = frame[2];
    uint normal_bin = direction_bin(n, NORMAL_RESOLUTION);
    uint index = normalization_index(cell, normal_bin);
    NormalizationEntry entry = normalization_entry(index);
    DirectionSample s;
    if (is_filled(entry)) {
        GuidedSample guided = sample_rejection_mix(key, vertex, u.z, cell, bin_center(normal_bin, NORMAL_RESOLUTION), n, entry);
        float cos_theta = dot(n, guided.wi);
        vec3 weight = cos_theta > 0.0 ? eval_bsdf(m, vec3(0.0, 0.0, cos_theta)) / (guided.pdf * PDF_TAMPER) : vec3(0.0);
        s = DirectionSample(guided.wi, weight, guided.bin, guided.radiance, cos_theta <= 0.0, guided.tries, guided.overrun);
    } else {
        mark_entry(index);
        s = sample_direction_bsdf(m, frame, u.xy);
        s.bin = direction_bin(s.wi, DIRECTION_RESOLUTION);
        s.radiance = radiance(radiance_index(cell, s.bin));
    }
    return s;
}

// Draws the next direction at a surface whose facing normal is the frame's z-axis.
DirectionSample sample_direction(RandomKey key, uint vertex, vec4 u, Material m, mat3 frame, uint cell) {
    if (SAMPLER == SAMPLER_BSDF) return sample_direction_bsdf(m, frame, u.xy);
    return sample_direction_guided(key, vertex, u, m, frame, cell);
}

#endif
