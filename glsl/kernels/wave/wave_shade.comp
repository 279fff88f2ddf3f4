// Shades the ends of a wave's rays (vertex.glsl) and learns from them. Paths end, or are queued for the next edge.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "path/vertex.glsl"
#include "path/wavefront.glsl"

uint shaded_slot;

// Loads the light that wave_connect and wave_shadow have found.
vec3 direct_light(
    Path path, Surface surface, Scatterer scatterer, Guide guide, out LightEvidence evidence, inout Tally tally) {
    Connection connection = load_connected_light(shaded_slot);
    evidence = connection.evidence;
    return connection.light;
}

void shade(uint slot, inout Tally tally) {
    shaded_slot = slot;
    Path path = load_path_with_disks(slot);
    if (has_volumes()) path.flown = load_flown(slot);
    Segment travelled = path.segment;
    ShareEvidence evidence = path.evidence;
    uvec4 bits = random_bits(path.key, path.depth, RANDOM_SCATTER);
    FirstHit first_hit = NO_FIRST_HIT;
    float target = shade_vertex(path, load_hit(slot), unit_floats(bits), first_hit, tally);
    bool scatters_first = lets_through() && first_hit.known;
    if (push.edge == 0u || scatters_first) store_first_hit(slot, first_hit);
    learn(travelled, evidence, target, leftover_float(bits), tally);
    store_path(slot, path);
    if (path.depth != 0u) enqueue_path(slot);
}

void main() {
    Tally tally = no_tally();
    uint place = gl_GlobalInvocationID.x;
    while (place < queue_length()) {
        uint slot = queued_slot(place);
        if (slot != NONE) shade(slot, tally);
        place += lane_count();
        if (place >= queue_length()) break;
    }
    tally.overrun = tally.overrun || place < queue_length();
    publish_tally(tally);
}
