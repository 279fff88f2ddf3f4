//! Cameras.

use glam::{DMat4, DVec3};

use super::tokens::brief;
use super::transforms::rigid;
use super::world::Entity;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, object};
use crate::scene::description::object::{Object, Value};

/// Distance of the near plane: pbrt's rays begin at the camera.
const NEAR: f64 = 1.0e-6;
/// Distance of the far plane: pbrt has none.
const FAR: f64 = 1.0e10;
/// Largest relative difference between width and height of a pixel: files are printed with few digits.
const SQUARE: f64 = 1.0e-3;
/// pbrt's default distance of the plane in focus.
const FOCUS: f64 = 1.0e6;

/// Sensor of a camera for a film of `width` x `height` pixels, without its film.
pub(super) fn sensor(entity: &Entity, width: i64, height: i64) -> Result<Object> {
    // Exposure is a matter of the film, and nothing moves.
    entity.parameters.ignore(&["shutteropen", "shutterclose"]);
    let (pose, scale) = rigid(&entity.to_world.inverse)
        .ok_or_else(|| entity.error("the camera's transform must neither shear nor scale unevenly"))?;
    // Mitsuba's cameras have their +x to the left.
    let pose = pose * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let window = Window::read(entity, width, height)?;
    match entity.kind.as_str() {
        "perspective" => perspective(entity, &pose, scale, &window),
        "orthographic" => orthographic(entity, &pose, scale, &window),
        other @ ("realistic" | "spherical") => {
            Err(entity.error(format!("the camera `{other}` is not supported; use `perspective` or `orthographic`")))
        }
        other => Err(entity.error(format!("the camera `{}` is not known; use `perspective`", brief(other)))),
    }
}

/// Part of the plane at depth 1 that the picture shows, before it is scaled by the field of view.
struct Window {
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
    is_default: bool,
}

impl Window {
    fn read(entity: &Entity, width: i64, height: i64) -> Result<Self> {
        let parameters = &entity.parameters;
        let pixels = width as f64 / height as f64;
        let aspect = parameters.positive("frameaspectratio", pixels)?;
        let (x, y) = if aspect > 1.0 { (aspect, 1.0) } else { (1.0, 1.0 / aspect) };
        let window = match parameters.numbers("screenwindow")? {
            None => Self { left: -x, right: x, bottom: -y, top: y, is_default: true },
            Some(&[left, right, bottom, top]) => Self { left, right, bottom, top, is_default: false },
            Some(_) => return Err(entity.error("`screenwindow` should have four numbers: left, right, bottom and top")),
        };
        let aspect = (window.right - window.left) / (window.top - window.bottom);
        match window.right > window.left && (aspect / pixels - 1.0).abs() <= SQUARE {
            true => Ok(window),
            false => Err(entity.error(format!(
                "`screenwindow` or `frameaspectratio` shows {aspect:.4} times as much in width as in height, but the film has \
                 {width}x{height} pixels; pixels must be square"
            ))),
        }
    }
}

fn perspective(entity: &Entity, pose: &DMat4, scale: f64, window: &Window) -> Result<Object> {
    let parameters = &entity.parameters;
    let fov = parameters.number("fov", 90.0)?;
    let lens = parameters.number("lensradius", 0.0)?;
    let focus = parameters.positive("focaldistance", FOCUS)?;
    if !(fov > 0.0 && fov < 180.0) {
        return Err(entity.error(format!("`fov` must lie between 0 and 180 degrees, not {fov}")));
    }
    if lens < 0.0 {
        return Err(entity.error(format!("`lensradius` must not be negative, as {lens} is")));
    }
    let plugin = if lens > 0.0 { "thinlens" } else { "perspective" };
    let mut sensor = posed(plugin, pose);
    if window.is_default {
        // The angle belongs to the shorter side.
        sensor = sensor.with("fov", Value::Float(fov));
        sensor = sensor.with("fov_axis", Value::Text("smaller".into()));
    } else {
        let half = 0.5 * (window.right - window.left) * (0.5 * fov.to_radians()).tan();
        sensor = sensor.with("fov", Value::Float((2.0 * half.atan()).to_degrees()));
        let across = 0.5 + window.left / (window.right - window.left);
        let down = 0.5 - window.top / (window.top - window.bottom);
        let is_centered = across.abs() < SQUARE && down.abs() < SQUARE;
        if plugin == "thinlens" && !is_centered {
            return Err(entity.error("a `screenwindow` beside the center is not supported with a `lensradius`"));
        }
        if !is_centered {
            sensor = sensor.with("principal_point_offset_x", Value::Float(across));
            sensor = sensor.with("principal_point_offset_y", Value::Float(down));
        }
    }
    if lens > 0.0 {
        sensor = sensor.with("aperture_radius", Value::Float(lens * scale));
        sensor = sensor.with("focus_distance", Value::Float(focus * scale));
    }
    Ok(sensor)
}

fn orthographic(entity: &Entity, pose: &DMat4, scale: f64, window: &Window) -> Result<Object> {
    let parameters = &entity.parameters;
    if parameters.number("lensradius", 0.0)? > 0.0 {
        return Err(entity.error("an `orthographic` camera with a lens is not supported; remove `lensradius`"));
    }
    parameters.ignore(&["focaldistance", "fov"]);
    let center = DVec3::new(-0.5 * (window.left + window.right), 0.5 * (window.bottom + window.top), 0.0) * scale;
    let half = 0.5 * (window.right - window.left) * scale;
    let pose = *pose * DMat4::from_translation(center) * DMat4::from_scale(DVec3::new(half, half, 1.0));
    Ok(posed("orthographic", &pose))
}

fn posed(plugin: &'static str, pose: &DMat4) -> Object {
    let entries = [("to_world", matrix(pose)), ("near_clip", Value::Float(NEAR)), ("far_clip", Value::Float(FAR))];
    object(Kind::Sensor, plugin, entries)
}
