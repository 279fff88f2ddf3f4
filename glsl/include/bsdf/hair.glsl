// Fiber of hair or fur (Chiang, Bitterli, Tappan and Burley 2016, "A Practical and Controllable Hair and Fur Model for Production Path
// Tracing"), as Mitsuba 3's `hair`. The local y-axis runs along the fiber, and the normal says where light meets its circle. Light that has
// crossed the fiber `p` times leaves it where it has entered, in a lobe of its own: p = 0 is reflected, p = 3 stands for all further ones.
// Lobes follow `wo` alone, so the model is not reciprocal. Without absorption it keeps all light.
#ifndef BSDF_HAIR_GLSL
#define BSDF_HAIR_GLSL
#include "bsdf/parameters.glsl"
#include "math/direction.glsl"
#include "math/fresnel.glsl"

// Number of the kind.
const uint BSDF_HAIR = 17u;

// Least roughness. A smoother fiber would have lobes that single precision does not resolve.
const float MIN_HAIR_ROUGHNESS = 0.01;
// Number of the last lobe.
const uint LAST_HAIR_LOBE = 3u;

struct Hair {
    COLOR(0) vec3 sigma_a;                   // absorption per radius of the fiber
    SCALAR(0) float longitudinal_roughness;  // beta_m, from 0 to 1
    SCALAR(1) float azimuthal_roughness;     // beta_n, from 0 to 1
    SCALAR(2) float eta;                     // index of refraction, interior over exterior
    SCALAR(4) float tilt_sine;               // sine of the angle by which the scales of the fiber rise
};

// Fiber as it is seen from a direction. Angles around the fiber start at the normal.
struct Fiber {
    float sin_theta;      // of the angle between the direction and the plane across the fiber
    float cos_theta;
    float gamma;          // angle of the direction around the fiber, radians
    float gamma_t;        // angle of the refracted direction from the normal, radians
    float reflectance;    // of the fiber's surface
    vec3 transmittance;   // of one way through the fiber
    float variance;       // longitudinal, of the reflected lobe
    float scale;          // of the logistic distribution around the fiber
    vec2 tilt;            // cosine and sine of the scales' angle
};

// Lobe of a fiber.
struct HairLobe {
    vec2 mirrored;   // cosine and sine of the angle from the plane across the fiber, about whose opposite the lobe lies
    float variance;  // longitudinal
    float center;    // angle around the fiber, radians
};

// Angle of a direction around the fiber, in radians.
float angle_around_fiber(vec3 w) {
    return atan(-w.x, w.x == 0.0 && w.z == 0.0 ? 1.0 : w.z);
}

