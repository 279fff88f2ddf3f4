// Measured material (Dupuy and Jakob 2018), with the samples, densities and values of Mitsuba 3's `measured`. Tables over the unit square say
// how bright the samples of each direction of the viewer are, and which normals they lead to; a sample passes both. The numbers between the
// directions of the tables are interpolated. The number of steps of each search is bounded by the sides of a table. Only the front reflects.
#ifndef BSDF_MEASURED_GLSL
#define BSDF_MEASURED_GLSL
#include "bsdf/parameters.glsl"
#include "film/frame.glsl"
#include "math/constants.glsl"
#include "shared/records.glsl"

// Number of the kind.
const uint BSDF_MEASURED = 18u;

struct Measured {
    COLOR(0) vec3 albedo;        // mean share of light that is reflected
    SCALAR(4) float table_low;   // lower half of the address of the tables
    SCALAR(5) float table_high;  // upper half
    SCALAR(6) float roughness;   // tangent of the angle within which half of the facets lie
};

// The tables as they are seen from a direction.
struct MeasuredView {
    uint table;
    bool isotropic;
    vec2 mirror;     // signs that bring directions to the measured part
    vec2 u;          // the direction of the viewer in the unit square
    uint count;      // number of the measured directions between which numbers are interpolated
    uvec4 nearest;   // these directions
    vec4 weights;    // and their weights
};

// Grids of one kind.
struct MeasuredGrid {
    uvec2 size;    // columns and rows
    uint stride;   // words between the grids of two directions
    uint address;  // of the first
};

// Direction in the unit square: the square root of the inclination, and the azimuth (Dupuy and Jakob 2018, equation 14).
vec2 measured_square(vec3 w) {
    float azimuth = w.xy == vec2(0.0) ? 0.0 : atan(w.y, w.x);
    return vec2(sqrt(atan(length(w.xy), w.z) * (2.0 * INV_PI)), azimuth * INV_TWO_PI + 0.5);
}

float measured_number(uint address) {
    return uintBitsToFloat(texel_word(address));
}

MeasuredView measured_view(Measured b, vec3 wo) {
    MeasuredView v;
    v.table = uint(b.table_high) << 16 | uint(b.table_low);
    uint parts = texel_word(v.table + MEASURED_PARTS);
    v.isotropic = parts == 0u;
    float mirror_y = parts >= 2u && wo.y > 0.0 ? -1.0 : 1.0;
    v.mirror = vec2(parts == 4u ? (wo.x > 0.0 ? -1.0 : 1.0) : mirror_y, mirror_y);
    v.u = measured_square(vec3(wo.xy * v.mirror, wo.z));
    // A direction along the x-axis ends the measured part.
    if (parts >= 2u) v.u.y = 0.5 - abs(v.u.y - 0.5);
    vec2 angles = vec2((2.0 * v.u.y - 1.0) * PI, v.u.x * v.u.x * (0.5 * PI));
    uvec2 counts = uvec2(texel_word(v.table + MEASURED_AZIMUTHS), texel_word(v.table + MEASURED_ELEVATIONS));
    uvec2 first = uvec2(0u);
    vec2 share = vec2(0.0);
    uint list = v.table + MEASURED_HEAD_WORDS + MEASURED_GRIDS * MEASURED_GRID_WORDS;
    for (uint axis = 0u; axis < 2u; ++axis) {
        uint low = 0u;
        uint high = counts[axis] - 1u;
        while (high > low + 1u) {
            uint middle = (low + high) / 2u;
            if (measured_number(list + middle) <= angles[axis]) low = middle;
            else high = middle;
        }
        float start = measured_number(list + low);
        float range = measured_number(list + high) - start;
        first[axis] = low;
        share[axis] = range > 0.0 ? clamp((angles[axis] - start) / range, 0.0, 1.0) : 0.0;
        list += counts[axis];
    }
    uvec2 second = min(first + 1u, counts - 1u);
    v.count = counts.x > 1u ? 4u : 2u;
    v.nearest = uvec2(first.x, second.x).xxyy * counts.y + uvec2(first.y, second.y).xyxy;
    v.weights = vec2(1.0 - share.x, share.x).xxyy * vec2(1.0 - share.y, share.y).xyxy;
    return v;
}

