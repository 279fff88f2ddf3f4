// Interference of light in a thin film, in linear sRGB (Belcour and Barla 2017).
#ifndef THIN_FILM_GLSL
#define THIN_FILM_GLSL
#include "math/constants.glsl"

// Curves of red, green and blue over the wavenumber in 1 / um, as sums of Gaussians: their centers, twice the squares of pi times their
// standard deviations, and their areas in each color. A color's areas have the sum 1, so that what is equal at all wavelengths is white.
// tests/data/film/make.py fits them to the CIE 1931 standard observer.
const vec4 FILM_CENTERS = vec4(1.64365, 1.76611, 1.84147, 2.21685);
const vec4 FILM_SPREADS = vec4(0.108835, 0.223225, 0.314455, 0.244996);
const mat4x3 FILM_AREAS = mat4x3(
    1.21493, -0.30212, 0.01404,
    0.87388, 0.28366, -0.11792,
    -1.16419, 1.13789, -0.04700,
    0.07538, -0.11943, 1.15088);

// Number of terms of the sum over differences between light paths. tests/samplers/film.rs holds what four leave out.
const int FILM_TERMS = 4;

// Products of complex numbers.
void multiply_complex(inout vec3 real, inout vec3 imaginary, vec3 by_real, vec3 by_imaginary) {
    vec3 product = real * by_real - imaginary * by_imaginary;
    imaginary = real * by_imaginary + imaginary * by_real;
    real = product;
}

// Part of the light's path in a film for one polarization.
struct FilmPolarization {
    vec3 real;       // product of what the film's bottom reflects upwards, and its top downwards: complex amplitudes
    vec3 imaginary;
    vec3 mean;       // share of light that is reflected without interference
    vec3 swing;      // factor of the interference
};

// The film's top reflects the amplitude `top`, its bottom the quotient (x - y) / (x + y) of complex numbers.
FilmPolarization film_polarization(float top, vec3 x_real, vec3 x_imaginary, vec3 y_real, vec3 y_imaginary) {
    vec3 sum_real = x_real + y_real;
    vec3 sum_imaginary = x_imaginary + y_imaginary;
    vec3 scale = 1.0 / max(sum_real * sum_real + sum_imaginary * sum_imaginary, vec3(1.0e-20));
    vec3 real = (x_real * x_real + x_imaginary * x_imaginary - y_real * y_real - y_imaginary * y_imaginary) * scale;
    vec3 imaginary = 2.0 * (x_imaginary * y_real - x_real * y_imaginary) * scale;
    vec3 bottom = min(real * real + imaginary * imaginary, vec3(1.0));
    float passing = 1.0 - top * top;
    vec3 from_below = passing * passing * bottom / max(1.0 - top * top * bottom, vec3(1.0e-12));
    return FilmPolarization(-top * real, -top * imaginary, top * top + from_below, from_below - passing);
}

// Reflectance of a film over a base with the complex index eta + ik. Indices are over that of the space above. `cos_theta` is the cosine
// there, and the thickness is in nanometers. The sum is that of Belcour and Barla's equation 10, with complex amplitudes in place of phases.
vec3 film_reflectance(float cos_theta, float film_eta, float thickness, vec3 eta, vec3 k) {
    float sin2 = max(1.0 - cos_theta * cos_theta, 0.0);
    float inside = sqrt(max(film_eta * film_eta - sin2, 0.0));  // the film's index times the cosine in it
    float cos_film = inside / film_eta;
    vec2 cosines = vec2(cos_theta, film_eta * cos_theta);
    vec2 below = vec2(inside, cos_film);
    vec2 top = (cosines - below) / max(cosines + below, vec2(1.0e-20));
    // Square of the base's index, and the root of it less the square of the sine.
    vec3 square = (eta - k) * (eta + k);
    vec3 loss = 2.0 * abs(eta * k);
    vec3 t = square - sin2;
    vec3 size = sqrt(t * t + loss * loss);
    vec3 root = sqrt(max(0.5 * (size + t), vec3(0.0)));
    vec3 root_loss = sqrt(max(0.5 * (size - t), vec3(0.0)));
    FilmPolarization s = film_polarization(top.x, vec3(inside), vec3(0.0), root, root_loss);
    FilmPolarization p = film_polarization(top.y, square * cos_film, loss * cos_film, film_eta * root, film_eta * root_loss);
    // Difference between the paths of light that enters the film once more and light that does not, in micrometers.
    float path = 2.0e-3 * thickness * inside;
    vec3 sum = 0.5 * (s.mean + p.mean);
    vec3 s_real = s.real;
    vec3 s_imaginary = s.imaginary;
    vec3 p_real = p.real;
    vec3 p_imaginary = p.imaginary;
    for (int m = 1; m <= FILM_TERMS; ++m) {
        vec4 seen = exp(-FILM_SPREADS * (float(m * m) * path * path));
        vec4 angle = 2.0 * PI * fract(FILM_CENTERS * (float(m) * path));
        vec3 seen_real = FILM_AREAS * (seen * cos(angle));
        vec3 seen_imaginary = FILM_AREAS * (seen * sin(angle));
        sum += s.swing * (s_real * seen_real - s_imaginary * seen_imaginary);
        sum += p.swing * (p_real * seen_real - p_imaginary * seen_imaginary);
        multiply_complex(s_real, s_imaginary, s.real, s.imaginary);
        multiply_complex(p_real, p_imaginary, p.real, p.imaginary);
    }
    return clamp(sum, 0.0, 1.0);
}

// Real and imaginary part of the index of a metal with these reflectances at normal incidence (Gulbrandsen 2014). The reflectance at 82
// degrees is that of Schlick's formula.
mat2x3 metal_index(vec3 reflectance) {
    vec3 r = clamp(reflectance, 0.0, 0.999);
    vec3 root = sqrt(r);
    const float edge = 0.46266436;  // (6 / 7)^5
    vec3 g = mix(r, vec3(1.0), edge);
    vec3 n = mix((1.0 + root) / (1.0 - root), (1.0 - r) / (1.0 + r), g);
    vec3 k2 = (r * (n + 1.0) * (n + 1.0) - (n - 1.0) * (n - 1.0)) / (1.0 - r);
    return mat2x3(n, sqrt(max(k2, vec3(0.0))));
}

#endif
