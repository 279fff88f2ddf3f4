// Walls of bricks, as Blender has them.
#ifndef BRICKS_GLSL
#define BRICKS_GLSL

struct Bricks {
    float mortar;            // width of the mortar on each side of a brick
    float smoothness;        // share of the mortar over which it begins
    float bias;              // number that is added to each brick's own
    float width;             // of a brick
    float height;            // of a row
    float offset;            // share of a brick by which each `offset_rows`th row is shifted
    float squash;            // factor of the width in all rows but each `squash_rows`th
    int offset_rows;
    int squash_rows;
};

// Number in [0, 1] of a brick.
float brick_number(uint n) {
    n = (n + 1013u) & 0x7fffffffu;
    n ^= n >> 13u;
    n = (n * (n * n * 60493u + 19990303u) + 1376312589u) & 0x7fffffffu;
    return float(n) * (0.5 / 1073741824.0);
}

// The number of the brick at a point, and the share of mortar.
vec2 brick_at(Bricks b, vec2 p) {
    int row = int(floor(p.y / b.height));
    float width = b.width;
    float shift = 0.0;
    if (b.offset_rows != 0 && b.squash_rows != 0) {
        if (row % b.squash_rows == 0) width *= b.squash;
        if (row % b.offset_rows == 0) shift = width * b.offset;
    }
    int column = int(floor((p.x + shift) / width));
    vec2 at = vec2(p.x + shift - width * float(column), p.y - b.height * float(row));
    float number = clamp(brick_number((uint(row) << 16u) + (uint(column) & 0xffffu)) + b.bias, 0.0, 1.0);
    float inside = min(min(at.x, at.y), min(width - at.x, b.height - at.y));
    float mortar = inside >= b.mortar ? 0.0 : 1.0;
    if (inside < b.mortar && b.smoothness != 0.0) {
        float t = clamp((1.0 - inside / b.mortar) / b.smoothness, 0.0, 1.0);
        mortar = t * t * (3.0 - 2.0 * t);
    }
    return vec2(number, mortar);
}

#endif