MeasuredGrid measured_grid(MeasuredView v, uint kind) {
    uint record = v.table + MEASURED_HEAD_WORDS + kind * MEASURED_GRID_WORDS;
    uvec2 size = uvec2(texel_word(record), texel_word(record + 1u));
    return MeasuredGrid(size, texel_word(record + 2u), v.table + texel_word(record + 3u));
}

// Interpolated numbers at four places of the grids.
vec4 measured_numbers(MeasuredView v, MeasuredGrid g, uvec4 places) {
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < v.count; ++i) {
        uvec4 at = g.address + v.nearest[i] * g.stride + places;
        sum += v.weights[i] * vec4(measured_number(at.x), measured_number(at.y), measured_number(at.z), measured_number(at.w));
    }
    return sum;
}

// Interpolated mean of the numbers at two places of the grids.
float measured_mean(MeasuredView v, MeasuredGrid g, uvec2 places, float share) {
    float sum = 0.0;
    for (uint i = 0u; i < v.count; ++i) {
        uvec2 at = g.address + v.nearest[i] * g.stride + places;
        sum += v.weights[i] * mix(measured_number(at.x), measured_number(at.y), share);
    }
    return sum;
}

// Place in [0, 1] up to which a line from the first to the second height covers this area.
float measured_fraction(float area, float first, float second) {
    float root = sqrt(max(first * first + 2.0 * area * (second - first), 0.0));
    return clamp(2.0 * area / max(first + root, 1.0e-20), 0.0, 1.0);
}

// Number at a point of the unit square.
float measured_value(MeasuredView v, uint kind, vec2 u) {
    MeasuredGrid g = measured_grid(v, kind);
    vec2 position = clamp(u, 0.0, 1.0) * vec2(g.size - 1u);
    uvec2 cell = min(uvec2(position), g.size - 2u);
    vec2 share = position - vec2(cell);
    vec4 corners = measured_numbers(v, g, cell.y * g.size.x + cell.x + uvec4(0u, 1u, g.size.x, g.size.x + 1u));
    vec2 rows = mix(corners.xz, corners.yw, share.x);
    return mix(rows.x, rows.y, share.y);
}

// Last of `count` points, but for the very last, before which lies at most this share of the mean of two distributions.
uint measured_search(MeasuredView v, MeasuredGrid g, uvec2 places, float share, uint count, float u) {
    uint low = 0u;
    uint high = count - 1u;
    while (high > low + 1u) {
        uint middle = (low + high) / 2u;
        if (measured_mean(v, g, places + middle, share) <= u) low = middle;
        else high = middle;
    }
    return low;
}

// Point of the unit square with the shares `u` of the grid's density before it: those of its row, and those of the rows.
vec2 measured_sample(MeasuredView v, uint kind, vec2 u) {
    MeasuredGrid g = measured_grid(v, kind);
    uint width = g.size.x;
    uint columns = width * g.size.y;
    uint rows = 2u * columns;
    uint row = measured_search(v, g, uvec2(rows), 0.0, g.size.y, u.y);
    uint line = row * width;
    vec4 r = measured_numbers(v, g, uvec4(rows + row, columns + line + width - 1u, columns + line + 2u * width - 1u, rows));
    float y = measured_fraction((u.y - r.x) * float(g.size.y - 1u), r.y, r.z);
    float x = u.x * mix(r.y, r.z, y);
    uvec2 lines = columns + line + uvec2(0u, width);
    uint column = measured_search(v, g, lines, y, width, x);
    x -= measured_mean(v, g, lines + column, y);
    vec4 corners = measured_numbers(v, g, line + column + uvec4(0u, 1u, width, width + 1u));
    vec2 ends = mix(corners.xy, corners.zw, y);
    x = measured_fraction(x * float(width - 1u), ends.x, ends.y);
    return (vec2(column, row) + vec2(x, y)) / vec2(g.size - 1u);
}

// Normal of the facets that reflect from `wi` to `wo`.
struct MeasuredFacet {
    vec2 u;          // the normal in the unit square
    vec2 sample_at;  // the sample that leads to it
    float density;   // density of the normal in the unit square, where all samples are alike
    float jacobian;  // size in the unit square over that of the direction of the light, per steradian
};

