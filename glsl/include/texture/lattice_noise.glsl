// Perlin's noise in one to four dimensions as Blender has it, and its sums of octaves.
#ifndef LATTICE_NOISE_GLSL
#define LATTICE_NOISE_GLSL
#include "shared/records.glsl"
#include "shared/variant.glsl"
#include "texture/hash.glsl"

float negated_if(float value, bool negate) {
    return negate ? -value : value;
}

// Dot product of a lattice point's gradient with the vector `d` from the point.
float hashed_gradient(uint dimensions, uint hash, vec4 d) {
    if (dimensions == 1u) return negated_if(float(1u + (hash & 7u)), (hash & 8u) != 0u) * d.x;
    float u, v;
    float w = 0.0;
    if (dimensions == 2u) {
        bool first = (hash & 7u) < 4u;
        u = first ? d.x : d.y;
        v = 2.0 * (first ? d.y : d.x);
    } else if (dimensions == 3u) {
        uint h = hash & 15u;
        u = h < 8u ? d.x : d.y;
        v = h < 4u ? d.y : (h == 12u || h == 14u ? d.x : d.z);
    } else {
        uint h = hash & 31u;
        u = h < 24u ? d.x : d.y;
        v = h < 16u ? d.y : d.z;
        w = negated_if(h < 8u ? d.z : d.w, (h & 4u) != 0u);
    }
    return negated_if(u, (hash & 1u) != 0u) + negated_if(v, (hash & 2u) != 0u) + w;
}

// Noise at a point, about in [-1, 1]. Components beyond the dimensions are 0. It repeats after 100,000 units.
float hashed_noise(uint dimensions, vec4 p) {
    vec4 shift = mix(vec4(0.0), vec4(0.5), greaterThanEqual(abs(p), vec4(1000000.0)));
    p = p - 100000.0 * trunc(p / 100000.0) + shift;
    vec4 cell = floor(p);
    vec4 d = p - cell;
    uvec4 base = uvec4(ivec4(cell));
    vec4 upper = d * d * d * (d * (d * 6.0 - 15.0) + 10.0);
    float sum = 0.0;
    bool more = true;
    for (uint corner = 0u; corner < 16u && more; ++corner) {
        uvec4 step = (uvec4(corner) >> uvec4(0u, 1u, 2u, 3u)) & 1u;
        vec4 weights = mix(1.0 - upper, upper, notEqual(step, uvec4(0u)));
        float gradient = hashed_gradient(dimensions, lookup3(dimensions, base + step), d - vec4(step));
        sum += more ? weights.x * weights.y * weights.z * weights.w * gradient : 0.0;
        more = corner + 1u < (1u << dimensions);
        if (!more) break;
    }
    const vec4 scales = vec4(0.25, 0.6616, 0.9820, 0.8344);
    return sum * scales[dimensions - 1u];
}

// Parameters of a sum of octaves.
struct Fractal {
    uint kind;       // FRACTAL_*
    bool normalized; // whether FRACTAL_FBM is mapped to [0, 1]
    float detail;    // octaves after the first; the last counts by the fraction
    float roughness; // factor of amplitudes from octave to octave
    float lacunarity; // factor of frequencies from octave to octave
    float offset;    // number that is added to the noise
    float gain;      // factor of the weights
};

// What the octaves have added up to.
struct FractalState {
    float value;
    float amplitude;
    float amplitudes;  // sum of the amplitudes
    float weight;
    float signal;
};

// Adds an octave, whose noise is `t`, with the share `share`.
void add_octave(inout FractalState s, Fractal f, uint octave, float t, float share) {
    if (f.kind == FRACTAL_FBM) {
        float sum = s.value + t * s.amplitude;
        if (f.normalized && share < 1.0) {
            // The two means are mixed, and the caller divides by the sum of the amplitudes.
            float both = s.amplitudes + s.amplitude;
            s.value = mix(s.value, sum * s.amplitudes / both, share);
        } else {
            s.value = mix(s.value, sum, share);
            s.amplitudes += s.amplitude;
        }
    }
    if (f.kind == FRACTAL_MULTIFRACTAL) s.value *= share * s.amplitude * t + 1.0;
    if (f.kind == FRACTAL_TERRAIN) {
        float increment = octave == 0u ? t + f.offset : share * (t + f.offset) * s.amplitude * s.value;
        s.value += increment;
    }
    if (f.kind == FRACTAL_HYBRID) {
        s.weight = min(s.weight, 1.0);
        s.signal = (t + f.offset) * s.amplitude;
        s.value += share * s.weight * s.signal;
        s.weight *= f.gain * s.signal;
    }
    if (f.kind == FRACTAL_RIDGED) {
        float ridge = f.offset - abs(t);
        s.weight = octave == 0u ? 1.0 : clamp(s.signal * f.gain, 0.0, 1.0);
        s.signal = ridge * ridge * s.weight;
        s.value += s.signal * (octave == 0u ? 1.0 : s.amplitude);
    }
    bool later = octave > 0u || (f.kind != FRACTAL_TERRAIN && f.kind != FRACTAL_RIDGED);
    s.amplitude *= later ? f.roughness : 1.0;
}

float fractal_noise(uint dimensions, vec4 p, Fractal f) {
    f.detail = clamp(f.detail, 0.0, 15.0);
    f.roughness = max(f.roughness, 0.0);
    bool starts_rough = f.kind == FRACTAL_TERRAIN || f.kind == FRACTAL_RIDGED;
    float first = f.kind == FRACTAL_MULTIFRACTAL ? 1.0 : 0.0;
    FractalState s = FractalState(first, starts_rough ? f.roughness : 1.0, 0.0, 1.0, 0.0);
    float fraction = f.kind == FRACTAL_RIDGED ? 0.0 : f.detail - floor(f.detail);
    uint whole = uint(f.detail) + 1u;
    uint octaves = whole + (fraction != 0.0 ? 1u : 0u);
    float scale = 1.0;
    bool more = true;
    for (uint octave = 0u; octave < 17u && more; ++octave) {
        float t = hashed_noise(dimensions, scale * p);
        if (more) add_octave(s, f, octave, t, octave < whole ? 1.0 : fraction);
        scale *= f.lacunarity;
        more = octave + 1u < octaves && (f.kind != FRACTAL_HYBRID || s.weight > 0.001);
        if (!more) break;
    }
    return f.kind == FRACTAL_FBM && f.normalized ? 0.5 * s.value / s.amplitudes + 0.5 : s.value;
}

#endif
