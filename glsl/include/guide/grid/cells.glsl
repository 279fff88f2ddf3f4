// Cells of the grids: the cell of a point, and the parent cells. src/encode/cells.rs writes the table.
#ifndef CELLS_GLSL
#define CELLS_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"

uint place_count() {
    return scene().grid_size.x * scene().grid_size.y * scene().grid_size.z;
}

// Cell that contains a point of a surface.
uint grid_cell(vec3 position) {
    vec3 coordinates = (position - scene().bounds_min) * scene().cells_per_unit;
    uvec3 place = uvec3(clamp(coordinates, vec3(0.0), vec3(scene().grid_size) - 0.5));
    return cell_word((place.z * scene().grid_size.y + place.y) * scene().grid_size.x + place.x);
}

// Parent of a cell; NONE for the cell that covers the whole scene.
uint parent_cell(uint cell) {
    return cell_word(place_count() + cell);
}

// Whether a cell is a parent cell.
bool is_parent(uint cell) {
    return cell >= scene().cell_count;
}

// First child of a parent cell. The children are consecutive and end before the next parent's first child.
uint first_child(uint parent) {
    return cell_word(place_count() + scene().all_cell_count + parent - scene().cell_count);
}

#endif
