// Sizes of the film's tiles and of what a wave keeps.
#ifndef SHARED_FILM_GLSL
#define SHARED_FILM_GLSL

// Pixels along a side of a tile.
const uint TILE_SIDE = 8u;
// Pixels of a tile.
const uint TILE_PIXELS = 64u;
// Binary digits of a pixel's coordinate.
const uint PIXEL_DIGITS = 16u;

// Word-quadruples of a slot of a wave: all of its path, of its connection to a light, and of its hits.
const uint SLOT_QUADRUPLES = 12u;
// Queues of a wave: two of paths, for even and odd edges, and one of connections.
const uint QUEUE_COUNT = 3u;

#endif
