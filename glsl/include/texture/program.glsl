// Programs: textures that are computed at a point of a surface by a list of operations. src/encode/textures/programs.rs writes
// the words, src/scene/program has the graphs that they are made of. Where a result is
// not finite it becomes 0. A value has three components; a number stands in all three.
#ifndef PROGRAM_GLSL
#define PROGRAM_GLSL
#include "math/constants.glsl"
#include "math/direction.glsl"
#include "texture/bricks.glsl"
#include "texture/color_models.glsl"
#include "texture/lattice_noise.glsl"
#include "texture/noise.glsl"
#include "texture/pattern.glsl"
#include "texture/voronoi.glsl"

// Point of a surface as textures know it.
struct TexturePoint {
    vec2 uv;        // texture coordinates
    vec3 position;  // in world space
    vec3 normal;    // geometric normal, in world space
    vec3 shading_normal;  // in world space
    vec3 incoming;  // unit vector to where the surface is seen from, in world space
};

vec3 three_words(uint address) {
    return uintBitsToFloat(uvec3(texel_word(address), texel_word(address + 1u), texel_word(address + 2u)));
}

// Quotient of each component; 0 where the divisor is 0.
vec3 safe_quotient(vec3 a, vec3 b) {
    bvec3 valid = notEqual(b, vec3(0.0));
    return mix(vec3(0.0), a / mix(vec3(1.0), b, valid), valid);
}

// Power of each component; 1 where the exponent is 0, else 0 where the base is 0, or negative and the exponent is no whole number.
vec3 safe_power(vec3 a, vec3 b) {
    bvec3 negative = lessThan(a, vec3(0.0));
    bvec3 zero = bvec3(negative.x && floor(b.x) != b.x, negative.y && floor(b.y) != b.y, negative.z && floor(b.z) != b.z);
    vec3 power = pow(mix(vec3(1.0), abs(a), notEqual(a, vec3(0.0))), b);
    vec3 odd = b - 2.0 * floor(0.5 * b);
    power *= mix(vec3(1.0), 1.0 - 2.0 * odd, negative);
    power = mix(power, vec3(0.0), zero);
    power = mix(power, vec3(0.0), equal(a, vec3(0.0)));
    return mix(power, vec3(1.0), equal(b, vec3(0.0)));
}

// Logarithm of each component; 0 where it is not positive.
vec3 safe_logarithm(vec3 a) {
    bvec3 valid = greaterThan(a, vec3(0.0));
    return mix(vec3(0.0), log(mix(vec3(1.0), a, valid)), valid);
}

// Angle of each point (b, a) in radians; 0 where both are 0.
vec3 safe_arctangent(vec3 a, vec3 b) {
    bvec3 none = bvec3(a.x == 0.0 && b.x == 0.0, a.y == 0.0 && b.y == 0.0, a.z == 0.0 && b.z == 0.0);
    return mix(atan(a, mix(b, vec3(1.0), none)), vec3(0.0), none);
}

// Angle from the z-axis in half turns and azimuth in turns: pbrt's `spherical` mapping.
vec3 spherical_coordinates(vec3 p) {
    return vec3(atan(length(p.xy), p.z) * INV_PI, turns(p.xy), 0.0);
}

// Azimuth in turns from the negative x-axis, and the height: pbrt's `cylindrical` mapping.
vec3 cylindrical_coordinates(vec3 p) {
    return vec3(0.5 + (all(equal(p.xy, vec2(0.0))) ? 0.0 : atan(p.y, p.x) * INV_TWO_PI), p.z, 0.0);
}

// 0 where the whole parts of the coordinates have an even sum, and 1 elsewhere.
float checker(vec3 p) {
    vec3 odd = floor(p) - 2.0 * floor(0.5 * floor(p));
    float sum = odd.x + odd.y + odd.z;
    return sum - 2.0 * floor(0.5 * sum);
}

// Color of pbrt's marble for a height in [0, 1]: a spline of six cubic Bezier segments, each of which begins one point later.
vec3 marble_color(float height) {
    float place = 6.0 * clamp(height, 0.0, 1.0);
    float segment = min(floor(place), 5.0);
    float t = place - segment;
    const vec3 light = vec3(0.58, 0.58, 0.6);
    vec3 points[4];
    for (uint i = 0u; i < 4u; ++i) {
        uint index = uint(segment) + i;
        vec3 color = light;
        if (index == 3u) color = vec3(0.5);
        if (index == 4u) color = vec3(0.6, 0.59, 0.58);
        if (index == 7u) color = vec3(0.2, 0.2, 0.33);
        points[i] = color;
    }
    vec3 low = mix(mix(points[0], points[1], t), mix(points[1], points[2], t), t);
    vec3 high = mix(mix(points[1], points[2], t), mix(points[2], points[3], t), t);
    return 1.5 * mix(low, high, t);
}

