// Camera rays, and importance sampling of the reconstruction filter (Ernst et al. 2006).
#ifndef CAMERA_GLSL
#define CAMERA_GLSL
#include "math/direction.glsl"
#include "math/equal_area.glsl"
#include "film/frame.glsl"
#include "geometry/intersect.glsl"

// Inverse of the cumulative distribution of the tent on [-1, 1].
float sample_tent(float u) {
    return u < 0.5 ? sqrt(2.0 * u) - 1.0 : 1.0 - sqrt(2.0 - 2.0 * u);
}

// Gaussian sample with unit standard deviation, cut off at a distance of 4.
vec2 sample_gaussian(vec2 u) {
    const float inside = 1.0 - exp(-8.0);
    float radius = sqrt(-2.0 * log(1.0 - inside * u.x));
    return radius * sin_cos_turn(u.y).yx;
}

// Position of a sample relative to the pixel's corner, in pixels, distributed by the reconstruction filter.
vec2 sample_filter(vec2 u) {
    if (FILTER == FILTER_TENT) return 0.5 + FILTER_WIDTH * vec2(sample_tent(u.x), sample_tent(u.y));
    if (FILTER == FILTER_GAUSSIAN) return 0.5 + FILTER_WIDTH * sample_gaussian(u);
    return u;
}

// Rows of the camera's matrix, which may depend on the path's time.
vec4[3] camera_rows();

vec3 camera_position() {
    vec4 rows[3] = camera_rows();
    return vec3(rows[0].w, rows[1].w, rows[2].w);
}

vec3 world_from_camera(vec3 direction) {
    vec4 rows[3] = camera_rows();
    return vec3(dot(rows[0].xyz, direction), dot(rows[1].xyz, direction), dot(rows[2].xyz, direction));
}

// Whether the camera sees all around.
bool is_panorama() {
    if (CAMERA == CAMERA_EQUIRECTANGULAR) return true;
    return CAMERA == CAMERA_EQUAL_AREA;
}

// Direction in camera space that a panorama shows at a place, in film widths and heights from the top left. The equal-area map is pbrt's:
// its square has the direction up in the middle.
vec3 panorama_direction(vec2 at) {
    if (CAMERA == CAMERA_EQUAL_AREA) {
        vec3 d = square_to_sphere(2.0 * at - 1.0);
        return vec3(-d.x, d.z, d.y);
    }
    vec2 angles = scene().principal_point + at * scene().raster_scale;
    vec2 longitude = sin_cos_turn(angles.x);
    vec2 latitude = sin_cos_turn(angles.y);
    return vec3(-longitude.x * latitude.y, latitude.x, longitude.y * latitude.y);
}

// Camera ray through `position`, in film pixels from the top left. `u` draws a point of the lens. In camera space, x
// points to the left of the picture.
Ray camera_ray(vec2 position, vec2 u) {
    if (is_panorama()) {
        vec3 direction = normalize(world_from_camera(panorama_direction(position / scene().film_size)));
        return Ray(camera_position() + scene().near_clip * direction, direction, scene().far_clip - scene().near_clip);
    }
    vec2 screen = (1.0 - 2.0 * (position / scene().film_size + scene().principal_point)) * scene().raster_scale;
    float near = scene().near_clip;
    float range = scene().far_clip - near;
    if (CAMERA == CAMERA_ORTHOGRAPHIC) {
        vec3 direction = normalize(world_from_camera(vec3(0.0, 0.0, 1.0)));
        return Ray(camera_position() + world_from_camera(vec3(screen, near)), direction, range);
    }
    vec3 local = vec3(screen, 1.0);
    vec3 lens = vec3(0.0);
    if (CAMERA == CAMERA_THINLENS) {
        lens.xy = scene().aperture_radius * concentric_disk(u);
        local.xy -= lens.xy / scene().focus_distance;
    }
    float per_depth = length(local);
    vec3 direction = normalize(world_from_camera(local / per_depth));
    vec3 origin = camera_position() + world_from_camera(lens);
    return Ray(origin + near * per_depth * direction, direction, range * per_depth);
}

#endif
