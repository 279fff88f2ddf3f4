// Learner monte-carlo: the target of a segment is the radiance that the rest of its path has collected. All vertices of
// a path are kept until the path ends.
#ifndef MONTE_CARLO_GLSL
#define MONTE_CARLO_GLSL
#include "random/random.glsl"
#include "guide/learners/segment.glsl"

// Vertices of the current path, in order. They are a global variable because a parameter would be copied.
PathVertex kept_vertices[KEPT_VERTICES];

// Keeps a vertex after the first `count`. Returns the new number of vertices.
uint keep_vertex(uint count, PathVertex vertex) {
    uint at = min(count, KEPT_VERTICES - 1u);
    kept_vertices[at] = vertex;
    return at + 1u;
}

// Records the targets of a path that has ended, from its last vertex back. Returns how many targets were NaN or
// infinite.
uint record_returns(uint count, RandomKey key) {
    vec3 collected = vec3(0.0);
    uint dropped = 0u;
    while (count > 0u) {
        --count;
        PathVertex vertex = kept_vertices[count];
        collected = vertex.light + vertex.factor * collected;
        float u = unit_float(random_bits(key, count, RANDOM_LEARNING).x);
        if (record(vertex.segment, mean_rgb(collected), u)) ++dropped;
    }
    return dropped;
}

#endif
