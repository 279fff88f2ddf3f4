// Ends a wave: adds its paths to the film. A pixel's paths are added in the order of their samples, so that the bits of the
// picture do not depend on how paths were traced.
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
        FirstHit first_hit = load_first_hit(slot);
        if (first_hit.known) add_first_hit(samples, first_hit.features);
        add_sample(samples, push.slice.first_sample + offset, load_radiance(slot), tally);
        --left;
    }
    if (inside) merge_into_film(page_pixel(within), samples, push.slice.weights);
    publish_tally(tally);
}
