// Recording of a segment's target.
#ifndef SEGMENT_GLSL
#define SEGMENT_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "records/path_vertex.glsl"

// Target that stands for "none". A segment that ends at the maximum depth has no target, because its end was not
// followed further.
const float NO_TARGET = -1.0;

// Adds a target to the segment's bin, if there is a target. `u` in [0, 1) rounds it. Returns whether the target was
// dropped because it was NaN or infinite.
bool record(Segment segment, float target, float u) {
    if (segment.index == NONE || target == NO_TARGET) return false;
    target *= segment.scale;
    bool finite = is_finite(target);
    if (finite) add_target(segment.index, fixed_point(target, scene().target_limit, u));
    return !finite;
}

#endif
