// The state of a path under way.
#ifndef PATH_GLSL
#define PATH_GLSL
#include "film/camera.glsl"
#include "path/guiding.glsl"
#include "path/medium.glsl"
#include "path/straight.glsl"
#include "path/learning.glsl"
#include "geometry/motion.glsl"
#include "geometry/surface.glsl"
#include "shared/film.glsl"
#include "shared/kept.glsl"

struct Path {
    RandomKey key;
    KEPT(ray) Ray ray;
    KEPT(ray) vec3 throughput;
    KEPT(ray) float eta;         // index of refraction of the medium that the ray travels in, over the camera's
    KEPT(light) vec3 radiance;
    KEPT(light) uint pixel;      // of the film: x | y << PIXEL_DIGITS
    uint depth;                  // edges so far, the ray's own included; 0: no path is under way
    KEPT(guide) Segment segment;  // that the ray travels
    KEPT(guide) float pdf;       // density of the ray's direction where it was drawn; 0 where emitter sampling cannot have drawn it
    KEPT(guide) float pixel_estimate;  // radiance of the whole path, as estimated at the first vertex whose guide knows; 0 before
    KEPT(guide) vec3 previous_position;  // of the last surface that has scattered the path; of the camera for facing disks
    // Surfaces through which the path has gone straight on since then, or since the camera; the mean share of light that they, and media
    // on the way, let through, and the mean radiance that they add to the segment.
    KEPT(way) uint straight;
    KEPT(way) float straight_share;
    KEPT(way) float straight_light;
    KEPT(guide) ShareEvidence evidence;  // of the ray's direction
    KEPT(way) uint medium;   // number of the medium that the ray travels in
    KEPT(bend) uint refractions;  // of the path since then, through surfaces that refract connections, too
    KEPT(bend) vec3 setting_out;  // direction in which the path has left the last surface that has scattered it
    vec3 flown;  // weight of the ray's flight through a grid, albedo excluded
    PathVertex last_vertex;  // for learners that keep vertices
};

// Random numbers of a pixel's sample. The set that the sample is part of does not begin before the sample `first_of_sets`.
RandomKey key_of_sample(uvec2 film_pixel, uint sample_index, uint first_of_sets) {
    uint first_of_set = max(sample_index - sample_index % SET_SIZE, first_of_sets);
    return random_key(film_pixel, uint(scene().film_size.x), sample_index, first_of_set, scene().seed);
}

vec4[3] camera_rows() {
    vec4 rows[3] = scene().world_from_camera;
    if (CAMERA_SEGMENTS != 0u) {
        Pose pose = pose_at_moment(scene().camera_motion, CAMERA_SEGMENTS, CAMERA_SEGMENTS);
        mat3 turned = transpose(pose.matrix);
        rows[0] = vec4(turned[0], pose.origin.x);
        rows[1] = vec4(turned[1], pose.origin.y);
        rows[2] = vec4(turned[2], pose.origin.z);
    }
    return rows;
}

uvec2 pixel_of(Path path) {
    return uvec2(path.pixel & ((1u << PIXEL_DIGITS) - 1u), path.pixel >> PIXEL_DIGITS);
}

// A path that no surface has let through since it was scattered.
void forget_straight(inout Path path) {
    path.straight = 0u;
    path.straight_share = 1.0;
    path.straight_light = 0.0;
    path.refractions = 0u;
}

// Whether a surface has let the path through since it was scattered.
bool has_gone_through(Path path) {
    if (bends_light()) return path.straight != 0u || path.refractions != 0u;
    return lets_through() && path.straight != 0u;
}

// A path before its first edge. The caller sets its ray and its pixel.
Path new_path(RandomKey key) {
    Path path;
    path.key = key;
    path.ray = Ray(vec3(0.0), vec3(0.0), 0.0);
    path.pixel = 0u;
    path.throughput = vec3(1.0);
    path.radiance = vec3(0.0);
    path.eta = 1.0;
    path.depth = 1u;
    path.segment = NO_SEGMENT;
    path.evidence = NO_EVIDENCE;
    path.previous_position = vec3(0.0);
    path.pdf = 0.0;
    path.setting_out = vec3(0.0);
    path.medium = NO_MEDIUM;
    path.flown = vec3(1.0);
    path.pixel_estimate = 0.0;
    path.last_vertex = NO_VERTEX;
    forget_straight(path);
    return path;
}

Path start_path(uvec2 film_pixel, RandomKey key) {
    set_moment(key);
    Path path = new_path(key);
    path.pixel = film_pixel.x | (film_pixel.y << PIXEL_DIGITS);
    if (has_media()) path.medium = scene().camera_medium;
    vec4 u = unit_floats(camera_bits(key));
    path.ray = camera_ray(vec2(film_pixel) + sample_filter(u.xy), u.zw);
    if (HAS_FACING_DISKS) path.previous_position = path.ray.origin;
    return path;
}

// Whether the path's ray comes straight from the camera.
bool comes_from_camera(Path path) {
    if (lets_through()) return path.depth == path.straight + 1u;
    return path.depth == 1u;
}

// Turns facing disks to where the path's ray comes from.
void turn_disks_to(Path path) {
    turn_disks(path.previous_position, comes_from_camera(path));
}

// The first surface that has scattered a path. Holes and thin sheets of glass let the path go straight on to it.
struct FirstHit {
    KEPT(first_hit) bool known;  // there is one
    KEPT(first_hit) FilmFeatures features;
};

const FirstHit NO_FIRST_HIT = FirstHit(false, NO_FEATURES);

#endif
