// Volumes: grids of values through which a medium varies. A block of voxels has a majorant: a number that no channel of the medium's
// extinction exceeds in the block. A ray walks from block to block (Amanatides and Woo 1987).
#ifndef VOLUME_GLSL
#define VOLUME_GLSL
#include "film/frame.glsl"
#include "geometry/intersect.glsl"

// Whether some medium of the scene is a grid.
bool has_volumes() {
    return has_feature(FEATURE_VOLUMES);
}

// Position of a point in the space of the grid.
vec3 place_in_volume(VolumeRecord volume, vec3 position) {
    vec4 p = vec4(position, 1.0);
    return vec3(dot(volume.grid_x, p), dot(volume.grid_y, p), dot(volume.grid_z, p));
}

// Remainder of a division, at least 0.
ivec3 remainder(ivec3 value, ivec3 divisor) {
    ivec3 rest = value - ivec3(floor(vec3(value) / vec3(divisor))) * divisor;
    // The quotient is rounded.
    rest = mix(rest, rest + divisor, lessThan(rest, ivec3(0)));
    return mix(rest, rest - divisor, greaterThanEqual(rest, divisor));
}

// Value of a voxel, which may lie outside the volume.
vec3 voxel_value(VolumeRecord volume, ivec3 voxel) {
    ivec3 size = ivec3(volume.size);
    if ((volume.flags & VOLUME_REPEAT) != 0u) voxel = remainder(voxel, size);
    if ((volume.flags & VOLUME_MIRROR) != 0u) {
        voxel = remainder(voxel, 2 * size);
        voxel = min(voxel, 2 * size - 1 - voxel);
    }
    uvec3 inside = uvec3(clamp(voxel, ivec3(0), size - 1));
    bool counts = (volume.flags & VOLUME_CLAMP) != 0u || ivec3(inside) == voxel;
    uint index = (inside.z * volume.size.y + inside.y) * volume.size.x + inside.x;
    if ((volume.flags & VOLUME_COLORS) == 0u) {
        float value = uintBitsToFloat(texel_word(volume.address + index));
        return counts ? vec3(value) : vec3(0.0);
    }
    uint address = volume.address + 3u * index;
    uvec3 words = uvec3(texel_word(address), texel_word(address + 1u), texel_word(address + 2u));
    return counts ? uintBitsToFloat(words) : vec3(0.0);
}

// Coordinates that no conversion to whole numbers exceeds.
const float MOST_VOXELS_AWAY = 4194304.0;

// Value of a volume at a place of its grid.
vec3 volume_value(VolumeRecord volume, vec3 place) {
    bool nearest = (volume.flags & VOLUME_NEAREST) != 0u;
    place = clamp(nearest ? place : place - 0.5, -MOST_VOXELS_AWAY, MOST_VOXELS_AWAY);
    vec3 low = floor(place);
    vec3 high_share = nearest ? vec3(0.0) : place - low;
    vec3 sum = vec3(0.0);
    for (uint corner = 0u; corner < (nearest ? 1u : 8u); ++corner) {
        uvec3 high = uvec3(corner, corner >> 1u, corner >> 2u) & 1u;
        vec3 shares = mix(1.0 - high_share, high_share, equal(high, uvec3(1u)));
        sum += (shares.x * shares.y * shares.z) * voxel_value(volume, ivec3(low) + ivec3(high));
    }
    return sum;
}

// Walk of a ray through the blocks of a volume. Distances are along the ray, in units of the scene.
struct VolumeWalk {
    vec3 origin;      // of the ray, in the space of the grid
    vec3 direction;   // in the space of the grid; its length is not 1
    vec3 next;        // distances at which the ray leaves the block, along each axis
    vec3 spacing;     // distances between blocks along each axis
    ivec3 block;      // that the ray is in
    float t;          // distance that the ray has come
    float end;        // distance at which the ray leaves the volume, or ends
    float majorant;   // of the block
    bool more;        // the ray has not arrived at the end
};

// Looks up the majorant of the block that the walk has entered; a walk that has left the volume ends.
void enter_block(inout VolumeWalk walk, VolumeRecord volume) {
    ivec3 blocks = ivec3(volume.blocks);
    uvec3 at = uvec3(clamp(walk.block, ivec3(0), blocks - 1));
    walk.more = walk.t < walk.end && ivec3(at) == walk.block;
    uint index = (at.z * volume.blocks.y + at.y) * volume.blocks.x + at.x;
    walk.majorant = uintBitsToFloat(texel_word(volume.majorants + index));
}

// Begins the walk of a ray where it enters the volume.
VolumeWalk start_walk(VolumeRecord volume, Ray ray) {
    VolumeWalk walk;
    walk.origin = place_in_volume(volume, ray.origin);
    vec3 d = ray.direction;
    walk.direction = vec3(dot(volume.grid_x.xyz, d), dot(volume.grid_y.xyz, d), dot(volume.grid_z.xyz, d));
    bvec3 backward = lessThan(walk.direction, vec3(0.0));
    vec3 speed = max(abs(walk.direction), vec3(1.0e-25));
    vec3 inverse = mix(1.0 / speed, -1.0 / speed, backward);
    vec3 first = (mix(vec3(0.0), vec3(volume.size), backward) - walk.origin) * inverse;
    vec3 last = (mix(vec3(volume.size), vec3(0.0), backward) - walk.origin) * inverse;
    walk.t = max(max(first.x, first.y), max(first.z, 0.0));
    walk.end = min(min(last.x, last.y), min(last.z, ray.t_max));
    vec3 place = walk.origin + walk.t * walk.direction;
    walk.block = clamp(ivec3(floor(place / volume.side)), ivec3(0), ivec3(volume.blocks) - 1);
    walk.next = (vec3(walk.block + mix(ivec3(1), ivec3(0), backward)) * volume.side - walk.origin) * inverse;
    walk.spacing = volume.side / speed;
    walk.majorant = 0.0;
    walk.more = false;
    enter_block(walk, volume);
    return walk;
}

// Distance at which the walk leaves its block, or ends.
float end_of_block(VolumeWalk walk) {
    return min(min(walk.next.x, walk.next.y), min(walk.next.z, walk.end));
}

// Moves the walk to the next block.
void leave_block(inout VolumeWalk walk, VolumeRecord volume) {
    walk.t = max(walk.t, end_of_block(walk));
    float nearest = min(min(walk.next.x, walk.next.y), walk.next.z);
    uint axis = walk.next.x == nearest ? 0u : (walk.next.y == nearest ? 1u : 2u);
    bvec3 moved = equal(uvec3(axis), uvec3(0u, 1u, 2u));
    ivec3 steps = mix(ivec3(1), ivec3(-1), lessThan(walk.direction, vec3(0.0)));
    walk.block += mix(ivec3(0), steps, moved);
    walk.next += mix(vec3(0.0), walk.spacing, moved);
    enter_block(walk, volume);
}

#endif
