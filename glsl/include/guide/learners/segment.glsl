// What a segment of a path learns, and where that goes.
#ifndef SEGMENT_GLSL
#define SEGMENT_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "guide/learners/path_vertex.glsl"

// Where a segment ends at the maximum depth nothing is learned: its end was not followed further.
const float NO_TARGET = -1.0;

// Adds a target, if there is one, to the segment's bin; `u` in [0, 1) rounds it. Returns whether it had to be dropped for
// being NaN or infinite.
bool record(Segment segment, float target, float u) {
    if (segment.index == NONE || target == NO_TARGET) return false;
    target *= segment.scale;
    bool finite = is_finite(target);
    if (finite) add_target(segment.index, fixed_point(target, scene().target_limit, u));
    return !finite;
}

#endif
