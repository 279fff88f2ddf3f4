// What a path that learns keeps of its vertices.
#ifndef PATH_VERTEX_GLSL
#define PATH_VERTEX_GLSL
#include "shared/enums.glsl"

// The segment from x towards the next vertex y: the bin L(x, w) that y's target will go to; NONE where x is the eye.
struct Segment {
    uint index;
    float scale;  // of targets: 1, or one over the density of w, where what is learned is flux
};

const Segment NO_SEGMENT = Segment(NONE, 1.0);

// What a vertex adds to the radiance of the segment that leads there: its own light, and `factor` times the next segment's.
struct PathVertex {
    Segment segment;
    vec3 light;
    vec3 factor;
};

const PathVertex NO_VERTEX = PathVertex(NO_SEGMENT, vec3(0.0), vec3(0.0));

#endif
