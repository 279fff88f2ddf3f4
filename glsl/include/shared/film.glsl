// Sizes of the film's tiles and of a wave's queues.
#ifndef SHARED_FILM_GLSL
#define SHARED_FILM_GLSL

// Side of a tile, in pixels.
const uint TILE_SIDE = 8u;
// Number of pixels in a tile.
const uint TILE_PIXELS = 64u;
// Number of binary digits of a pixel coordinate.
const uint PIXEL_DIGITS = 16u;

// Number of queues of a wave: two queues of paths, for even and odd edges, and one queue of connections.
const uint QUEUE_COUNT = 3u;

#endif
