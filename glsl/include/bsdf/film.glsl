// Thin film over facets of a metal or a dielectric. A film changes what the facets reflect; the rest passes, as it does without a film.
#ifndef BSDF_FILM_GLSL
#define BSDF_FILM_GLSL
#include "bsdf/parameters.glsl"
#include "math/fresnel.glsl"

// What a surface under a film reflects, as it is met. It means nothing without a film.
struct Filmed {
    vec3 facet;  // reflectance of the facet
    vec3 other;  // that of a principled surface's metal, or of a plastic's layer if it was smooth
};

const Filmed NO_FILMED = Filmed(vec3(0.0), vec3(0.0));

bool is_filmed(Film film) {
    return has_feature(FEATURE_FILM) && film.thickness > 0.0;
}

// A dielectric interface. Under a film, its reflectance is the mean over all wavelengths, without interference, by which lobes are chosen.
DielectricInterface filmed_interface(float cos_i, float eta, Film film) {
    DielectricInterface i = fresnel_dielectric(cos_i, eta);
    if (is_filmed(film)) {
        bool from_front = cos_i >= 0.0;
        DielectricInterface near = fresnel_dielectric(abs(cos_i), from_front ? film.eta : film.eta / eta);
        float far = fresnel_dielectric(near.cos_t, from_front ? eta / film.eta : 1.0 / film.eta).reflectance;
        float passing = 1.0 - near.reflectance;
        i.reflectance = near.reflectance + passing * passing * far / max(1.0 - near.reflectance * far, 1.0e-12);
        i.reflectance = i.cos_t > 0.0 ? min(i.reflectance, 1.0) : 1.0;
    }
    return i;
}

// Reflectance of an interface.
vec3 filmed_reflectance(DielectricInterface i, Film film, Filmed filmed) {
    return is_filmed(film) ? filmed.facet : vec3(i.reflectance);
}

#endif
