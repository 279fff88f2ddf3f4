//! Camera for a scene without a `<sensor>`.

use std::path::Path;

use glam::{Mat4, Vec2, Vec3};

use super::sensor::{DEFAULT_FILM, Sensor};
use crate::scene::description::origin::Format;
use crate::scene::{Camera, FovAxis, Projection};
use crate::{Error, Result};

/// Field of view of a fitted camera, in degrees: horizontal as in Mitsuba 0.6, or along the shorter side of the film.
const FOV: f32 = 45.0;

/// Direction of a camera that is fitted to a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum View {
    /// Along `+z`, as Mitsuba 0.6 makes a camera where a scene has none.
    Mitsuba,
    /// Along `-z`, a little from above: the front of a glTF model.
    Front,
}

/// Height over depth of the view from the front.
const RISE: f32 = 0.25;

impl View {
    /// Direction for a scene of that format.
    fn of(format: Format) -> Self {
        match format {
            Format::Xml | Format::Dictionary => Self::Mitsuba,
            Format::Foreign => Self::Front,
        }
    }

    /// Orthonormal axes of the camera: left, up and forward.
    fn axes(self) -> [Vec3; 3] {
        match self {
            Self::Mitsuba => [Vec3::X, Vec3::Y, Vec3::Z],
            Self::Front => {
                let forward = Vec3::new(0.0, -RISE, -1.0).normalize();
                [Vec3::NEG_X, forward.cross(Vec3::NEG_X), forward]
            }
        }
    }
}

/// Sensor that sees the whole scene, whose box is given, with `+y` up. It is as far away from the scene's bounding box as the largest side of the box
/// needs.
pub(super) fn sensor(
    path: &Path,
    bounds: Option<(Vec3, Vec3)>,
    format: Format,
    warnings: &mut Vec<String>,
) -> Result<Sensor> {
    let view = View::of(format);
    let (low, high) = bounds.ok_or_else(|| {
        let sensor = format.word("sensor");
        Error::scene(path, None, format!("the scene has neither a {sensor} nor a shape; give it a camera or a shape"))
    })?;
    let largest = (high - low).max_element();
    let distance = largest / (2.0 * (0.5 * FOV).to_radians().tan());
    let center = 0.5 * (low + high);
    let [left, up, forward] = view.axes();
    let eye = match view {
        View::Mitsuba => Vec3::new(center.x, center.y, low.z - distance),
        View::Front => center - (0.5 * (high.z - low.z) + distance) * forward,
    };
    let camera = Camera {
        projection: Projection::Perspective,
        world_from_camera: Mat4::from_cols(left.extend(0.0), up.extend(0.0), forward.extend(0.0), eye.extend(1.0)),
        fov: FOV,
        fov_axis: if view == View::Mitsuba { FovAxis::X } else { FovAxis::Smaller },
        principal_point: Vec2::ZERO,
        near_clip: distance / 100.0,
        far_clip: 5.0 * largest + distance,
    };
    if !(eye.is_finite() && camera.near_clip > 0.0 && camera.far_clip.is_finite()) {
        return Err(Error::scene(path, None, "no camera fits around the scene; give it a camera"));
    }
    let (Vec3 { x, y, z }, direction) = (eye, if view == View::Mitsuba { "+z" } else { "-z" });
    let message = format!("a camera at ({x}, {y}, {z}) that looks along {direction} was fitted to the scene");
    warnings.push(format!("{}: {message}", path.display()));
    Ok(Sensor { camera, motion: None, shutter: [0.0; 2], film: DEFAULT_FILM, sample_count: None, medium: None })
}
