// Sizes of the film's tiles, of a wave's slots and of a wave's queues.
#ifndef SHARED_FILM_GLSL
#define SHARED_FILM_GLSL

// Side of a tile, in pixels.
const uint TILE_SIDE = 8u;
// Number of pixels in a tile.
const uint TILE_PIXELS = 64u;
// Number of binary digits of a pixel coordinate.
const uint PIXEL_DIGITS = 16u;

// Size of a wave's slot, in groups of four words. A slot holds one path, its connection to a light, and its hits.
const uint SLOT_QUADRUPLES = 12u;
// Number of queues of a wave: two queues of paths, for even and odd edges, and one queue of connections.
const uint QUEUE_COUNT = 3u;

#endif
