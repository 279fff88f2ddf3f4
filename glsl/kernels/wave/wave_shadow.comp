// Traces the shadow rays of a wave's queued connections. Light that is blocked is removed, and light that surfaces and media let through is
// multiplied by their share.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef RAY_QUERIES
#extension GL_EXT_ray_query : require
#endif
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "geometry/traverse.glsl"
#include "path/interaction.glsl"
#include "path/passage.glsl"
#include "path/wavefront.glsl"

// Medium in which a slot's connection leaves its path's vertex. Facing disks are turned there.
uint medium_of_connection(uint slot, Path path, vec3 direction) {
    Surface vertex = place_of_hit(path, load_hit(slot));
    turn_disks(vertex.position, false);
    uint medium = NO_MEDIUM;
    if (has_media()) medium = medium_beyond(vertex, direction, path.medium);
    return medium;
}

void trace_shadow_ray(uint slot, inout bool overrun) {
    Connection connection = load_connection(slot);
    set_moment_of_slot(slot);
    if (weakens_light()) {
        uint medium = NO_MEDIUM;
        Path path = new_path(RandomKey(0u, 0u, 0u, 0u, 0u, 0u));
        if (has_media() || HAS_FACING_DISKS) {
            path = load_path_with_disks(slot);
            medium = medium_of_connection(slot, path, connection.ray.direction);
        }
        pass_connection(connection, medium, path.key, push.edge + 1u, overrun);
        store_connection_light(slot, connection);
    } else if (traverse(connection.ray, true, overrun).primitive != NONE) {
        block_connection(slot);
    }
}

void main() {
    bool overrun = false;
    uint place = gl_GlobalInvocationID.x;
    if (place == 0u) count(COUNTER_SHADOW_RAYS, connection_count());
    while (place < connection_count()) {
        uint slot = queued_connection(place);
        trace_shadow_ray(slot, overrun);
        place += lane_count();
        if (place >= connection_count()) break;
    }
    count(COUNTER_OVERRUNS, uint(overrun || place < connection_count()));
}
