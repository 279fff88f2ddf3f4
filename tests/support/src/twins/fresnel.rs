//! Twin of `fresnel_conductor` in `glsl/include/math/fresnel.glsl`. Dielectrics are in [`lodestar::math::fresnel`].

use glam::DVec3;

/// Reflectance of a metal of complex index eta - ik, per channel, by Fresnel's equations for unpolarized light.
pub fn fresnel_conductor(cos_i: f64, eta: DVec3, k: DVec3) -> DVec3 {
    let channel = |i: usize| fresnel_conductor_channel(cos_i, eta[i], k[i]);
    DVec3::new(channel(0), channel(1), channel(2))
}

/// Reflectance of one channel, by complex arithmetic: `q = sqrt(n^2 - sin^2)` is n times the cosine in the metal.
fn fresnel_conductor_channel(cos_i: f64, eta: f64, k: f64) -> f64 {
    let (n2_re, n2_im) = (eta * eta - k * k, -2.0 * eta * k);
    let (q_re, q_im) = complex_sqrt(n2_re - (1.0 - cos_i * cos_i), n2_im);
    let ratio2 = |a: (f64, f64), b: (f64, f64)| {
        let denominator = b.0 * b.0 + b.1 * b.1;
        if denominator == 0.0 { 1.0 } else { (a.0 * a.0 + a.1 * a.1) / denominator }
    };
    let s = ratio2((cos_i - q_re, -q_im), (cos_i + q_re, q_im));
    let (n2c_re, n2c_im) = (n2_re * cos_i, n2_im * cos_i);
    let p = ratio2((n2c_re - q_re, n2c_im - q_im), (n2c_re + q_re, n2c_im + q_im));
    0.5 * (s + p)
}

/// Complex square root with a real part >= 0.
pub(super) fn complex_sqrt(re: f64, im: f64) -> (f64, f64) {
    let modulus = re.hypot(im);
    let root_re = (0.5 * (modulus + re)).max(0.0).sqrt();
    let root_im = (0.5 * (modulus - re)).max(0.0).sqrt();
    (root_re, root_im.copysign(im))
}
