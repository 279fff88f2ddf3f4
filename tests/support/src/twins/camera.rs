//! Twin of `glsl/include/film/camera.glsl`.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use glam::{DVec2, DVec3, Vec2, Vec4, dvec2, dvec3};
use lodestar::generated::constants;
use lodestar::generated::layout::SceneConstants;
use lodestar::math::equal_area::square_to_sphere;

use super::intersect::Ray;

/// Inverse of the cumulative tent on [-1, 1].
pub fn sample_tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// Gaussian of unit standard deviation, cut off at a distance of four.
pub fn sample_gaussian(u: DVec2) -> DVec2 {
    let inside = 1.0 - (-8.0_f64).exp();
    let radius = (-2.0 * (-inside * u.x).ln_1p()).sqrt();
    radius * dvec2((TAU * u.y).cos(), (TAU * u.y).sin())
}

/// Uniform point of the unit disk. The disk's sectors are the square's four triangles (Shirley and Chiu 1997).
pub fn concentric_disk(u: DVec2) -> DVec2 {
    let p = 2.0 * u - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (radius, angle) =
        if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * p.y / p.x) } else { (p.y, FRAC_PI_2 - FRAC_PI_4 * p.x / p.y) };
    radius * dvec2(angle.cos(), angle.sin())
}

/// Ray of a `CAMERA_*` through `position`, in film pixels from the top left. `u` chooses a point of the lens.
pub fn camera_ray(camera: u32, scene: &SceneConstants, position: DVec2, u: DVec2) -> Ray {
    let two = |v: [f32; 2]| Vec2::from(v).as_dvec2();
    let screen = 1.0 - 2.0 * (position / two(scene.film_size) + two(scene.principal_point));
    let on_screen = screen * two(scene.raster_scale);
    let (near, far) = (f64::from(scene.near_clip), f64::from(scene.far_clip));
    let rows = scene.world_from_camera.map(|row| Vec4::from(row).as_dvec4());
    let point = |p: DVec3| DVec3::from(rows.map(|row| row.dot(p.extend(1.0))));
    let vector = |v: DVec3| DVec3::from(rows.map(|row| row.dot(v.extend(0.0))));
    if camera == constants::CAMERA_ORTHOGRAPHIC {
        let direction = vector(DVec3::Z).normalize();
        return Ray { origin: point(on_screen.extend(near)), direction, t_max: far - near };
    }
    let at = position / two(scene.film_size);
    let around = match camera {
        constants::CAMERA_EQUIRECTANGULAR => {
            let [longitude, latitude] =
                (two(scene.principal_point) + at * two(scene.raster_scale)).to_array().map(|angle| TAU * angle);
            Some(dvec3(-longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos()))
        }
        constants::CAMERA_EQUAL_AREA => {
            let up_is_z = square_to_sphere(2.0 * at - 1.0);
            Some(dvec3(-up_is_z.x, up_is_z.z, up_is_z.y))
        }
        _ => None,
    };
    if let Some(local) = around {
        let direction = vector(local);
        return Ray { origin: point(near * local), direction, t_max: far - near };
    }
    let (focus, radius) = match camera {
        constants::CAMERA_THINLENS => (f64::from(scene.focus_distance), f64::from(scene.aperture_radius)),
        _ => (1.0, 0.0),
    };
    // The ray goes from a point of the lens to the point where the ray through the lens's center meets the plane in
    // focus.
    let lens = (radius * concentric_disk(u)).extend(0.0);
    let local = (focus * on_screen.extend(1.0) - lens).normalize();
    Ray { origin: point(lens + near / local.z * local), direction: vector(local), t_max: (far - near) / local.z }
}
