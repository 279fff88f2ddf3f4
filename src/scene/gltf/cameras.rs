//! Cameras to sensors.

use gltf::camera::{Camera, Projection};
use glam::{DMat4, DVec3};

use super::entries::{matrix, number, object, text};
use crate::scene::mitsuba::dictionary::{Dictionary, Value};

/// Height of the film, and its width where a camera gives no aspect ratio.
const HEIGHT: i64 = 720;
const WIDTH: i64 = 1280;
const MAX_WIDTH: f32 = 16384.0;

/// Sensor of a camera at `world`. A camera of glTF looks along `-z`, with `+x` to the right.
pub(super) fn sensor(camera: &Camera, world: DMat4) -> Dictionary {
    let turned = DMat4::from_scale(DVec3::new(-1.0, 1.0, -1.0));
    let unscaled = without_scale(world) * turned;
    match camera.projection() {
        Projection::Perspective(lens) => {
            let width = lens.aspect_ratio().filter(|aspect| *aspect > 0.0).map_or(WIDTH, |aspect| width(aspect, HEIGHT));
            let (near, far) = clips(lens.znear(), lens.zfar().unwrap_or(f32::INFINITY));
            object("perspective", [
                ("to_world", matrix(unscaled)),
                ("fov", number(lens.yfov().to_degrees())),
                ("fov_axis", text("y")),
                ("near_clip", number(near)),
                ("far_clip", number(far)),
                ("film", film(width, HEIGHT)),
            ])
        }
        Projection::Orthographic(lens) => {
            let (x, y) = (lens.xmag().abs(), lens.ymag().abs());
            let scale = DMat4::from_scale(DVec3::new(f64::from(x), f64::from(x), 1.0));
            let (near, far) = clips(lens.znear(), lens.zfar());
            object("orthographic", [
                ("to_world", matrix(unscaled * scale)),
                ("near_clip", number(near)),
                ("far_clip", number(far)),
                ("film", film(width(x / y, HEIGHT), HEIGHT)),
            ])
        }
    }
}

fn width(aspect: f32, height: i64) -> i64 {
    (aspect * height as f32).round().clamp(1.0, MAX_WIDTH) as i64
}

/// Clipping distances that the reader of sensors takes.
fn clips(near: f32, far: f32) -> (f32, f32) {
    let near = if near > 0.0 { near } else { 1e-4 };
    (near, if far.is_finite() && far > near { far } else { near * 1e7 })
}

fn film(width: i64, height: i64) -> Value {
    Value::Object(object("hdrfilm", [("width", Value::Integer(width)), ("height", Value::Integer(height))]))
}

/// Matrix whose axes have length 1, with the translation kept.
pub(super) fn without_scale(matrix: DMat4) -> DMat4 {
    let axis = |column: glam::DVec4| column.truncate().normalize_or_zero().extend(0.0);
    DMat4::from_cols(axis(matrix.x_axis), axis(matrix.y_axis), axis(matrix.z_axis), matrix.w_axis)
}
