// Set 0, Frame: the film, the camera, materials, emitters and counters. Only this file indexes the buffers of the set.
#ifndef FRAME_GLSL
#define FRAME_GLSL
#include "film/features.glsl"
#include "math/constants.glsl"
#include "generated/lights.glsl"
#include "generated/material.glsl"
#include "generated/texture.glsl"
#include "generated/volume.glsl"
#include "shared/sets.glsl"
#include "shared/variant.glsl"

// Running mean and sum of squared deviations of a pixel's samples, per channel (Welford 1962).
struct FilmRadiance {
    vec3 mean;               // mean of the pixel's samples, linear sRGB
    uint sample_count;       // number of the pixel's samples
    vec3 squared_deviation;  // sum of squared deviations from the mean
    uint hit_count;          // number of samples whose camera ray hit something
};

// Constants of a render.
struct SceneConstants {
    vec4 world_from_camera[3];       // rows of the affine matrix
    vec2 film_size;                  // size of the whole film, in pixels
    // tangents of half the fields of view; orthographic: half the sides of the view, in camera units; equirectangular: the angles that the
    // picture spans to the right and down, in turns
    vec2 raster_scale;
    // principal point, in picture widths and heights; equirectangular: longitude and latitude of the top left corner, in turns
    vec2 principal_point;
    float near_clip;                 // distance of the near plane
    float far_clip;                  // distance of the far plane
    vec3 bounds_min;                 // lower corner of the scene
    float aperture_radius;           // radius of a thin lens
    vec3 cells_per_unit;             // grid size divided by the scene's extent
    float target_limit;              // limit at which learning targets are clamped, W/(m^2 sr)
    vec3 environment;                // radiance of a constant environment, or factor of a map's texels
    uint seed;                       // the render's seed
    uvec2 window_offset;             // offset of the rendered window within the film
    uvec2 window_size;               // size of the rendered window, in pixels
    uint light_count;                // number of lights in the alias table
    uint first_light;                // first texel of the alias table of lights among the emitters' texels
    vec4 environment_from_world[3];  // rows of the matrix; the fourth column is unused
    uvec2 environment_size;          // width and height of the environment map, in texels
    uvec2 environment_blocks;        // columns and rows of the alias table for directions of the environment
    uint first_environment_texel;    // first texel of the environment map among the emitters' texels
    uint first_environment_block;    // first texel of the alias table for directions among the emitters' texels
    uint environment_light;          // index of the environment, or of its first patch, among the lights; NONE without one
    float focus_distance;            // depth at which a thin lens is sharp
    uvec3 grid_size;                 // number of grid positions along each axis
    uint cell_count;                 // number of cells that contain surfaces
    uint all_cell_count;             // number of all cells, parent cells included
    uint first_light_group;          // first texel of the groups of lights among the emitters' texels
    uint first_medium;               // record of the first medium among those of the materials
    uint camera_medium;              // number of the medium around the camera, counted from 1; 0 without one
    uint camera_motion;              // first texel of the camera's motion among those of the primitives
    uint first_volume;               // first texel of the volumes among those of the materials
    uint first_cone;                 // first texel of the cones among the emitters' texels; NONE without one
};

layout(scalar, set = FRAME_SET, binding = 0) restrict buffer FilmRadiancePage { FilmRadiance film_radiance[]; };
layout(scalar, set = FRAME_SET, binding = 1) restrict buffer FilmFeaturesPage { FilmFeatures film_features[]; };
layout(scalar, set = FRAME_SET, binding = 2) uniform Scene { SceneConstants scene_constants; };
#ifdef TEXEL_READS
layout(set = FRAME_SET, binding = 3) uniform usamplerBuffer materials;
layout(set = FRAME_SET, binding = 4) uniform usamplerBuffer emitters;
layout(set = FRAME_SET, binding = 6) uniform usamplerBuffer texel_words;
layout(set = FRAME_SET, binding = 7) uniform usamplerBuffer textures;
layout(set = FRAME_SET, binding = 8) uniform usamplerBuffer texel_words1;
layout(set = FRAME_SET, binding = 9) uniform usamplerBuffer texel_words2;
layout(set = FRAME_SET, binding = 10) uniform usamplerBuffer texel_words3;
#else
layout(scalar, set = FRAME_SET, binding = 3) restrict readonly buffer Materials { uvec4 materials[]; };
layout(scalar, set = FRAME_SET, binding = 4) restrict readonly buffer Emitters { uvec4 emitters[]; };
layout(scalar, set = FRAME_SET, binding = 6) restrict readonly buffer TexelWords { uint texel_words[]; };
layout(scalar, set = FRAME_SET, binding = 7) restrict readonly buffer Textures { uvec4 textures[]; };
layout(scalar, set = FRAME_SET, binding = 8) restrict readonly buffer TexelWords1 { uint texel_words1[]; };
layout(scalar, set = FRAME_SET, binding = 9) restrict readonly buffer TexelWords2 { uint texel_words2[]; };
layout(scalar, set = FRAME_SET, binding = 10) restrict readonly buffer TexelWords3 { uint texel_words3[]; };
#endif
layout(scalar, set = FRAME_SET, binding = 5) restrict buffer Counters { uint counters[]; };
// Scratch memory: the tile states and halves of a film page for adaptive sampling (halves.glsl), the paths of a wave
// (wavefront.glsl), or first hits (first_hits.comp). They share one binding because devices have few bindings. Without any, the buffer is
// nearly empty.
layout(scalar, set = FRAME_SET, binding = 11) restrict buffer Scratch { uvec4 scratch[]; };

