// The cells of the grids: which one a point belongs to, and the larger ones that a cell is part of. What src/encode/cells.rs writes.
#ifndef CELLS_GLSL
#define CELLS_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"

// A place of the regular grid that holds no surface stands for a neighbor's cell.
const uint CELL_BORROWED = 0x80000000u;

uint place_count() {
    return scene().grid_size.x * scene().grid_size.y * scene().grid_size.z;
}

// Where the point is on the grid, in cells.
vec3 grid_coordinates(vec3 position) {
    return (position - scene().bounds_min) * scene().cells_per_unit;
}

// The cell at a place of the grid, with CELL_BORROWED where it is a neighbor's.
uint cell_at_place(vec3 coordinates) {
    uvec3 place = uvec3(clamp(coordinates, vec3(0.0), vec3(scene().grid_size) - 0.5));
    return cell_word((place.z * scene().grid_size.y + place.y) * scene().grid_size.x + place.x);
}

// Cell of a point of a surface, which is first moved along the surface by up to half a cell, as `u` in [0, 1)^3 says. One cell
// holds for all that a path does at a vertex: densities and samples depend on it alike.
uint grid_cell(vec3 position, vec3 normal, vec3 u) {
    vec3 coordinates = grid_coordinates(position);
    uint cell = cell_at_place(coordinates);
    if (JITTER > 0.0) {
        vec3 offset = (u - 0.5) * JITTER / scene().cells_per_unit;
        offset -= normal * dot(offset, normal);
        uint moved = cell_at_place(coordinates + offset * scene().cells_per_unit);
        if ((moved & CELL_BORROWED) == 0u) cell = moved;
    }
    return cell & ~CELL_BORROWED;
}

// The cell that a cell is part of; NONE where it is all of the scene.
uint parent_cell(uint cell) {
    return cell_word(place_count() + cell);
}

// Whether a cell is a larger one.
bool is_parent(uint cell) {
    return cell >= scene().cell_count;
}

// A parent's cells are those from here on, up to the next parent's first.
uint first_child(uint parent) {
    return cell_word(place_count() + scene().all_cell_count + parent - scene().cell_count);
}

#endif
