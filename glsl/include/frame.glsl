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
    vec2 raster_scale;          // tangents of the half fields of view; orthographic: half the view's sides, camera units
    vec2 principal_point;       // in picture widths and heights
    float near_clip;
    float far_clip;
    vec3 bounds_min;
    float aperture_radius;      // of a thin lens
    vec3 cells_per_unit;        // grid resolution / extent
    float target_limit;         // learning targets saturate here, W/(m^2 sr)
    vec3 environment;           // radiance of the constant environment
    uint seed;
    uvec2 window_offset;        // of the rendered window within the film
    uvec2 window_size;
    float focus_distance;       // of a thin lens: depth at which it is sharp
    uint reserved;
};

struct Material {
    vec3 reflectance;
    uint kind_and_sides;  // BSDF_*, bit 8: two-sided
};

struct Emitter {
    vec3 radiance;
    float reserved;
};

layout(scalar, set = 0, binding = 0) restrict buffer FilmRadiancePage { FilmRadiance film_radiance[]; };
layout(scalar, set = 0, binding = 1) restrict buffer FilmFeaturesPage { FilmFeatures film_features[]; };
layout(scalar, set = 0, binding = 2) uniform Scene { SceneConstants scene_constants; };
#ifdef TEXEL_READS
layout(set = 0, binding = 3) uniform usamplerBuffer materials;
layout(set = 0, binding = 4) uniform usamplerBuffer emitters;
#else
layout(scalar, set = 0, binding = 3) restrict readonly buffer Materials { Material materials[]; };
layout(scalar, set = 0, binding = 4) restrict readonly buffer Emitters { Emitter emitters[]; };
#endif
layout(scalar, set = 0, binding = 5) restrict buffer Counters { uint counters[]; };

SceneConstants scene() {
    return scene_constants;
}

#ifdef TEXEL_READS
Material material(uint index) {
    uvec4 t = texelFetch(materials, int(index));
    return Material(uintBitsToFloat(t.xyz), t.w);
}

vec3 emitter_radiance(uint index) {
    return uintBitsToFloat(texelFetch(emitters, int(index)).xyz);
}
#else
Material material(uint index) {
    return materials[index];
}

vec3 emitter_radiance(uint index) {
    return emitters[index].radiance;
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
