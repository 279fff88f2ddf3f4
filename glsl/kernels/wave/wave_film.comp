// Ends a wave: adds its paths to the film, those of a pixel in the order of their samples.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "film/tally.glsl"
#include "path/wavefront.glsl"

void main() {
    uint within = gl_GlobalInvocationID.x;
    PixelSamples samples = no_samples();
    Tally tally = no_tally();
    bool inside = within < pixel_count() && is_inside(window_pixel(within));
    uint left = inside ? push.slice.sample_count : 0u;
    while (left > 0u) {
        uint offset = push.slice.sample_count - left;
        uint slot = slot_of(within, offset);
        FirstHit first = load_first_hit(slot);
        if (first.known) add_first_hit(samples, first.albedo, first.normal, first.depth);
        add_sample(samples, push.slice.first_sample + offset, load_path_radiance(slot), tally);
        --left;
    }
    if (inside) merge_into_film(page_pixel(within), samples, push.slice.weights);
    publish_tally(tally);
}
