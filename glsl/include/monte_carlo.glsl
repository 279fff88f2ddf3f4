// Monte-Carlo learning: a segment learns the radiance that the rest of its path has collected. All vertices of a path are kept
// until it ends.
#ifndef MONTE_CARLO_GLSL
#define MONTE_CARLO_GLSL
#include "random.glsl"
#include "segment.glsl"

// What a vertex adds to the radiance of the segment that leads there: its own light, and `factor` times the next segment's.
struct PathVertex {
    Segment segment;
    vec3 light;
    vec3 factor;
};

const PathVertex NO_VERTEX = PathVertex(NO_SEGMENT, vec3(0.0), vec3(0.0));

struct KeptPath {
    PathVertex vertices[KEPT_VERTICES];
    uint vertex_count;
};

void keep_vertex(inout KeptPath kept, PathVertex vertex) {
    if (kept.vertex_count < KEPT_VERTICES) kept.vertices[kept.vertex_count++] = vertex;
}

// Records the returns of a path that has ended, from its last vertex back.
void record_returns(inout KeptPath kept, RandomKey key) {
    vec3 collected = vec3(0.0);
    while (kept.vertex_count > 0u) {
        PathVertex vertex = kept.vertices[--kept.vertex_count];
        collected = vertex.light + ATTENUATION_TAMPER * vertex.factor * collected;
        float u = unit_float(random_bits(key, kept.vertex_count, RANDOM_LEARNING).x);
        record(vertex.segment, mean_rgb(collected), u);
    }
}

#endif
