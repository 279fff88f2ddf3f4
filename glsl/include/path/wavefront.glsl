// A wave: the paths of all samples of a slice, which travel edge by edge together. Each path has a slot. Queues hold the slots
// of paths that go on. This file alone knows where slots and queues lie in the scratch memory, and where their counters are.
#ifndef WAVEFRONT_GLSL
#define WAVEFRONT_GLSL
#include "path/connection.glsl"
#include "path/path.glsl"
#include "shared/film.glsl"
#include "film/slice.glsl"

struct WavePush {
    TracePush slice;
    uint edge;  // that the paths travel; 0 begins at the camera
};
layout(push_constant, scalar) uniform Push { WavePush push; };

// A slot's quadruples of words: path state, connection to a light, first hit, and one for the ray's hit. Each kind lies
// together for all slots, in this order.
const uint CONNECTION_QUADRUPLES = 3u;
const uint FIRST_HIT_QUADRUPLES = 2u;
const uint STATE_QUADRUPLES = SLOT_QUADRUPLES - CONNECTION_QUADRUPLES - FIRST_HIT_QUADRUPLES - 1u;
// Quadruple of the state that holds the path's radiance. Before it are ray and throughput, after it what guide and emitter
// sampling need.
const uint RADIANCE = 3u;

// Pixels of the slice.
uint pixel_count() {
    return push.slice.workgroup_count * WORKGROUP_SIZE;
}

uint slot_count() {
    return pixel_count() * push.slice.sample_count;
}

uint slot_of(uint pixel, uint sample_offset) {
    return sample_offset * pixel_count() + pixel;
}

// The slot's pixel of the film page, in tile order.
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

RandomKey key_of_slot(uint slot, uvec2 film_pixel) {
    uint sample_index = push.slice.first_sample + slot / pixel_count();
    return key_of_sample(film_pixel, sample_index, push.slice.first_of_sets);
}

Path path_from_camera(uint slot, uvec2 film_pixel) {
    return start_path(film_pixel, key_of_slot(slot, film_pixel));
}

uvec4 load_state(uint slot, uint quadruple) {
    return load_scratch(slot * STATE_QUADRUPLES + quadruple);
}

void store_state(uint slot, uint quadruple, uvec4 value) {
    store_scratch(slot * STATE_QUADRUPLES + quadruple, value);
}

// Queues: two of paths, for even and odd edges, then one of connections.
const uint CONNECTIONS = QUEUE_COUNT - 1u;

uint queue_at(uint queue) {
    return (4u * SLOT_QUADRUPLES + queue) * slot_count();
}

// The counter of paths that travel an edge.
uint path_counter(uint edge) {
    return 2u * COUNTER_COUNT + edge;
}

// The counter of connections to lights that are made at an edge's end.
uint connection_counter(uint edge) {
    return 2u * COUNTER_COUNT + MAX_DEPTH + edge;
}

// Paths that travel this edge.
uint queue_length() {
    return push.edge == 0u ? slot_count() : counted(path_counter(push.edge));
}

// The slot at a place of the queue of paths; NONE for a pixel beyond the picture's border.
uint queued_slot(uint place) {
    if (push.edge != 0u) return load_scratch_word(queue_at(push.edge % 2u) + place);
    return is_inside(window_pixel(place)) ? place : NONE;
}

// Appends a slot to a queue. One lane reserves places for all lanes of its subgroup that append.
void enqueue(uint queue, uint counter, uint slot) {
    uvec4 together = subgroupBallot(true);
    uint first = 0u;
    if (subgroupElect()) first = reserve(counter, subgroupBallotBitCount(together));
    uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(together);
    store_scratch_word(queue_at(queue) + place, slot);
}

// Queues a path for the next edge.
void enqueue_path(uint slot) {
    enqueue((push.edge + 1u) % 2u, path_counter(push.edge + 1u), slot);
}

void enqueue_connection(uint slot) {
    enqueue(CONNECTIONS, connection_counter(push.edge), slot);
}

uint connection_count() {
    return counted(connection_counter(push.edge));
}

uint queued_connection(uint place) {
    return load_scratch_word(queue_at(CONNECTIONS) + place);
}

uint lane_count() {
    return gl_NumWorkGroups.x * WORKGROUP_SIZE;
}

uint connection_at(uint slot) {
    return STATE_QUADRUPLES * slot_count() + CONNECTION_QUADRUPLES * slot;
}

void store_connection(uint slot, Connection connection) {
    uint at = connection_at(slot);
    // Light that is not a number counts as none.
    uint units = connection.evidence.units;
    store_scratch(at, brings_light(connection) ? uvec4(floatBitsToUint(connection.light), units) : uvec4(0u));
    if (!learns_lights() && !brings_light(connection)) return;
    if (brings_light(connection)) store_scratch(at + 1u, floatBitsToUint(vec4(connection.ray.origin, connection.ray.t_max)));
    store_scratch(at + 2u, uvec4(floatBitsToUint(connection.ray.direction), connection.evidence.sum));
}

Ray load_connection_ray(uint slot) {
    vec4 origin = uintBitsToFloat(load_scratch(connection_at(slot) + 1u));
    vec4 direction = uintBitsToFloat(load_scratch(connection_at(slot) + 2u));
    return Ray(origin.xyz, direction.xyz, origin.w);
}

