// A wave: the paths of all samples of a slice, which travel edge by edge together. Each path has a slot. Queues hold the slots
// of paths that go on. This file alone knows where slots and queues lie in the scratch memory, and where their counters are.
#ifndef WAVEFRONT_GLSL
#define WAVEFRONT_GLSL
#include "path/connection.glsl"
#include "path/path.glsl"
#include "film/slice.glsl"
#include "generated/wave.glsl"
#include "shared/film.glsl"

// Push constants of the kernels of a wave.
struct WavePush {
    TracePush slice;  // slice whose samples the wave traces
    uint edge;        // number of the edge that the paths travel; 0 leaves the camera
};
layout(push_constant, scalar) uniform Push { WavePush push; };

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

// Queues: two of paths, for even and odd edges, then one of connections.
const uint CONNECTIONS = QUEUE_COUNT - 1u;

uint queue_at(uint queue) {
    return (4u * SLOT_QUADRUPLES + queue) * slot_count();
}

// Words of the instances that show what the slots' rays have hit. They follow the queues.
uint instances_at() {
    return queue_at(QUEUE_COUNT);
}

// Words of the weights of flights through grids, three for each slot. They follow those of instances.
uint flights_at() {
    return instances_at() + slot_count();
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

// Stores a connection. One without light needs no ray, but removes the light of the last edge's connection.
void store_connection(uint slot, Connection connection) {
    // Light that is not a number counts as none.
    if (!brings_light(connection)) {
        connection.light = vec3(0.0);
        connection.evidence.units = 0u;
    }
    store_connection_light(slot, connection);
    if (learns_lights() || brings_light(connection)) store_connection_ray(slot, connection);
    if (bends_light() && brings_light(connection)) store_connection_bend(slot, connection);
}

// A slot's connection with its ray. Its light is needed where surfaces let through a part of it.
Connection load_connection(uint slot) {
    Connection connection = NO_CONNECTION;
    load_connection_ray(slot, connection);
    if (weakens_light()) load_connection_light(slot, connection);
    if (bends_light()) load_connection_bend(slot, connection);
    return connection;
}

// Removes a connection's light: something blocks its ray.
void block_connection(uint slot) {
    store_connection_light(slot, NO_CONNECTION);
}

// A slot's connection for its light. Light learning also needs what lies beside the ray.
Connection load_connected_light(uint slot) {
    Connection connection = NO_CONNECTION;
    load_connection_light(slot, connection);
    if (learns_lights()) load_connection_ray(slot, connection);
    return connection;
}

Hit load_hit(uint slot) {
    Hit hit = no_hit(0.0);
    load_hit(slot, hit);
    if (HAS_INSTANCES) hit.instance = load_scratch_word(instances_at() + slot);
    return hit;
}

// Stores what the ray of a slot has hit.
void keep_hit(uint slot, Hit hit) {
    store_hit(slot, hit);
    if (HAS_INSTANCES) store_scratch_word(instances_at() + slot, hit.instance);
}

// Stores the weight of a slot's flight through a grid.
void keep_flown(uint slot, vec3 flown) {
    uint at = flights_at() + 3u * slot;
    store_scratch_word(at, floatBitsToUint(flown.x));
    store_scratch_word(at + 1u, floatBitsToUint(flown.y));
    store_scratch_word(at + 2u, floatBitsToUint(flown.z));
}

vec3 load_flown(uint slot) {
    uint at = flights_at() + 3u * slot;
    return uintBitsToFloat(uvec3(load_scratch_word(at), load_scratch_word(at + 1u), load_scratch_word(at + 2u)));
}

FirstHit load_first_hit(uint slot) {
    FirstHit first = NO_FIRST_HIT;
    load_first_hit(slot, first);
    return first;
}

// Radiance that a path has collected so far.
vec3 load_radiance(uint slot) {
    Path path;
    load_path_light(slot, path);
    return path.radiance;
}

// A path keeps more than its ray, its throughput and its radiance.
bool keeps_origin() {
    if (NEE) return true;
    if (HAS_FACING_DISKS) return true;
    return uses_guide();
}

// Stores what the next edges need of a path; of a path that has ended, only its radiance.
void store_path(uint slot, Path path) {
    store_path_light(slot, path);
    if (path.depth == 0u) return;
    store_path_ray(slot, path);
    if (keeps_origin()) store_path_guide(slot, path);
    if (weakens_light()) store_path_way(slot, path);
    if (bends_light()) store_path_bend(slot, path);
}

// Sets the time to that of a slot's path.
void set_moment_of_slot(uint slot) {
    if (has_time()) set_moment(key_of_slot(slot, film_pixel_of(slot)));
}

// The path of a slot.
Path load_path(uint slot) {
    if (push.edge == 0u) return path_from_camera(slot, film_pixel_of(slot));
    Path path = new_path(RandomKey(0u, 0u, 0u, 0u, 0u, 0u));
    load_path_light(slot, path);
    load_path_ray(slot, path);
    if (keeps_origin()) load_path_guide(slot, path);
    if (weakens_light()) load_path_way(slot, path);
    if (bends_light()) load_path_bend(slot, path);
    path.key = key_of_slot(slot, pixel_of(path));
    set_moment(path.key);
    path.depth = push.edge + 1u;
    if (!lets_through() && !bends_light()) forget_straight(path);
    if (!has_media()) path.medium = NO_MEDIUM;
    return path;
}

// The path of a slot, to whose ray facing disks are turned.
Path load_path_with_disks(uint slot) {
    Path path = load_path(slot);
    turn_disks_to(path);
    return path;
}

// The ray that a path travels now.
Ray load_ray(uint slot) {
    if (HAS_FACING_DISKS) return load_path_with_disks(slot).ray;
    if (push.edge == 0u) return path_from_camera(slot, film_pixel_of(slot)).ray;
    set_moment_of_slot(slot);
    Path path;
    load_path_ray(slot, path);
    return path.ray;
}

#endif
