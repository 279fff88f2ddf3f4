// Traces the shadow rays of a wave's queued connections, and removes the light of those that are blocked.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef RAY_QUERIES
#extension GL_EXT_ray_query : require
#endif
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "geometry/traverse.glsl"
#include "path/wavefront.glsl"

void main() {
    bool overrun = false;
    uint place = gl_GlobalInvocationID.x;
    if (place == 0u) count(COUNTER_SHADOW_RAYS, connection_count());
    while (place < connection_count()) {
        uint slot = queued_connection(place);
        if (traverse(load_connection(slot).ray, true, overrun).primitive != NONE) block_connection(slot);
        place += lane_count();
        if (place >= connection_count()) break;
    }
    count(COUNTER_OVERRUNS, uint(overrun || place < connection_count()));
}
