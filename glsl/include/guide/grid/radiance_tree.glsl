// Computes, from a cell's radiance, the tree that product.glsl descends, and the tree's first level for a normal.
#ifndef RADIANCE_TREE_GLSL
#define RADIANCE_TREE_GLSL
#include "guide/normalization/normalization_grid.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "math/small_floats.glsl"
#include "guide/samplers/tree.glsl"

// Index of the i-th bin in a square of bins that is `side` bins wide and starts at `corner`.
uint bin_of_square(uvec2 corner, uint side, uint i) {
    uvec2 at = corner + uvec2(i % side, i / side);
    return at.y * DIRECTION_RESOLUTION + at.x;
}

float sum_of_radiance(uint cell, uvec2 corner, uint side) {
    float sum = 0.0;
    for (uint i = 0u; i < side * side; ++i) sum += radiance(radiance_index(cell, bin_of_square(corner, side, i)));
    return sum;
}

// Sum over a square of bins of radiance times the integral of the clamped cosine.
float sum_of_products(uint cell, uint normal_bin, uvec2 corner, uint side) {
    float sum = 0.0;
    for (uint i = 0u; i < side * side; ++i) {
        uint bin = bin_of_square(corner, side, i);
        sum += radiance(radiance_index(cell, bin)) * cosine_integral(bin, normal_bin).integral;
    }
    return sum;
}

// Radiance of the parts of a node. There are parts_per_side^2 parts, each `side` bins wide.
mat4 radiance_of_parts(uint cell, uvec2 corner, uint parts_per_side, uint side) {
    mat4 weights = mat4(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    for (uint i = 0u; i < parts_per_side * parts_per_side; ++i) {
        uvec2 part = uvec2(i % parts_per_side, i / parts_per_side);
        weights[part.y][part.x] = sum_of_radiance(cell, corner + part * side, side);
    }
    return weights;
}

// Computes and stores one node of a cell's tree.
void store_tree_node(uint cell, uint node) {
    bool middle = node < middle_node_count();
    uint index = middle ? node : node - middle_node_count();
    uint row = middle ? 4u : last_level_side();
    uvec2 at = uvec2(index % row, index / row);
    mat4 weights = middle ? radiance_of_parts(cell, at * middle_parts() * 4u, middle_parts(), 4u)
                          : radiance_of_parts(cell, at * 4u, 4u, 1u);
    store_radiance_node(cell * nodes_per_tree() + node, pack_weights_8(weights));
}

// First level of the tree for a normal bin, packed with the irradiance E(cell, normal bin).
uvec4 product_record(uint cell, uint normal_bin) {
    uint side = DIRECTION_RESOLUTION / 4u;
    mat4 products = mat4(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    float irradiance = 0.0;
    for (uint block = 0u; block < 16u; ++block) {
        uvec2 at = uvec2(block % 4u, block / 4u);
        float product = sum_of_products(cell, normal_bin, at * side, side);
        products[at.y][at.x] = product;
        irradiance += product;
    }
    return pack_weights_7(products, irradiance);
}

#endif
