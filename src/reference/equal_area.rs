//! Twin of `glsl/include/equal_area.glsl`: the equal-area map between the square [-1, 1]^2 and the sphere.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DVec2, DVec3, dvec2, dvec3};

/// Unit direction of a point of the square.
pub fn square_to_sphere(p: DVec2) -> DVec3 {
    let a = p.abs();
    let signed_distance = 1.0 - (a.x + a.y);
    let r = 1.0 - signed_distance.abs();
    let phi = if r == 0.0 { 0.0 } else { FRAC_PI_4 * ((a.y - a.x) / r + 1.0) };
    let planar = r * (2.0 - r * r).max(0.0).sqrt();
    dvec3(
        (planar * phi.cos()).copysign(p.x),
        (planar * phi.sin()).copysign(p.y),
        (1.0 - r * r).copysign(signed_distance),
    )
}

/// Point of the square of a unit direction.
pub fn sphere_to_square(w: DVec3) -> DVec2 {
    let r = ((w.x * w.x + w.y * w.y) / (1.0 + w.z.abs())).sqrt();
    let v = r * w.y.abs().atan2(w.x.abs()) / FRAC_PI_2;
    let upper = dvec2(r - v, v);
    let p = if w.z < 0.0 { dvec2(1.0 - upper.y, 1.0 - upper.x) } else { upper };
    dvec2(p.x.copysign(w.x), p.y.copysign(w.y))
}

/// The point whose direction is opposite to that of `p`.
pub fn antipode(p: DVec2) -> DVec2 {
    sphere_to_square(-square_to_sphere(p))
}

/// Bin of a point of the square at `resolution` bins a side, row by row.
pub fn square_bin(p: DVec2, resolution: u32) -> u32 {
    let cell = |x: f64| ((0.5 * x + 0.5) * f64::from(resolution)).clamp(0.0, f64::from(resolution) - 0.5) as u32;
    cell(p.y) * resolution + cell(p.x)
}

/// Bin of a unit direction.
pub fn direction_bin(w: DVec3, resolution: u32) -> u32 {
    square_bin(sphere_to_square(w), resolution)
}

/// Direction of a bin's center.
pub fn bin_center(bin: u32, resolution: u32) -> DVec3 {
    bin_point(bin, resolution, dvec2(0.5, 0.5))
}

/// Direction of a point of a bin, given in [0, 1]^2 of that bin.
pub fn bin_point(bin: u32, resolution: u32, within: DVec2) -> DVec3 {
    let corner = dvec2(f64::from(bin % resolution), f64::from(bin / resolution));
    square_to_sphere(2.0 * (corner + within) / f64::from(resolution) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_is_invertible_and_unit() {
        for i in 0..100 {
            for j in 0..100 {
                let p = dvec2((f64::from(i) + 0.37) / 50.0 - 1.0, (f64::from(j) + 0.61) / 50.0 - 1.0);
                let w = square_to_sphere(p);
                assert!((w.length() - 1.0).abs() < 1e-12);
                assert!((sphere_to_square(w) - p).length() < 1e-9, "{p} became {}", sphere_to_square(w));
            }
        }
    }

    #[test]
    fn equal_areas_have_equal_moments() {
        // The mean of z^2 over the sphere is 1/3, and of every odd power 0: both fail for a map that is not equal-area.
        let n = 400;
        let mut moments = [0.0; 3];
        for i in 0..n * n {
            let w = bin_center(i, n);
            moments = [moments[0] + w.z * w.z, moments[1] + w.x.powi(3), moments[2] + w.x * w.x];
        }
        let mean = moments.map(|m| m / f64::from(n * n));
        assert!((mean[0] - 1.0 / 3.0).abs() < 1e-4 && mean[1].abs() < 1e-10 && (mean[2] - 1.0 / 3.0).abs() < 1e-4);
    }
}
