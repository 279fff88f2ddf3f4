// Emitter sampling at the ends of a wave's rays: connects each queued path to a light, and queues the connections whose shadow
// rays are to be traced.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "path/connection.glsl"
#include "path/interaction.glsl"
#include "path/wavefront.glsl"

void connect_path(uint slot) {
    Hit hit = load_hit(slot);
    if (push.edge + 1u == MAX_DEPTH) return;
    if (!has_media() && hit.primitive == NONE) return;
    Path path = load_path_with_disks(slot);
    if (meets_nothing(path, hit)) return;
    Surface surface = place_of_hit(path, hit);
    Scatterer scatterer = scatterer_of_place(path, surface);
    Connection connection = connect(path, surface, scatterer, guide_at(scatterer));
    store_connection(slot, connection);
    if (brings_light(connection)) enqueue_connection(slot);
}

void main() {
    uint place = gl_GlobalInvocationID.x;
    while (place < queue_length()) {
        uint slot = queued_slot(place);
        if (slot != NONE) connect_path(slot);
        place += lane_count();
        if (place >= queue_length()) break;
    }
    count(COUNTER_OVERRUNS, uint(place < queue_length()));
}