// Removes a connection's light: something blocks its ray.
void block_connection(uint slot) {
    store_scratch(connection_at(slot), uvec4(0u));
}

vec3 load_connected_light(uint slot) {
    return uintBitsToFloat(load_scratch(connection_at(slot)).xyz);
}

LightEvidence load_light_evidence(uint slot) {
    if (!learns_lights()) return NO_LIGHT_EVIDENCE;
    return LightEvidence(load_scratch(connection_at(slot) + 2u).w, load_scratch(connection_at(slot)).w);
}

uint hit_at(uint slot) {
    return (SLOT_QUADRUPLES - 1u) * slot_count() + slot;
}

void store_hit(uint slot, Hit hit) {
    store_scratch(hit_at(slot), uvec4(floatBitsToUint(vec3(hit.t, hit.uv)), hit.primitive));
}

Hit load_hit(uint slot) {
    uvec4 hit = load_scratch(hit_at(slot));
    return Hit(uintBitsToFloat(hit.x), uintBitsToFloat(hit.yz), hit.w);
}

uint first_hit_at(uint slot) {
    return (STATE_QUADRUPLES + CONNECTION_QUADRUPLES) * slot_count() + FIRST_HIT_QUADRUPLES * slot;
}

void store_first_hit(uint slot, FirstHit first) {
    store_scratch(first_hit_at(slot), floatBitsToUint(vec4(first.albedo, first.depth)));
    store_scratch(first_hit_at(slot) + 1u, uvec4(floatBitsToUint(first.normal), uint(first.known)));
}

FirstHit load_first_hit(uint slot) {
    vec4 albedo = uintBitsToFloat(load_scratch(first_hit_at(slot)));
    uvec4 normal = load_scratch(first_hit_at(slot) + 1u);
    return FirstHit(normal.w != 0u, albedo.xyz, uintBitsToFloat(normal.xyz), albedo.w);
}

// The ray that a path travels now.
Ray load_ray(uint slot) {
    if (push.edge == 0u) return path_from_camera(slot, film_pixel_of(slot)).ray;
    vec4 origin = uintBitsToFloat(load_state(slot, 0u));
    return Ray(origin.xyz, uintBitsToFloat(load_state(slot, 1u)).xyz, origin.w);
}

vec3 load_path_radiance(uint slot) {
    return uintBitsToFloat(load_state(slot, RADIANCE).xyz);
}

// A path keeps more than its ray, its throughput and its radiance.
bool keeps_origin() {
    if (NEE) return true;
    return uses_guide();
}

// Stores what the next edges need of a path; of a path that has ended, only its radiance. A pixel's coordinates have
// PIXEL_DIGITS binary digits.
void store_path(uint slot, uvec2 film_pixel, Path path) {
    store_state(slot, RADIANCE, uvec4(floatBitsToUint(path.radiance), film_pixel.x | (film_pixel.y << PIXEL_DIGITS)));
    if (path.depth == 0u) return;
    store_state(slot, 0u, uvec4(floatBitsToUint(path.ray.origin), floatBitsToUint(path.ray.t_max)));
    store_state(slot, 1u, uvec4(floatBitsToUint(path.ray.direction), floatBitsToUint(path.evidence.of_guide)));
    store_state(slot, 2u, uvec4(floatBitsToUint(path.throughput), floatBitsToUint(path.eta)));
    if (keeps_origin()) {
        vec2 floats = vec2(path.pdf, path.pixel_estimate);
        store_state(slot, 4u, uvec4(path.segment.index, floatBitsToUint(floats), path.evidence.share));
        store_state(slot, 5u, uvec4(floatBitsToUint(path.previous_position), floatBitsToUint(path.evidence.scattered)));
    }
}

// The path of a slot, and its pixel. Segments have the scale 1: only `quadtree` has others, and it is not traced as waves.
Path load_path(uint slot, out uvec2 film_pixel) {
    if (push.edge == 0u) {
        film_pixel = film_pixel_of(slot);
        return path_from_camera(slot, film_pixel);
    }
    uvec4 radiance = load_state(slot, RADIANCE);
    film_pixel = uvec2(radiance.w & ((1u << PIXEL_DIGITS) - 1u), radiance.w >> PIXEL_DIGITS);
    vec4 direction = uintBitsToFloat(load_state(slot, 1u));
    vec4 throughput = uintBitsToFloat(load_state(slot, 2u));
    Path path = new_path(key_of_slot(slot, film_pixel));
    path.ray = load_ray(slot);
    path.throughput = throughput.xyz;
    path.eta = throughput.w;
    path.radiance = uintBitsToFloat(radiance.xyz);
    path.depth = push.edge + 1u;
    if (keeps_origin()) {
        uvec4 segment_and_share = load_state(slot, 4u);
        vec4 position_and_scattered = uintBitsToFloat(load_state(slot, 5u));
        path.segment.index = segment_and_share.x;
        path.pdf = uintBitsToFloat(segment_and_share.y);
        path.pixel_estimate = uintBitsToFloat(segment_and_share.z);
        path.evidence = ShareEvidence(segment_and_share.w, position_and_scattered.w, direction.w);
        path.previous_position = position_and_scattered.xyz;
    }
    return path;
}

#endif