// Value of a table with `count` entries of three channels, each for its own component of `at`, from 0 to 1. Between entries it is
// linear, or in steps. Beyond the ends it goes on, or as straight lines.
vec3 table_value(uint table, uint count, vec3 at, bool steps, bool extrapolate) {
    float last = float(count - 1u);
    vec3 value = vec3(0.0);
    for (uint i = 0u; i < 6u; ++i) {
        uint channel = i >> 1u;
        float place = clamp(at[channel], 0.0, 1.0) * last;
        uint low = min(uint(place), count - 1u);
        if (extrapolate && at[channel] > 1.0) low = count - min(2u, count);
        bool beyond = extrapolate && (at[channel] < 0.0 || at[channel] > 1.0);
        float t = beyond ? at[channel] * last - float(low) : (steps ? 0.0 : place - float(low));
        bool second = (i & 1u) != 0u;
        float number = uintBitsToFloat(texel_word(table + 3u * min(second ? low + 1u : low, count - 1u) + channel));
        float weight = second ? t : 1.0 - t;
        value += mix(vec3(0.0), vec3(weight * number), equal(uvec3(0u, 1u, 2u), uvec3(channel)));
    }
    return value;
}

bool is_operation(uint found, uint operation) {
    return has_operation(operation) && found == operation;
}

// Operands of an instruction, and the address of the numbers that follow its constants.
struct Instruction {
    uint operation;  // OPERATION_*
    vec3 a;          // operands
    vec3 b;
    vec3 c;
    uint numbers;    // address of the operation's numbers
    uint words[5];   // the first of these numbers, for operations of PROGRAM_LATER_OPERATIONS
};

// Value of an operation on coordinates or images.
vec3 coordinate_operation(Instruction i) {
    vec3 value = i.a;
    if (is_operation(i.operation, OPERATION_TRANSFORM)) {
        vec4 x = vec4(three_words(i.numbers), uintBitsToFloat(texel_word(i.numbers + 3u)));
        vec4 y = vec4(three_words(i.numbers + 4u), uintBitsToFloat(texel_word(i.numbers + 7u)));
        vec4 z = vec4(three_words(i.numbers + 8u), uintBitsToFloat(texel_word(i.numbers + 11u)));
        value = vec3(dot(x.xyz, i.a) + x.w, dot(y.xyz, i.a) + y.w, dot(z.xyz, i.a) + z.w);
    }
    if (is_operation(i.operation, OPERATION_SPHERICAL)) value = spherical_coordinates(i.a);
    if (is_operation(i.operation, OPERATION_CYLINDRICAL)) value = cylindrical_coordinates(i.a);
    if (is_operation(i.operation, OPERATION_COMPONENT)) value = vec3(i.a[min(texel_word(i.numbers), 2u)]);
    if (is_operation(i.operation, OPERATION_IMAGE)) value = sample_pattern(texel_word(i.numbers), i.a.xy).rgb;
    return value;
}

// Number of dimensions of an operation, of four that follow each other; 0 for all others.
uint dimensions_of(Instruction i, uint first) {
    bool any_of_them = has_operation(first) || has_operation(first + 1u) || has_operation(first + 2u) || has_operation(first + 3u);
    uint after = i.operation - first;
    return any_of_them && after < 4u ? after + 1u : 0u;
}

// Point in up to four dimensions. In one dimension, it is the fourth coordinate.
vec4 point_in(uint dimensions, vec3 p, float w) {
    if (dimensions == 1u) return vec4(w, 0.0, 0.0, 0.0);
    return vec4(p.xy, dimensions > 2u ? p.z : 0.0, dimensions > 3u ? w : 0.0);
}

