// Bins of directions and of normals: equal squares of an area-preserving map between [-1, 1]^2 and the sphere. MAP
// selects the map of directions. Normals always use the equal-area square, whose bins are closer to round.
#ifndef DIRECTION_MAP_GLSL
#define DIRECTION_MAP_GLSL
#include "math/cylindrical.glsl"
#include "math/equal_area.glsl"
#include "shared/variant.glsl"

// Unit direction for a point of the map.
vec3 map_to_sphere(vec2 p) {
    return MAP == MAP_CYLINDRICAL ? cylinder_to_sphere(p) : square_to_sphere(p);
}

// Point of the map for a unit direction.
vec2 sphere_to_map(vec3 w) {
    return MAP == MAP_CYLINDRICAL ? sphere_to_cylinder(w) : sphere_to_square(w);
}

// Point of the map for the opposite direction. The function rearranges the map rigidly, so areas are preserved.
vec2 map_antipode(vec2 p) {
    return MAP == MAP_CYLINDRICAL ? cylinder_antipode(p) : antipode(p);
}

// Index of the bin that contains a point, for `resolution` bins per side, row by row.
uint square_bin(vec2 p, uint resolution) {
    uvec2 cell = uvec2(clamp((0.5 * p + 0.5) * float(resolution), vec2(0.0), vec2(float(resolution) - 0.5)));
    return cell.y * resolution + cell.x;
}

// Point of the square at the relative position `within`, in [0, 1)^2, of a bin.
vec2 bin_point(uint bin, uint resolution, vec2 within) {
    vec2 corner = vec2(float(bin % resolution), float(bin / resolution));
    return 2.0 * (corner + within) / float(resolution) - 1.0;
}

uint direction_bin(vec3 w) {
    return square_bin(sphere_to_map(w), DIRECTION_RESOLUTION);
}

// Direction at a bin's center.
vec3 bin_center(uint bin) {
    return map_to_sphere(bin_point(bin, DIRECTION_RESOLUTION, vec2(0.5)));
}

uint direction_bin_count() {
    return DIRECTION_RESOLUTION * DIRECTION_RESOLUTION;
}

// Density of a direction that is uniform within one bin, per steradian.
float bin_density() {
    return float(direction_bin_count()) * (0.5 * INV_TWO_PI);
}

uint normal_bin(vec3 n) {
    return square_bin(sphere_to_square(n), NORMAL_RESOLUTION);
}

// Normal that stands for all normals of the bin.
vec3 representative_normal(uint bin) {
    return square_to_sphere(bin_point(bin, NORMAL_RESOLUTION, vec2(0.5)));
}

#endif
