// Emitter sampling where the rays of a wave's queue have led: a shadow ray for each path that a light may add to.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "path/connection.glsl"
#include "path/wavefront.glsl"

void connect_path(uint slot) {
    Hit hit = load_hit(slot);
    if (hit.primitive == NONE || push.edge + 1u == MAX_DEPTH) return;
    uvec2 film_pixel;
    Path path = load_path(slot, film_pixel);
    Surface s = surface_at(path.ray, hit);
    Scatterer x = scatterer_at(s, -path.ray.direction, path.key, path.depth);
    Connection connection = connect(path, s, x, guide_at(x));
    store_connection(slot, connection);
    if (brings_light(connection)) enqueue_connection(slot);
}

void main() {
    uint place = gl_GlobalInvocationID.x;
    while (place < queue_length()) {
        uint slot = queued_slot(place);
        if (slot != NONE) connect_path(slot);
        place += lane_count();
    }
    count(COUNTER_OVERRUNS, uint(place < queue_length()));
}
