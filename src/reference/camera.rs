//! Twin of `glsl/include/camera.glsl`.

use std::f64::consts::TAU;

use glam::{DVec2, DVec4, Vec2, Vec4, dvec2};

use super::intersect::Ray;
use crate::layout::SceneConstants;

/// Inverse of the cumulative tent on [-1, 1].
pub fn sample_tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// A Gaussian of unit deviation, cut off at a distance of four.
pub fn sample_gaussian(u: DVec2) -> DVec2 {
    let inside = 1.0 - (-8.0_f64).exp();
    let radius = (-2.0 * (-inside * u.x).ln_1p()).sqrt();
    radius * dvec2((TAU * u.y).cos(), (TAU * u.y).sin())
}

/// The ray through `position`, in film pixels from the top left.
pub fn camera_ray(scene: &SceneConstants, position: DVec2) -> Ray {
    let two = |v: [f32; 2]| Vec2::from(v).as_dvec2();
    let screen = 1.0 - 2.0 * (position / two(scene.film_size) + two(scene.principal_point));
    // From the eye to the plane at depth 1.
    let local = (screen * two(scene.raster_scale)).extend(1.0);
    let rows = scene.world_from_camera.map(|row| Vec4::from(row).as_dvec4());
    let to_world = |v: DVec4| rows.map(|row| row.dot(v)).into();
    let (eye, direction): (glam::DVec3, glam::DVec3) = (to_world(DVec4::W), to_world(local.extend(0.0)));
    let (near, far) = (f64::from(scene.near_clip), f64::from(scene.far_clip));
    let (direction, length) = (direction.normalize(), local.length());
    Ray { origin: eye + near * length * direction, direction, t_max: (far - near) * length }
}
