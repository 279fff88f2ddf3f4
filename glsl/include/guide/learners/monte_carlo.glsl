// Learner monte-carlo: the target of a segment is the radiance that the rest of its path has collected. The vertices of
// a path are kept until the path ends.
#ifndef MONTE_CARLO_GLSL
#define MONTE_CARLO_GLSL
#include "random/random.glsl"
#include "guide/learners/segment.glsl"

// Vertices of the current path, in order. They are a global variable because a parameter would be copied.
PathVertex kept_vertices[KEPT_VERTICES];

// Keeps a vertex after the first `count`. Returns the new number of vertices. Where no place is left, the last kept vertex
// takes in the light of the next ones: all kept vertices then still have exact targets.
uint keep_vertex(uint count, PathVertex vertex) {
    if (count == KEPT_VERTICES) {
        PathVertex last = kept_vertices[KEPT_VERTICES - 1u];
        kept_vertices[KEPT_VERTICES - 1u] = PathVertex(last.segment, last.light + last.factor * vertex.light, last.factor * vertex.factor);
        return count;
    }
    kept_vertices[count] = vertex;
    return count + 1u;
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