// The inverse of measured_sample for the normals that the viewer sees.
MeasuredFacet measured_facet(MeasuredView v, vec3 wo, vec3 wi) {
    MeasuredFacet f;
    vec3 h = vec3((wo + wi).xy * v.mirror, wo.z + wi.z);
    f.u = measured_square(h);
    float size = max(length(h), 1.0e-10);
    // Both directions have the cosine size / 2 with the normal.
    f.jacobian = max(2.0 * PI * PI * f.u.x * length(h.xy) / size, 1.0e-6) * 2.0 * size;
    if (v.isotropic) f.u.y = f.u.y + 0.5 - v.u.y;
    f.u.y -= floor(f.u.y);
    MeasuredGrid g = measured_grid(v, MEASURED_VISIBLE_NORMALS);
    uint width = g.size.x;
    uint columns = width * g.size.y;
    vec2 position = clamp(f.u, 0.0, 1.0) * vec2(g.size - 1u);
    uvec2 cell = min(uvec2(position), g.size - 2u);
    vec2 share = position - vec2(cell);
    uint line = cell.y * width;
    vec4 corners = measured_numbers(v, g, line + cell.x + uvec4(0u, 1u, width, width + 1u));
    vec4 c = measured_numbers(v, g, columns + line + uvec4(cell.x, cell.x + width, width - 1u, 2u * width - 1u));
    vec2 ends = mix(corners.xy, corners.zw, share.y);
    f.density = mix(ends.x, ends.y, share.x);
    float before = mix(c.x, c.y, share.y) + 0.5 * share.x * (ends.x + f.density) / float(width - 1u);
    float total = mix(c.z, c.w, share.y);
    float rows = measured_mean(v, g, uvec2(2u * columns + cell.y), 0.0);
    f.sample_at = vec2(before / max(total, 1.0e-20), rows + 0.5 * share.y * (c.z + total) / float(g.size.y - 1u));
    return f;
}

BsdfSample sample_bsdf_measured(Measured b, vec3 wo, vec3 u) {
    BsdfSample s = NO_BSDF_SAMPLE;
    if (wo.z > 0.0) {
        MeasuredView v = measured_view(b, wo);
        vec2 point = u.yx;
        for (uint kind = MEASURED_BRIGHTNESS; kind <= MEASURED_VISIBLE_NORMALS; ++kind) point = measured_sample(v, kind, point);
        float inclination = point.x * point.x * (0.5 * PI);
        float azimuth = (2.0 * (v.isotropic ? point.y + v.u.y - 0.5 : point.y) - 1.0) * PI;
        float sine = sin(inclination);
        vec3 m = vec3(sine * cos(azimuth), sine * sin(azimuth), cos(inclination));
        s.wi = reflect(-wo, vec3(m.xy * v.mirror, m.z));
        s.lobe = s.wi.z > 0.0 ? LOBE_GLOSSY : LOBE_NONE;
    }
    return s;
}

float pdf_bsdf_measured(Measured b, vec3 wo, vec3 wi) {
    float pdf = 0.0;
    if (min(wo.z, wi.z) > 0.0) {
        MeasuredView v = measured_view(b, wo);
        MeasuredFacet f = measured_facet(v, wo, wi);
        pdf = f.density * measured_value(v, MEASURED_BRIGHTNESS, f.sample_at) / f.jacobian;
    }
    return pdf;
}

// f cos. What no sample reaches reflects nothing.
vec3 eval_bsdf_measured(Measured b, vec3 wo, vec3 wi) {
    vec3 value = vec3(0.0);
    if (min(wo.z, wi.z) > 0.0) {
        MeasuredView v = measured_view(b, wo);
        MeasuredFacet f = measured_facet(v, wo, wi);
        float factor = f.density > 0.0 ? 0.25 : 0.0;
        for (uint kind = MEASURED_COLORS; kind <= MEASURED_AREA; ++kind) {
            vec2 at = kind < MEASURED_NORMALS ? f.sample_at : kind == MEASURED_NORMALS ? f.u : v.u;
            float number = measured_value(v, kind, at);
            if (kind < MEASURED_NORMALS) value[kind] = number;
            else factor *= kind == MEASURED_NORMALS ? number : 1.0 / max(number, 1.0e-20);
        }
        value *= factor;
    }
    return value;
}

float guided_part_bsdf_measured(Measured b) {
    return GUIDE_SET == GUIDE_SET_ALL ? min(b.roughness / GUIDED_ALPHA, 1.0) : 0.0;
}

#endif
