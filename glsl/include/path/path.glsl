// A path.
#ifndef PATH_GLSL
#define PATH_GLSL
#include "film/camera.glsl"
#include "path/guiding.glsl"
#include "guide/learners/learning.glsl"
#include "geometry/surface.glsl"

struct Path {
    RandomKey key;
    Ray ray;
    vec3 throughput;
    vec3 radiance;
    float eta;        // index of refraction of the medium that the ray travels over the camera's
    uint depth;       // edges so far, the ray's own included; 0: no path is under way
    Segment segment;  // that the ray travels
    ShareEvidence evidence;  // of its direction
    vec3 from;        // the point of a surface that the ray left
    float pdf;        // density of its direction there; 0 where emitter sampling cannot have drawn it
    float expected_of_pixel;  // what the path had brought and was expected to bring at the first surface that told; 0 before
    PathVertex met;   // the vertex just met, for learners that keep them
};

// Of a sample whose set reaches back no further than to the sample `first_of_sets`.
RandomKey key_of_sample(uvec2 film_pixel, uint sample_index, uint first_of_sets) {
    uint first_of_set = max(sample_index - sample_index % SET_SIZE, first_of_sets);
    return random_key(film_pixel, uint(scene().film_size.x), sample_index, first_of_set, scene().seed);
}

// A path that has met nothing yet, whose ray is still to be set.
Path new_path(RandomKey key) {
    Path path;
    path.key = key;
    path.throughput = vec3(1.0);
    path.radiance = vec3(0.0);
    path.eta = 1.0;
    path.depth = 1u;
    path.segment = NO_SEGMENT;
    path.evidence = NO_EVIDENCE;
    path.from = vec3(0.0);
    path.pdf = 0.0;
    path.expected_of_pixel = 0.0;
    path.met = NO_VERTEX;
    return path;
}

Path start_path(uvec2 film_pixel, RandomKey key) {
    Path path = new_path(key);
    vec4 u = unit_floats(camera_bits(key));
    path.ray = camera_ray(vec2(film_pixel) + sample_filter(u.xy), u.zw);
    return path;
}

// What a camera ray has hit.
struct FirstHit {
    bool known;
    vec3 albedo;
    vec3 normal;
    float depth;
};

const FirstHit NO_FIRST_HIT = FirstHit(false, vec3(0.0), vec3(0.0), 0.0);

#endif