// Value of an operation on hashes: noise, Voronoi diagrams and bricks of Blender.
vec3 hashed_operation(Instruction i, vec3 value) {
    if (is_operation(i.operation, OPERATION_WHITE_NOISE)) {
        uint dimensions = clamp(i.words[0], 1u, 4u);
        value = color_of_floats(dimensions, point_in(dimensions, i.a, i.b.x));
    }
    uint dimensions = dimensions_of(i, OPERATION_NOISE_1D);
    if (dimensions > 0u) {
        Fractal f = Fractal(i.words[0], i.words[1] != 0u, i.b.y, i.b.z, i.c.x, i.c.y, i.c.z);
        value = vec3(fractal_noise(dimensions, point_in(dimensions, i.a, i.b.x), f));
    }
    dimensions = dimensions_of(i, OPERATION_VORONOI_1D);
    if (dimensions > 0u) {
        float exponent = uintBitsToFloat(i.words[4]);
        Voronoi v = Voronoi(dimensions, i.words[0], i.words[1], i.words[3] != 0u, exponent, i.b.y, i.b.z, i.c.x,
                            i.c.y, i.c.z);
        VoronoiValue found = fractal_voronoi(v, point_in(dimensions, i.a, i.b.x));
        uint asked = i.words[2];
        vec4 place = dimensions == 1u ? found.position.yzwx : found.position;
        value = vec3(found.distance);
        if (asked == VORONOI_COLOR) value = found.color;
        if (asked == VORONOI_POSITION) value = place.xyz;
        if (asked == VORONOI_W) value = vec3(place.w);
    }
    if (is_operation(i.operation, OPERATION_BRICKS)) {
        vec2 factors = uintBitsToFloat(uvec2(i.words[0], i.words[1]));
        Bricks b = Bricks(i.b.x, i.b.y, i.b.z, i.c.x, i.c.y, factors.x, factors.y, int(i.words[2]), int(i.words[3]));
        value = vec3(brick_at(b, i.a.xy), 0.0);
    }
    return value;
}

// Value of an operation on models of colors, or that looks up a table.
vec3 color_operation(Instruction i, vec3 value) {
    if (is_operation(i.operation, OPERATION_HSV_FROM_RGB)) value = hsv_from_rgb(i.a);
    if (is_operation(i.operation, OPERATION_RGB_FROM_HSV)) value = rgb_from_hsv(i.a);
    if (is_operation(i.operation, OPERATION_HSL_FROM_RGB)) value = hsl_from_rgb(i.a);
    if (is_operation(i.operation, OPERATION_RGB_FROM_HSL)) value = rgb_from_hsl(i.a);
    if (is_operation(i.operation, OPERATION_TABLE)) {
        value = table_value(i.words[2], max(i.words[3], 1u), i.a, i.words[1] != 0u, i.words[0] != 0u);
    }
    return value;
}

// Value of an operation that adds octaves, or that draws dots.
vec3 noise_operation(Instruction i, vec3 value) {
    if (is_operation(i.operation, OPERATION_DOTS)) {
        value = vec3(is_in_dot(texel_word(i.numbers), i.a.xy) ? 1.0 : 0.0);
    }
    if (has_operation(OPERATION_FBM) || has_operation(OPERATION_WRINKLED)) {
        bool absolute = has_operation(OPERATION_WRINKLED) && i.operation == OPERATION_WRINKLED;
        if (absolute || is_operation(i.operation, OPERATION_FBM)) {
            uint octaves = texel_word(i.numbers);
            float roughness = uintBitsToFloat(texel_word(i.numbers + 1u));
            value = vec3(octaves_of_noise(texel_word(i.numbers + 2u), i.a, octaves, roughness, absolute));
        }
    }
    return value;
}

// Value of an operation on numbers and colors.
vec3 arithmetic_operation(Instruction i, vec3 value) {
    if (is_operation(i.operation, OPERATION_ADD)) value = i.a + i.b;
    if (is_operation(i.operation, OPERATION_SUBTRACT)) value = i.a - i.b;
    if (is_operation(i.operation, OPERATION_MULTIPLY)) value = i.a * i.b;
    if (is_operation(i.operation, OPERATION_DIVIDE)) value = safe_quotient(i.a, i.b);
    if (is_operation(i.operation, OPERATION_MINIMUM)) value = min(i.a, i.b);
    if (is_operation(i.operation, OPERATION_MAXIMUM)) value = max(i.a, i.b);
    if (is_operation(i.operation, OPERATION_POWER)) value = safe_power(i.a, i.b);
    if (is_operation(i.operation, OPERATION_ABSOLUTE)) value = abs(i.a);
    if (is_operation(i.operation, OPERATION_SINE)) value = sin(i.a);
    if (is_operation(i.operation, OPERATION_SQUARE_ROOT)) value = sqrt(max(i.a, vec3(0.0)));
    if (is_operation(i.operation, OPERATION_MIX)) value = (1.0 - i.c) * i.a + i.c * i.b;
    if (is_operation(i.operation, OPERATION_DOT)) value = vec3(dot(i.a, i.b));
    if (is_operation(i.operation, OPERATION_LUMINANCE)) value = vec3(luminance(i.a));
    if (is_operation(i.operation, OPERATION_CHECKER)) value = vec3(checker(i.a));
    if (is_operation(i.operation, OPERATION_MARBLE)) value = marble_color(i.a.x);
    if (is_operation(i.operation, OPERATION_FLOOR)) value = floor(i.a);
    if (is_operation(i.operation, OPERATION_LESS)) value = mix(vec3(0.0), vec3(1.0), lessThan(i.a, i.b));
    if (is_operation(i.operation, OPERATION_EXPONENTIAL)) value = exp(i.a);
    if (is_operation(i.operation, OPERATION_LOGARITHM)) value = safe_logarithm(i.a);
    if (is_operation(i.operation, OPERATION_ARCTANGENT)) value = safe_arctangent(i.a, i.b);
    if (is_operation(i.operation, OPERATION_COMBINE)) value = vec3(i.a.x, i.b.x, i.c.x);
    return value;
}

