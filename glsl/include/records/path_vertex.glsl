// Data that a learning path keeps for its vertices.
#ifndef PATH_VERTEX_GLSL
#define PATH_VERTEX_GLSL
#include "shared/enums.glsl"
#include "shared/kept.glsl"

// Segment from x towards the next vertex y: the bin L(x, w) that receives y's target. `index` is NONE where x is the
// camera.
struct Segment {
    uint index;  // index of the bin that receives the target, or NONE
    // Factor of targets: 1, or 1 / (density of w) where the learned quantity is flux. A wave does not keep it: only `quadtree` has
    // others than 1, and it is not traced as waves.
    KEPT(never) float scale;
};

const Segment NO_SEGMENT = Segment(NONE, 1.0);

// Contribution of a vertex to the radiance of the segment that leads to it: its own light, plus `factor` times the
// radiance of the next segment.
struct PathVertex {
    Segment segment;  // segment that leads to the vertex
    vec3 light;       // light that the vertex itself emits or receives from a sampled light
    vec3 factor;      // factor of the next segment's radiance
};

const PathVertex NO_VERTEX = PathVertex(NO_SEGMENT, vec3(0.0), vec3(0.0));

#endif
