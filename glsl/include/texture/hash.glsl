// Hashes of Blender's textures: lookup3 (Jenkins 2006), and the permuted congruential generators of Jarzynski and Olano (2020).
#ifndef HASH_GLSL
#define HASH_GLSL

uint rotated_bits(uint x, uint by) {
    return (x << by) | (x >> (32u - by));
}

uvec3 lookup3_mix(uvec3 v) {
    const uint first[3] = uint[3](4u, 6u, 8u);
    const uint second[3] = uint[3](16u, 19u, 4u);
    uint a = v.x, b = v.y, c = v.z;
    a -= c; a ^= rotated_bits(c, first[0]); c += b;
    b -= a; b ^= rotated_bits(a, first[1]); a += c;
    c -= b; c ^= rotated_bits(b, first[2]); b += a;
    a -= c; a ^= rotated_bits(c, second[0]); c += b;
    b -= a; b ^= rotated_bits(a, second[1]); a += c;
    c -= b; c ^= rotated_bits(b, second[2]); b += a;
    return uvec3(a, b, c);
}

uint lookup3_final(uvec3 v) {
    uint a = v.x, b = v.y, c = v.z;
    c ^= b; c -= rotated_bits(b, 14u);
    a ^= c; a -= rotated_bits(c, 11u);
    b ^= a; b -= rotated_bits(a, 25u);
    c ^= b; c -= rotated_bits(b, 16u);
    a ^= c; a -= rotated_bits(c, 4u);
    b ^= a; b -= rotated_bits(a, 14u);
    c ^= b; c -= rotated_bits(b, 24u);
    return c;
}

// Hash of the first `count` words, 1 to 4. The others are 0.
uint lookup3(uint count, uvec4 words) {
    uvec3 v = uvec3(0xdeadbeefu + (count << 2u) + 13u) + words.xyz;
    if (count > 3u) {
        v = lookup3_mix(v);
        v.x += words.w;
    }
    return lookup3_final(v);
}

// Three numbers in [0, 1] of `count` floats, of which the others are 0.
vec3 color_of_floats(uint count, vec4 v) {
    vec3 color = vec3(0.0);
    for (uint i = 0u; i < 3u; ++i) {
        vec4 values = v;
        if (count == 4u) {
            if (i == 1u) values = v.zxwy;
            if (i == 2u) values = v.wzyx;
        } else if (i > 0u) {
            values = mix(v, vec4(float(i)), equal(uvec4(0u, 1u, 2u, 3u), uvec4(count)));
        }
        uint hash = lookup3(count < 4u && i > 0u ? count + 1u : count, floatBitsToUint(values));
        color = mix(color, vec3(float(hash) * (1.0 / 4294967295.0)), equal(uvec3(0u, 1u, 2u), uvec3(i)));
    }
    return color;
}

// Numbers in [0, 1] of two, three or four whole numbers. The shifts keep the sign.
vec4 hash_of_cell(uint count, ivec4 v) {
    v = v * 1664525 + 1013904223;
    for (uint round = 0u; round < 2u; ++round) {
        if (count == 2u) {
            v.x += v.y * 1664525;
            v.y += v.x * 1664525;
        }
        if (count == 3u) {
            v.x += v.y * v.z;
            v.y += v.z * v.x;
            v.z += v.x * v.y;
        }
        if (count == 4u) {
            v.x += v.y * v.w;
            v.y += v.z * v.x;
            v.z += v.x * v.y;
            v.w += v.y * v.z;
        }
        if (round == 0u) v ^= v >> 16;
    }
    return vec4(v & 0x7fffffff) * (1.0 / 2147483647.0);
}

#endif
