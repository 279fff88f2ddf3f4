//! Twin of `glsl/include/math/thin_film.glsl` and `bsdf/film.glsl`, with phases in place of complex amplitudes.

use std::f64::consts::PI;

use glam::DVec3;
use lodestar::math::fresnel::fresnel_dielectric;

use super::fresnel::complex_sqrt;

/// Thin film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    /// Thickness in nanometers.
    pub thickness: f64,
    /// Index of refraction over that of the space above.
    pub eta: f64,
}

/// Gaussians over the wavenumber in 1 / um: center, twice the square of pi times the standard deviation, and areas in red, green and blue.
const GAUSSIANS: [(f64, f64, [f64; 3]); 4] = [
    (1.64365, 0.108835, [1.21493, -0.30212, 0.01404]),
    (1.76611, 0.223225, [0.87388, 0.28366, -0.11792]),
    (1.84147, 0.314455, [-1.16419, 1.13789, -0.04700]),
    (2.21685, 0.244996, [0.07538, -0.11943, 1.15088]),
];
/// Differences between light paths that count.
const ORDERS: i32 = 4;

/// Largest part of the light that a film over a dielectric reflects from `wo`, and the mean by which lobes are drawn; `None` without a film.
pub fn filmed(film: Option<Film>, cosine: f64, eta: f64) -> Option<(DVec3, f64)> {
    let film = film?;
    let outside = if cosine >= 0.0 { cosine } else { fresnel_dielectric(cosine, eta).cos_t };
    Some((film.reflectance(outside, DVec3::splat(eta), DVec3::ZERO), film.mean(outside, eta)))
}

impl Film {
    /// Reflectance over a base of complex index, for light at this cosine above the film.
    pub fn reflectance(&self, cosine: f64, eta: DVec3, k: DVec3) -> DVec3 {
        let channel = |i: usize| self.channel(cosine, eta[i], k[i], i).clamp(0.0, 1.0);
        DVec3::new(channel(0), channel(1), channel(2))
    }

    /// Reflectance over a dielectric without interference.
    fn mean(&self, cosine: f64, eta: f64) -> f64 {
        if fresnel_dielectric(cosine, eta).cos_t == 0.0 || cosine == 0.0 {
            return 1.0;
        }
        let top = fresnel_dielectric(cosine, self.eta);
        let bottom = fresnel_dielectric(top.cos_t, eta / self.eta).reflectance;
        top.reflectance + (1.0 - top.reflectance).powi(2) * bottom / (1.0 - top.reflectance * bottom)
    }

    fn channel(&self, cosine: f64, eta: f64, k: f64, channel: usize) -> f64 {
        let sin2 = 1.0 - cosine * cosine;
        let inside = (self.eta * self.eta - sin2).max(0.0).sqrt();
        let cos_film = inside / self.eta;
        let path = 2.0e-3 * self.thickness * inside;
        let square = (eta * eta - k * k, 2.0 * (eta * k).abs());
        let root = complex_sqrt(square.0 - sin2, square.1);
        let scaled = |z: (f64, f64), by: f64| (by * z.0, by * z.1);
        let s = interference((cosine - inside) / (cosine + inside), quotient((inside, 0.0), root), |order, phase| {
            seen(channel, order * path, phase)
        });
        let p = interference(
            (self.eta * cosine - cos_film) / (self.eta * cosine + cos_film),
            quotient(scaled(square, cos_film), scaled(root, self.eta)),
            |order, phase| seen(channel, order * path, phase),
        );
        0.5 * (s + p)
    }
}

/// Amplitude `(x - y) / (x + y)` of complex numbers.
fn quotient(x: (f64, f64), y: (f64, f64)) -> (f64, f64) {
    let (difference, sum) = ((x.0 - y.0, x.1 - y.1), (x.0 + y.0, x.1 + y.1));
    let scale = sum.0 * sum.0 + sum.1 * sum.1;
    ((difference.0 * sum.0 + difference.1 * sum.1) / scale, (difference.1 * sum.0 - difference.0 * sum.1) / scale)
}

/// Reflectance of one polarization (Belcour and Barla 2017, equation 10). `seen` is the mean cosine of a phase that grows with the order.
fn interference(top: f64, bottom: (f64, f64), seen: impl Fn(f64, f64) -> f64) -> f64 {
    let [r12, r23] = [top * top, bottom.0 * bottom.0 + bottom.1 * bottom.1];
    let t121 = 1.0 - r12;
    if t121 <= 0.0 {
        return 1.0;
    }
    // Light in the film is reflected by its top with the other sign.
    let phase = bottom.1.atan2(bottom.0) + if top > 0.0 { PI } else { 0.0 };
    let star = t121 * t121 * r23 / (1.0 - r12 * r23);
    let order = |m: i32| 2.0 * (star - t121) * (r12 * r23).sqrt().powi(m) * seen(m.into(), f64::from(m) * phase);
    r12 + star + (1..=ORDERS).map(order).sum::<f64>()
}

/// Mean of the cosine of a path difference in micrometers, plus a phase, as it is seen in one channel.
fn seen(channel: usize, path: f64, phase: f64) -> f64 {
    let part = |(center, spread, areas): &(f64, f64, [f64; 3])| {
        areas[channel] * (-spread * path * path).exp() * (2.0 * PI * center * path + phase).cos()
    };
    GAUSSIANS.iter().map(part).sum()
}

/// Complex index of a metal with these reflectances at normal incidence (Gulbrandsen 2014), with Schlick's reflectance at 82 degrees.
pub fn metal_index(reflectance: DVec3) -> [DVec3; 2] {
    let index = |r: f64| {
        let r = r.min(0.999);
        let g = r + (1.0 - r) * (6.0_f64 / 7.0).powi(5);
        let n = g * (1.0 - r) / (1.0 + r) + (1.0 - g) * (1.0 + r.sqrt()) / (1.0 - r.sqrt());
        let k2 = (r * (n + 1.0).powi(2) - (n - 1.0).powi(2)) / (1.0 - r);
        [n, k2.max(0.0).sqrt()]
    };
    let [x, y, z] = [reflectance.x, reflectance.y, reflectance.z].map(index);
    [0, 1].map(|i| DVec3::new(x[i], y[i], z[i]))
}