SceneConstants scene() {
    return scene_constants;
}

#ifdef TEXEL_READS
uvec4 material_texel(uint material, uint texel) {
    return texelFetch(materials, int(material * MATERIAL_TEXELS + texel));
}

uvec4 volume_texel(uint volume, uint texel) {
    return texelFetch(materials, int(scene().first_volume + volume * VOLUME_TEXELS + texel));
}

// Texel of the emitter buffer, which holds first the emitters, then the lights, delta lights, the environment's table and map, and
// the groups of lights.
uvec4 fetch_emitter_texel(uint texel) {
    return texelFetch(emitters, int(texel));
}

uvec4 texture_texel(uint index, uint texel) {
    return texelFetch(textures, int(index * TEXTURE_TEXELS + texel));
}

uint table_word(uint address) {
    return texelFetch(texel_words, int(address)).x;
}

uint paged_texel_word(uint page, uint index) {
    switch (page) {
        case 0u: return texelFetch(texel_words, int(index)).x;
        case 1u: return texelFetch(texel_words1, int(index)).x;
        case 2u: return texelFetch(texel_words2, int(index)).x;
        default: return texelFetch(texel_words3, int(index)).x;
    }
}
#else
uvec4 material_texel(uint material, uint texel) {
    return materials[material * MATERIAL_TEXELS + texel];
}

uvec4 volume_texel(uint volume, uint texel) {
    return materials[scene().first_volume + volume * VOLUME_TEXELS + texel];
}

uvec4 fetch_emitter_texel(uint texel) {
    return emitters[texel];
}

uvec4 texture_texel(uint index, uint texel) {
    return textures[index * TEXTURE_TEXELS + texel];
}

// Word of a table. The tables lie in the first page.
uint table_word(uint address) {
    return texel_words[address];
}

uint paged_texel_word(uint page, uint index) {
    switch (page) {
        case 0u: return texel_words[index];
        case 1u: return texel_words1[index];
        case 2u: return texel_words2[index];
        default: return texel_words3[index];
    }
}
#endif

uvec4 emitter_texel(uint emitter, uint texel) {
    return fetch_emitter_texel(emitter + texel);
}

// Texel of an emitter's cone. The emitters' texels end with the cones, if an emitter has one.
uvec4 cone_texel(uint emitter, uint texel) {
    return fetch_emitter_texel(scene().first_cone + emitter + texel);
}

uvec4 light_texel(uint light, uint texel) {
    return fetch_emitter_texel(scene().first_light + light + texel);
}

// Texel of a delta light, whose record begins at the texel `first` of the buffer.
uvec4 delta_light_texel(uint first, uint texel) {
    return fetch_emitter_texel(first + texel);
}

// Texel of the record of an area light that an instance shows, which is the texel `at` of the buffer.
uvec4 placed_light_texel(uint at, uint texel) {
    return fetch_emitter_texel(at + texel);
}

uvec4 block_texel(uint block, uint texel) {
    return fetch_emitter_texel(scene().first_environment_block + block + texel);
}

uvec4 light_group_texel(uint group, uint texel) {
    return fetch_emitter_texel(scene().first_light_group + group + texel);
}

// Word of an image or of a material's table.
uint texel_word(uint address) {
    uint page = TEXEL_PAGES != 1u ? address >> TEXEL_PAGE_SHIFT : 0u;
    return paged_texel_word(page, address & ((1u << TEXEL_PAGE_SHIFT) - 1u));
}

// Adds to a statistic. It has two words, so that no dispatch overflows it: the low words of all statistics come first.
void count(uint counter, uint amount) {
    if (amount == 0u) return;
    uint before = atomicAdd(counters[counter], amount);
    if (before + amount < before) atomicAdd(counters[COUNTER_COUNT + counter], 1u);
}

// Adds to a counter that all invocations share. Returns the counter's value before the addition.
uint reserve(uint counter, uint amount) {
    return atomicAdd(counters[counter], amount);
}

// Value of a counter. No invocation of the same dispatch may add to this counter.
uint counted(uint counter) {
    return counters[counter];
}

uint scratch_count() {
    return uint(scratch.length());
}

uvec4 load_scratch(uint index) {
    return scratch[index];
}

void store_scratch(uint index, uvec4 value) {
    scratch[index] = value;
}

uint load_scratch_word(uint index) {
    return scratch[index / 4u][index % 4u];
}

void store_scratch_word(uint index, uint value) {
    scratch[index / 4u][index % 4u] = value;
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
