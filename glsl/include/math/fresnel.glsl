// Fresnel reflectance of unpolarized light.
#ifndef FRESNEL_GLSL
#define FRESNEL_GLSL

// Reflection and refraction of light from one direction at a smooth surface between two dielectrics.
struct DielectricInterface {
    float reflectance;
    float cos_t;  // cosine of the transmitted direction, >= 0; zero where all light is reflected
    float eta;    // refractive index behind the surface over the index in front of it
};

// Fresnel equations of a dielectric. `cos_i` is negative where the light comes from the inside. `eta` is interior over
// exterior.
DielectricInterface fresnel_dielectric(float cos_i, float eta) {
    float relative = cos_i >= 0.0 ? eta : 1.0 / eta;
    // At exactly grazing incidence both ratios would be 0 / 0 where the index behind the surface is not larger.
    float c = max(abs(cos_i), 1.0e-18);
    float g = sqrt(max(c * c + (relative - 1.0) * (relative + 1.0), 0.0));
    float s = (c - g) / (c + g);
    float p = (relative * relative * c - g) / (relative * relative * c + g);
    // Total internal reflection is set explicitly, because a device may round the quotients below 1. It may round them above 1,
    // too, and a plastic's density would be negative then.
    float reflectance = g > 0.0 ? min(0.5 * (s * s + p * p), 1.0) : 1.0;
    return DielectricInterface(reflectance, g / relative, relative);
}

// Fresnel reflectance of a metal with the complex index eta - ik. With eta = 0 all light is reflected.
vec3 fresnel_conductor(float cos_i, vec3 eta, vec3 k) {
    float c2 = cos_i * cos_i;
    float s2 = max(1.0 - c2, 0.0);
    vec3 eta_k = eta * k;
    vec3 t = (eta - k) * (eta + k) - s2;
    vec3 a2_b2 = sqrt(t * t + 4.0 * eta_k * eta_k);
    // This is a^2 = (a2_b2 + t) / 2 in a form without cancellation where t < 0.
    vec3 a2 = mix(2.0 * eta_k * eta_k / max(a2_b2 - t, 1.0e-20), 0.5 * (a2_b2 + t), greaterThanEqual(t, vec3(0.0)));
    vec3 ac = 2.0 * abs(cos_i) * sqrt(a2);
    // The small number makes the quotient 1 where it would be 0 / 0: at grazing incidence on a surface that does not
    // refract, and at normal incidence on a perfect mirror.
    vec3 base_s = a2_b2 + (c2 + 1.0e-20);
    vec3 base_p = a2_b2 * c2 + (s2 * s2 + 1.0e-20);
    vec3 s = (base_s - ac) / (base_s + ac);
    vec3 p = s * (base_p - ac * s2) / (base_p + ac * s2);
    return max(0.5 * (s + p), vec3(0.0));
}

#endif
