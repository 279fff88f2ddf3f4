// Data that a learning path keeps for its vertices.
#ifndef PATH_VERTEX_GLSL
#define PATH_VERTEX_GLSL
#include "shared/enums.glsl"

// Segment from x towards the next vertex y: the bin L(x, w) that receives y's target. `index` is NONE where x is the
// camera.
struct Segment {
    uint index;
    float scale;  // factor of targets: 1, or 1 / (density of w) where the learned quantity is flux
};

const Segment NO_SEGMENT = Segment(NONE, 1.0);

// Contribution of a vertex to the radiance of the segment that leads to it: its own light, plus `factor` times the
// radiance of the next segment.
struct PathVertex {
    Segment segment;
    vec3 light;
    vec3 factor;
};

const PathVertex NO_VERTEX = PathVertex(NO_SEGMENT, vec3(0.0), vec3(0.0));

#endif
