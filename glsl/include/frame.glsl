// Set 0, Frame: the film, the camera, materials, emitters and counters. The only file that indexes them.
#ifndef FRAME_GLSL
#define FRAME_GLSL
#include "constants.glsl"
#include "variant.glsl"

// Running mean and sum of squared deviations of a pixel's samples (Welford 1962), per channel.
struct FilmRadiance {
    vec3 mean;
    uint sample_count;
    vec3 squared_deviation;
    uint hit_count;  // samples whose camera ray hit something
};

// Means over a pixel's samples of what the camera ray hits first; depth over those that hit.
struct FilmFeatures {
    vec3 albedo;
    float depth;
    vec3 normal;
    float reserved;
};

// What does not change during a render.
struct SceneConstants {
    vec4 world_from_camera[3];  // rows of the affine matrix
    vec2 film_size;             // whole film in pixels
    vec2 raster_scale;          // tangents of the half fields of view
    vec2 principal_point;       // in picture widths and heights
    float near_clip;
    float far_clip;
    vec3 bounds_min;
    float ray_epsilon;          // how far a scattered ray's origin leaves its surface, scene units
    vec3 cells_per_unit;        // grid resolution / extent
    float target_limit;         // learning targets saturate here, W/(m^2 sr)
    vec3 environment;           // radiance of a constant environment, factor of a map's
    uint seed;
    uvec2 window_offset;        // of the rendered window within the film
    uvec2 window_size;
    uint light_count;           // entries of the table that lights are chosen from
    uint first_light;           // where it begins among the emitters' texels
    vec4 environment_from_world[3];  // rows; the fourth column is unused
    uvec2 environment_size;     // texels of the map
    uvec2 environment_blocks;   // columns and rows of the table that its directions are drawn from
    uint first_environment_texel;    // where the map begins among the emitters' texels
    uint first_environment_block;    // likewise the table
    uint environment_light;     // entry of the environment among the lights, or NONE
    uint reserved;
};

// Texels of a material's record. See material.glsl.
const uint MATERIAL_TEXELS = 11u;

layout(scalar, set = 0, binding = 0) restrict buffer FilmRadiancePage { FilmRadiance film_radiance[]; };
layout(scalar, set = 0, binding = 1) restrict buffer FilmFeaturesPage { FilmFeatures film_features[]; };
layout(scalar, set = 0, binding = 2) uniform Scene { SceneConstants scene_constants; };
#ifdef TEXEL_READS
layout(set = 0, binding = 3) uniform usamplerBuffer materials;
layout(set = 0, binding = 4) uniform usamplerBuffer emitters;
layout(set = 0, binding = 6) uniform usamplerBuffer texel_words;
#else
layout(scalar, set = 0, binding = 3) restrict readonly buffer Materials { uvec4 materials[]; };
layout(scalar, set = 0, binding = 4) restrict readonly buffer Emitters { uvec4 emitters[]; };
layout(scalar, set = 0, binding = 6) restrict readonly buffer TexelWords { uint texel_words[]; };
#endif
layout(scalar, set = 0, binding = 5) restrict buffer Counters { uint counters[]; };

SceneConstants scene() {
    return scene_constants;
}

#ifdef TEXEL_READS
uvec4 fetch_material(uint material, uint texel) {
    return texelFetch(materials, int(material * MATERIAL_TEXELS + texel));
}

// Emitters, then lights, then what belongs to the environment.
uvec4 fetch_emitter_texel(uint texel) {
    return texelFetch(emitters, int(texel));
}

// A word of the materials' tables.
uint texel_word(uint address) {
    return texelFetch(texel_words, int(address)).x;
}
#else
uvec4 fetch_material(uint material, uint texel) {
    return materials[material * MATERIAL_TEXELS + texel];
}

uvec4 fetch_emitter_texel(uint texel) {
    return emitters[texel];
}

uint texel_word(uint address) {
    return texel_words[address];
}
#endif

void count(uint counter, uint amount) {
    if (amount != 0u) atomicAdd(counters[counter], amount);
}

FilmRadiance load_film_radiance(uint index) {
    return film_radiance[index];
}

FilmFeatures load_film_features(uint index) {
    return film_features[index];
}

void store_film(uint index, FilmRadiance radiance, FilmFeatures features) {
    film_radiance[index] = radiance;
    film_features[index] = features;
}

#endif