vec2 complex_product(vec2 a, vec2 b) {
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

Fiber fiber_of(Hair b, vec3 wo) {
    Fiber f;
    f.sin_theta = clamp(wo.y, -1.0, 1.0);
    f.cos_theta = length(wo.xz);
    f.gamma = angle_around_fiber(wo);
    float sin_t = clamp(-wo.x * inversesqrt(max(b.eta * b.eta - wo.y * wo.y, 1.0e-12)), -1.0, 1.0);
    float cos_t = sqrt(1.0 - sin_t * sin_t);
    f.gamma_t = atan(sin_t, max(cos_t, 1.0e-12));
    f.reflectance = fresnel_dielectric(abs(wo.z), b.eta).reflectance;
    float across = sqrt(max(1.0 - wo.y * wo.y / (b.eta * b.eta), 1.0e-12));
    f.transmittance = exp(-b.sigma_a * (2.0 * cos_t / across));
    float m = clamp(b.longitudinal_roughness, MIN_HAIR_ROUGHNESS, 1.0), m2 = m * m, m4 = m2 * m2, m16 = m4 * m4 * m4 * m4;
    float deviation = 0.726 * m + 0.812 * m2 + 3.7 * m16 * m4;
    f.variance = deviation * deviation;
    float n = clamp(b.azimuthal_roughness, MIN_HAIR_ROUGHNESS, 1.0), n2 = n * n, n4 = n2 * n2, n16 = n4 * n4 * n4 * n4;
    f.scale = 0.626657069 * (0.265 * n + 1.194 * n2 + 5.372 * n16 * n4 * n2);
    f.tilt = vec2(sqrt(max(1.0 - b.tilt_sine * b.tilt_sine, 0.0)), b.tilt_sine);
    return f;
}

// Share of the light that a lobe has.
vec3 hair_attenuation(Fiber f, uint p) {
    float entering = 1.0 - f.reflectance;
    vec3 inside = f.reflectance * f.transmittance;
    vec3 share = entering * entering * f.transmittance;
    if (p >= 2u) share *= inside;
    if (p == LAST_HAIR_LOBE) share *= inside / max(1.0 - inside, vec3(1.0e-12));
    return p == 0u ? vec3(f.reflectance) : share;
}

// Share of the light that all lobes have.
vec3 hair_albedo(Fiber f) {
    float entering = 1.0 - f.reflectance;
    return f.reflectance + entering * entering * f.transmittance / max(1.0 - f.reflectance * f.transmittance, vec3(1.0e-12));
}

// The scales turn the lobes by -2, 1 and 4 times their angle.
HairLobe hair_lobe(Fiber f, uint p) {
    vec2 twice = complex_product(f.tilt, f.tilt);
    vec2 turn = p == 0u ? vec2(twice.x, -twice.y) : p == 1u ? f.tilt : p == 2u ? complex_product(twice, twice) : vec2(1.0, 0.0);
    vec2 turned = complex_product(vec2(f.cos_theta, f.sin_theta), turn);
    float variance = f.variance * (p == 0u ? 1.0 : p == 1u ? 0.25 : 4.0);
    return HairLobe(vec2(abs(turned.x), turned.y), variance, float(p) * (2.0 * f.gamma_t + PI) - f.gamma);
}

// exp(-x) I0(x) for x >= 0, with the modified Bessel function (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2). The error is 2e-7.
float scaled_bessel_i0(float x) {
    float t = x / 3.75;
    if (t < 1.0) {
        t *= t;
        float i0 = 0.2659732 + t * (0.0360768 + t * 0.0045813);
        return exp(-x) * (1.0 + t * (3.5156229 + t * (3.0899424 + t * (1.2067492 + t * i0))));
    }
    t = 1.0 / t;
    float series = 0.00916281 + t * (-0.02057706 + t * (0.02635537 + t * (-0.01647633 + t * 0.00392377)));
    return inversesqrt(x) * (0.39894228 + t * (0.01328592 + t * (0.00225319 + t * (-0.00157565 + t * series))));
}

// Density of a lobe along the fiber (d'Eon et al. 2011, equation 7), in a form that does not overflow: per unit of the sine.
float longitudinal_density(HairLobe lobe, vec3 wi) {
    float cos_theta = length(wi.xz);
    vec2 off = vec2(cos_theta - lobe.mirrored.x, wi.y + lobe.mirrored.y);
    float v = lobe.variance;
    return scaled_bessel_i0(cos_theta * lobe.mirrored.x / v) * exp(-0.5 * dot(off, off) / v) / (v * (1.0 - exp(-2.0 / v)));
}

// Density of a lobe around the fiber: a logistic distribution, cut off at half a turn; per radian.
float azimuthal_density(Fiber f, HairLobe lobe, float angle) {
    float off = (angle - lobe.center) * INV_TWO_PI;
    off = abs(off - floor(off + 0.5)) * (2.0 * PI);
    float at = exp(-off / f.scale), end = exp(-PI / f.scale);
    return at * (1.0 + end) / (f.scale * (1.0 + at) * (1.0 + at) * (1.0 - end));
}

// Value times cosine, and as the fourth number the density of the samples.
vec4 hair_value_and_density(Hair b, vec3 wo, vec3 wi) {
    Fiber f = fiber_of(b, wo);
    float angle = angle_around_fiber(wi);
    vec4 sum = vec4(0.0);
    for (uint p = 0u; p <= LAST_HAIR_LOBE; ++p) {
        HairLobe lobe = hair_lobe(f, p);
        vec3 share = hair_attenuation(f, p);
        float around = p == LAST_HAIR_LOBE ? INV_TWO_PI : azimuthal_density(f, lobe, angle);
        sum += vec4(share, mean_rgb(share)) * (longitudinal_density(lobe, wi) * around);
    }
    sum.a /= max(mean_rgb(hair_albedo(f)), 1.0e-20);
    return sum;
}

// Samples a lobe. u.z selects it, and what is left of u.z draws the angle around the fiber.
BsdfSample sample_bsdf_hair(Hair b, vec3 wo, vec3 u) {
    Fiber f = fiber_of(b, wo);
    float left = u.z * mean_rgb(hair_albedo(f));
    uint p = 0u;
    for (uint next = 1u; next <= LAST_HAIR_LOBE; ++next) {
        float share = mean_rgb(hair_attenuation(f, p));
        if (p + 1u == next && left >= share) {
            left -= share;
            p = next;
        }
    }
    left = clamp(left / max(mean_rgb(hair_attenuation(f, p)), 1.0e-20), 0.0, 1.0);
    HairLobe lobe = hair_lobe(f, p);

    // d'Eon 2013, "Importance Sampling for Physically-Based Hair Fiber Models".
    float from_axis = -lobe.variance * log(max(u.x + (1.0 - u.x) * exp(-2.0 / lobe.variance), 1.0e-20));
    from_axis = clamp(from_axis, 0.0, 2.0);
    float sine = sqrt(from_axis * (2.0 - from_axis));
    float sin_theta = (from_axis - 1.0) * lobe.mirrored.y + sine * sin_cos_turn(u.y).y * lobe.mirrored.x;
    sin_theta = clamp(sin_theta, -1.0, 1.0);

    float end = exp(-PI / f.scale);
    float odds = max(left * (1.0 - end) + end, 1.0e-20) / max(1.0 - left * (1.0 - end), 1.0e-20);
    float off = clamp(f.scale * log(odds), -PI, PI) * INV_TWO_PI;
    vec2 around = sin_cos_turn(p == LAST_HAIR_LOBE ? left : lobe.center * INV_TWO_PI + off);
    float cos_theta = sqrt(max(1.0 - sin_theta * sin_theta, 0.0));
    return BsdfSample(vec3(-cos_theta * around.x, sin_theta, cos_theta * around.y), LOBE_GLOSSY, vec3(0.0), 1.0);
}

float pdf_bsdf_hair(Hair b, vec3 wo, vec3 wi) {
    return hair_value_and_density(b, wo, wi).a;
}

vec3 eval_bsdf_hair(Hair b, vec3 wo, vec3 wi) {
    return hair_value_and_density(b, wo, wi).rgb;
}

// A fiber keeps samples for the side that the guide's hemisphere does not reach.
float guided_part_bsdf_hair(Hair b) {
    if (GUIDE_SET == GUIDE_SET_ALL) return 0.5;
    return 0.0;
}

// Albedo of hair of many such fibers: the inverse of the fit of Chiang et al. (2016, equation 9).
vec3 albedo_of_hair(Hair b) {
    float n = b.azimuthal_roughness;
    float depth = 5.969 + n * (-0.215 + n * (2.532 + n * (-10.73 + n * (5.574 + n * 0.245))));
    return exp(-depth * sqrt(b.sigma_a));
}

#endif
