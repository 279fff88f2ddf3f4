//! Camera for a scene without a `<sensor>`.

use std::path::Path;

use glam::{Mat4, Vec2, Vec3};

use super::sensor::{DEFAULT_FILM, Sensor};
use crate::scene::{Camera, FovAxis, Primitive, Projection};
use crate::{Error, Result};

/// Horizontal field of view of a fitted camera, in degrees.
const FOV: f32 = 45.0;

/// Sensor for a scene that has none, as Mitsuba 0.6 makes it: it stands before the scene on the side of smaller `z`, looks
/// along `+z` with `+y` up, and is as far away as the largest side of the scene's bounding box needs.
pub(super) fn sensor(path: &Path, primitives: &[Primitive], warnings: &mut Vec<String>) -> Result<Sensor> {
    let boxes = primitives.iter().map(Primitive::bounds);
    let (low, high) = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).ok_or_else(|| {
        Error::scene(path, None, "the scene has neither a <sensor> nor a shape; give it a `perspective` sensor")
    })?;
    let largest = (high - low).max_element();
    let distance = largest / (2.0 * (0.5 * FOV).to_radians().tan());
    let center = 0.5 * (low + high);
    let eye = Vec3::new(center.x, center.y, low.z - distance);
    let camera = Camera {
        projection: Projection::Perspective,
        world_from_camera: Mat4::from_translation(eye),
        fov: FOV,
        fov_axis: FovAxis::X,
        principal_point: Vec2::ZERO,
        near_clip: distance / 100.0,
        far_clip: 5.0 * largest + distance,
    };
    if !(eye.is_finite() && camera.near_clip > 0.0 && camera.far_clip.is_finite()) {
        return Err(Error::scene(path, None, "no camera fits around the scene; give it a <sensor>"));
    }
    let Vec3 { x, y, z } = eye;
    let message = format!("the scene has no <sensor>; a camera at ({x}, {y}, {z}) that looks along +z is used");
    warnings.push(format!("{}: {message}", path.display()));
    Ok(Sensor { camera, film: DEFAULT_FILM, sample_count: None })
}
