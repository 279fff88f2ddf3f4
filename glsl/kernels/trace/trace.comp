// Traces the paths of a step and learns from them: each lane takes `sample_count` samples of one pixel of a slice. A lane
// starts its next path as soon as the last one has ended, so that no lane waits for another's path.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef RAY_QUERIES
#extension GL_EXT_ray_query : require
#endif
#include "film/slice.glsl"
#include "path/edge.glsl"
#include "path/passage.glsl"
#include "path/vertex.glsl"

layout(push_constant, scalar) uniform Push { TracePush push; };

vec3 direct_light(
    Path path, Surface surface, Scatterer scatterer, Guide guide, out LightEvidence evidence, inout Tally tally) {
    Connection connection = connect(path, surface, scatterer, guide);
    evidence = connection.evidence;
    if (!brings_light(connection)) return vec3(0.0);
    ++tally.shadow_rays;
    if (weakens_light()) {
        uint medium = NO_MEDIUM;
        if (has_media()) medium = medium_beyond(surface, connection.ray.direction, path.medium);
        pass_connection(connection, medium, path.key, path.depth, tally.overrun);
        evidence = connection.evidence;
        return connection.light;
    }
    Hit blocker = traverse(connection.ray, true, tally.overrun);
    return blocker.primitive == NONE ? connection.light : vec3(0.0);
}

void main() {
    uint index = pixel_of_slice(push, gl_WorkGroupID.x, gl_LocalInvocationIndex);
    uvec2 pixel = tile_order_pixel(push.page_first_pixel + index);
    bool inside = all(lessThan(pixel, scene().window_size));
    uvec2 film_pixel = scene().window_offset + pixel;

    PixelSamples samples = no_samples();
    Tally tally = no_tally();
    Path path;
    end_path(path);
    uint kept_count = 0u;
    uint next_sample = inside ? 0u : push.sample_count;
    bool more = next_sample < push.sample_count;
    uint edges_left = push.sample_count * MAX_DEPTH;
    // Every iteration is one edge of a path.
    while (more && edges_left > 0u) {
        --edges_left;

        // 1. Camera: the next sample's path begins where none is under way.
        if (path.depth == 0u) {
            uint sample_index = push.first_sample + next_sample++;
            path = start_path(film_pixel, key_of_sample(film_pixel, sample_index, push.first_of_sets));
        }

        // 2. Ray: what it hits, and the segment that it has travelled.
        turn_disks_to(path);
        Hit hit = end_of_edge(flight_ray(path), comes_from_camera(path), tally.overrun);
        if (has_volumes()) fly_to_particle(path, hit);
        Segment travelled = path.segment;
        ShareEvidence evidence = path.evidence;
        path.last_vertex.segment = travelled;
        if (has_gone_through(path)) path.last_vertex.segment = NO_SEGMENT;

        // 3. Vertex: emission, emitter sampling, the next direction, the learning target, roulette.
        uvec4 bits = random_bits(path.key, path.depth, RANDOM_SCATTER);
        FirstHit first_hit = NO_FIRST_HIT;
        float target = shade_vertex(path, hit, unit_floats(bits), first_hit, tally);
        if (first_hit.known) add_first_hit(samples, first_hit.features);

        // 4. Learning: at once from the target, or from all kept vertices when the path has ended.
        if (keeps_vertices()) {
            kept_count = keep_vertex(kept_count, path.last_vertex);
            if (path.depth == 0u) {
                tally.nonfinite += record_returns(kept_count, path.key);
                kept_count = 0u;
            }
        } else {
            learn(travelled, evidence, target, leftover_float(bits), tally);
        }

        // 5. Film: a path that has ended is one sample of its pixel.
        if (path.depth == 0u) add_sample(samples, path.key.sample_index, path.radiance, tally);
        more = path.depth != 0u || next_sample < push.sample_count;
        if (!more || edges_left == 0u) break;
    }
    tally.overrun = tally.overrun || more;

    if (inside) merge_into_film(index, samples, push.weights);
    publish_tally(tally);
}