// Result of a program at a point.
vec3 run_program(uint index, TexturePoint at) {
    vec3 registers[PROGRAM_REGISTERS];
    uint address = texture_address(index);
    uint length = texture_size(index).x;
    vec3 result = vec3(0.0);
    bool more = length > 0u;
    for (uint step = 0u; step < MAX_PROGRAM_LENGTH && more; ++step) {
        uint word = texel_word(address);
        uint next = address + 1u;
        vec3 operands[3];
        for (uint i = 0u; i < 3u; ++i) {
            uint operand = (word >> (PROGRAM_OPERAND_SHIFT + i * PROGRAM_OPERAND_BITS)) & ((1u << PROGRAM_OPERAND_BITS) - 1u);
            vec3 value = registers[operand & (PROGRAM_REGISTERS - 1u)];
            if (operand == OPERAND_CONSTANT) {
                value = three_words(next);
                next += 3u;
            }
            if (operand == OPERAND_UV) value = vec3(at.uv, 0.0);
            if (operand == OPERAND_POSITION) value = at.position;
            if (operand == OPERAND_NORMAL) value = at.normal;
            if (operand == OPERAND_SHADING_NORMAL) value = at.shading_normal;
            if (operand == OPERAND_INCOMING) value = at.incoming;
            operands[i] = value;
        }
        uint after = address + 1u + (word >> PROGRAM_LENGTH_SHIFT);
        uint words[5] = uint[5](0u, 0u, 0u, 0u, 0u);
        if (PROGRAM_LATER_OPERATIONS != 0u) {
            for (uint i = 0u; i < 5u; ++i) words[i] = texel_word(min(next + i, after - 1u));
        }
        Instruction instruction = Instruction(word & 255u, operands[0], operands[1], operands[2], next, words);
        vec3 value = coordinate_operation(instruction);
        value = noise_operation(instruction, value);
        value = hashed_operation(instruction, value);
        value = color_operation(instruction, value);
        value = arithmetic_operation(instruction, value);
        registers[(word >> PROGRAM_OUTPUT_SHIFT) & (PROGRAM_REGISTERS - 1u)] = value;
        result = more ? value : result;
        address = after;
        more = step + 1u < length;
        if (!more) break;
    }
    vec3 finite = vec3(is_finite(result.x) ? result.x : 0.0, is_finite(result.y) ? result.y : 0.0,
                       is_finite(result.z) ? result.z : 0.0);
    return clamp(finite, texture_colors(index, 0u).rgb, texture_colors(index, 1u).rgb);
}

// Least step by which heights are compared, in texture coordinates: pbrt's.
const float LEAST_BUMP_STEP = 0.0005;
// Least step relative to the position's largest coordinate, so that rounding changes a slope by a few thousandths at most.
const float BUMP_STEP_OF_POSITION = 1.0 / 65536.0;

// Derivative of a program's number by the surface's coordinates: differences between three points. `dp_du` and `dp_dv` are the
// derivatives of the position.
vec2 program_gradient(uint index, TexturePoint at, vec3 dp_du, vec3 dp_dv) {
    float reach = texture_size(index).y != 0u ? BUMP_STEP_OF_POSITION * max_abs(at.position) : 0.0;
    vec2 lengths = max(vec2(length(dp_du), length(dp_dv)), vec2(1.0e-20));
    vec2 steps = max(vec2(LEAST_BUMP_STEP), vec2(reach) / lengths);
    // The differences of coordinates as they are rounded.
    vec2 moved = at.uv + steps;
    steps = moved - at.uv;
    vec3 heights = vec3(0.0);
    for (uint i = 0u; i < 3u; ++i) {
        vec2 by = vec2(i == 1u ? 1.0 : 0.0, i == 2u ? 1.0 : 0.0) * steps;
        TexturePoint point = at;
        point.uv += by;
        point.position += by.x * dp_du + by.y * dp_dv;
        float height = run_program(index, point).x;
        heights = mix(heights, vec3(height), equal(uvec3(0u, 1u, 2u), uvec3(i)));
    }
    return (heights.yz - heights.x) / steps;
}

#endif
