// Traces the rays of a wave's queued paths.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef RAY_QUERIES
#extension GL_EXT_ray_query : require
#endif
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "path/edge.glsl"
#include "path/interaction.glsl"
#include "path/wavefront.glsl"

// The ray of a slot's path, as far as it flies.
Ray ray_of_slot(uint slot) {
    if (has_media()) return flight_ray(load_path_with_disks(slot));
    return load_ray(slot);
}

// Whether the ray that a path travels now comes straight from the camera.
bool slot_comes_from_camera(uint slot) {
    if (hides_shapes()) {
        if (lets_through() && push.edge != 0u) {
            Path path;
            load_path_way(slot, path);
            return path.straight == push.edge;
        }
    }
    return push.edge == 0u;
}

// Traces the ray of a slot's path, and keeps what it meets.
void extend(uint slot, inout bool overrun) {
    Hit hit = end_of_edge(ray_of_slot(slot), slot_comes_from_camera(slot), overrun);
    if (has_volumes()) {
        Path path = load_path(slot);
        fly_to_particle(path, hit);
        keep_flown(slot, path.flown);
    }
    keep_hit(slot, hit);
}

void main() {
    bool overrun = false;
    uint place = gl_GlobalInvocationID.x;
    while (place < queue_length()) {
        uint slot = queued_slot(place);
        if (slot != NONE) extend(slot, overrun);
        place += lane_count();
        if (place >= queue_length()) break;
    }
    count(COUNTER_OVERRUNS, uint(overrun || place < queue_length()));
}
