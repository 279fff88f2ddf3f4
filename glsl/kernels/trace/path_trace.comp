// One step of rendering and learning: traces `sample_count` paths for every pixel of a slice, adds them to the film, and
// records what they meet in the radiance grid. A lane starts its next path as soon as the last one has ended.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "film/slice.glsl"
#include "geometry/traverse.glsl"
#include "path/vertex.glsl"

layout(push_constant, scalar) uniform Push { PathTracePush push; };

vec3 direct_light(Path path, Surface s, Scatterer x, Guide guide, inout Tally tally) {
    Connection connection = connect(path, s, x, guide);
    if (!brings_light(connection)) return vec3(0.0);
    ++tally.shadow_rays;
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
    while (more && edges_left > 0u) {
        --edges_left;
        if (path.depth == 0u) {
            uint sample_index = push.first_sample + next_sample++;
            path = start_path(film_pixel, key_of_sample(film_pixel, sample_index, push.first_of_sets));
        }

        Hit hit = traverse(path.ray, false, tally.overrun);
        Segment travelled = path.segment;
        ShareEvidence evidence = path.evidence;
        path.met.segment = travelled;
        uvec4 bits = random_bits(path.key, path.depth, RANDOM_SCATTER);
        FirstHit first = NO_FIRST_HIT;
        float target = meet(path, hit, unit_floats(bits), first, tally);
        if (first.known) add_first_hit(samples, first.albedo, first.normal, first.depth);
        if (keeps_vertices()) {
            kept_count = keep_vertex(kept_count, path.met);
            if (path.depth == 0u) {
                tally.nonfinite += record_returns(kept_count, path.key);
                kept_count = 0u;
            }
        } else {
            learn(travelled, evidence, target, leftover_float(bits), tally);
        }

        if (path.depth == 0u) add_sample(samples, path.key.sample_index, path.radiance, tally);
        more = path.depth != 0u || next_sample < push.sample_count;
    }
    tally.overrun = tally.overrun || more;

    if (inside) merge_into_film(index, samples, push.weights);
    publish_tally(tally);
}
