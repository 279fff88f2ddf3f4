// A wave: the paths of a slice's samples, all under way at once, edge by edge. Each has a slot; queues hold the slots of those
// that go on. The only file that says where in the scratch memory and the counters they are.
#ifndef WAVEFRONT_GLSL
#define WAVEFRONT_GLSL
#include "path.glsl"
#include "slice.glsl"

struct WavePush {
    PathTracePush slice;
    uint edge;  // that the paths travel: 0 from the camera
};
layout(push_constant, scalar) uniform Push { WavePush push; };

// Word-quadruples of a slot: from 0 on the path's state, its radiance among it, then what its ray has hit and what its camera
// ray has hit. Those of one kind lie side by side, so that neighboring lanes read neighboring memory.
const uint RADIANCE_AT = 3u;
const uint HIT_AT = 6u;
const uint FIRST_HIT_AT = 7u;
const uint SLOT_QUADRUPLES = 9u;

uint pixel_count() {
    return push.slice.workgroup_count * WORKGROUP_SIZE;
}

uint slot_count() {
    return pixel_count() * push.slice.sample_count;
}

uint slot_of(uint pixel, uint sample_offset) {
    return sample_offset * pixel_count() + pixel;
}

// The page's pixel, in tile order, of a slot.
uint page_pixel(uint slot) {
    uint pixel = slot % pixel_count();
    return pixel_of_slice(push.slice, pixel / WORKGROUP_SIZE, pixel % WORKGROUP_SIZE);
}

uvec2 window_pixel(uint slot) {
    return tile_order_pixel(push.slice.page_first_pixel + page_pixel(slot));
}

bool is_inside(uvec2 pixel) {
    return all(lessThan(pixel, scene().window_size));
}

uvec2 film_pixel_of(uint slot) {
    return scene().window_offset + window_pixel(slot);
}

RandomKey key_of_slot(uint slot) {
    uint sample_index = push.slice.first_sample + slot / pixel_count();
    return key_of_sample(film_pixel_of(slot), sample_index, push.slice.first_of_sets);
}

uvec4 load_slot(uint slot, uint quadruple) {
    return load_scratch(quadruple * slot_count() + slot);
}

void store_slot(uint slot, uint quadruple, uvec4 value) {
    store_scratch(quadruple * slot_count() + slot, value);
}

// Queues of even and odd edges take turns.
uint queue_at(uint edge) {
    return 4u * SLOT_QUADRUPLES * slot_count() + (edge % 2u) * slot_count();
}

// Paths that travel this edge.
uint queue_length() {
    return push.edge == 0u ? slot_count() : counted(COUNTER_COUNT + push.edge);
}

// The slot at a place of the queue; NONE where that is a pixel beyond the picture's border.
uint queued_slot(uint place) {
    if (push.edge != 0u) return load_scratch_word(queue_at(push.edge) + place);
    return is_inside(window_pixel(place)) ? place : NONE;
}

// Has a path travel the next edge. One lane reserves places for all of its subgroup that go on together.
void enqueue(uint slot) {
    uvec4 together = subgroupBallot(true);
    uint first = 0u;
    if (subgroupElect()) first = reserve(COUNTER_COUNT + push.edge + 1u, subgroupBallotBitCount(together));
    uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(together);
    store_scratch_word(queue_at(push.edge + 1u) + place, slot);
}

uint lane_count() {
    return gl_NumWorkGroups.x * WORKGROUP_SIZE;
}

void store_hit(uint slot, Hit hit) {
    store_slot(slot, HIT_AT, uvec4(floatBitsToUint(vec3(hit.t, hit.uv)), hit.primitive));
}

Hit load_hit(uint slot) {
    uvec4 hit = load_slot(slot, HIT_AT);
    return Hit(uintBitsToFloat(hit.x), uintBitsToFloat(hit.yz), hit.w);
}

void store_first_hit(uint slot, FirstHit first) {
    store_slot(slot, FIRST_HIT_AT, floatBitsToUint(vec4(first.albedo, first.depth)));
    store_slot(slot, FIRST_HIT_AT + 1u, uvec4(floatBitsToUint(first.normal), uint(first.known)));
}

FirstHit load_first_hit(uint slot) {
    vec4 albedo = uintBitsToFloat(load_slot(slot, FIRST_HIT_AT));
    uvec4 normal = load_slot(slot, FIRST_HIT_AT + 1u);
    return FirstHit(normal.w != 0u, albedo.xyz, uintBitsToFloat(normal.xyz), albedo.w);
}

// The ray that a path travels now.
Ray load_ray(uint slot) {
    if (push.edge == 0u) return start_path(film_pixel_of(slot), key_of_slot(slot)).ray;
    vec4 origin = uintBitsToFloat(load_slot(slot, 0u));
    return Ray(origin.xyz, uintBitsToFloat(load_slot(slot, 1u)).xyz, origin.w);
}

vec3 load_path_radiance(uint slot) {
    return uintBitsToFloat(load_slot(slot, RADIANCE_AT).xyz);
}

// Whether a path has more to remember than its ray, its throughput and its radiance.
bool keeps_origin() {
    if (NEE) return true;
    return SAMPLER != SAMPLER_BSDF;
}

// What the next edges need of a path, or only its radiance where it has ended.
void store_path(uint slot, Path path) {
    store_slot(slot, RADIANCE_AT, uvec4(floatBitsToUint(path.radiance), floatBitsToUint(path.segment.scale)));
    if (path.depth == 0u) return;
    store_slot(slot, 0u, uvec4(floatBitsToUint(path.ray.origin), floatBitsToUint(path.ray.t_max)));
    store_slot(slot, 1u, uvec4(floatBitsToUint(path.ray.direction), floatBitsToUint(path.evidence.of_guide)));
    store_slot(slot, 2u, uvec4(floatBitsToUint(path.throughput), floatBitsToUint(path.eta)));
    if (keeps_origin()) {
        vec2 floats = vec2(path.pdf, path.expected_of_pixel);
        store_slot(slot, 4u, uvec4(path.segment.index, floatBitsToUint(floats), path.evidence.share));
        store_slot(slot, 5u, uvec4(floatBitsToUint(path.from), floatBitsToUint(path.evidence.scattered)));
    }
}

Path load_path(uint slot) {
    if (push.edge == 0u) return start_path(film_pixel_of(slot), key_of_slot(slot));
    Path path = new_path(key_of_slot(slot));
    vec4 throughput = uintBitsToFloat(load_slot(slot, 2u));
    vec4 radiance = uintBitsToFloat(load_slot(slot, RADIANCE_AT));
    path.ray = load_ray(slot);
    path.throughput = throughput.xyz;
    path.eta = throughput.w;
    path.radiance = radiance.xyz;
    path.depth = push.edge + 1u;
    if (keeps_origin()) {
        uvec4 segment = load_slot(slot, 4u);
        vec4 from = uintBitsToFloat(load_slot(slot, 5u));
        float of_guide = uintBitsToFloat(load_slot(slot, 1u).w);
        path.segment = Segment(segment.x, radiance.w);
        path.pdf = uintBitsToFloat(segment.y);
        path.expected_of_pixel = uintBitsToFloat(segment.z);
        path.evidence = ShareEvidence(segment.w, from.w, of_guide);
        path.from = from.xyz;
    }
    return path;
}

#endif
