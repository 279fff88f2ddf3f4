//! Cameras.

use glam::{DMat4, DVec3};

use super::tokens::brief;
use super::transforms::{Current, rigid};
use super::world::{Entity, World};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::object;
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
pub(super) fn sensor(entity: &Entity, world: &World, width: i64, height: i64) -> Result<Object> {
    let pose = |current: &Current| {
        let (pose, scale) = rigid(&current.inverse)
            .ok_or_else(|| entity.error("the camera's transform must neither shear nor scale unevenly"))?;
        // Mitsuba's cameras have their +x to the left.
        Ok((pose * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)), scale))
    };
    let (start, scale) = pose(&entity.to_world)?;
    let end = entity.at_end.as_ref().map(pose).transpose()?;
    if end.is_some_and(|(_, other)| (other / scale - 1.0).abs() > SQUARE) {
        return Err(entity.error("the camera's transform must not change its scale while it moves"));
    }
    let pose = Pose { start, end: end.map(|(end, _)| end), world };
    let window = Window::read(entity, width, height)?;
    let sensor = projected(entity, &pose, scale, &window)?;
    // Exposure is a matter of the film.
    if !world.moves {
        entity.parameters.ignore(&["shutteropen", "shutterclose"]);
        return Ok(sensor);
    }
    let (open, close) = (entity.parameters.number("shutteropen", 0.0)?, entity.parameters.number("shutterclose", 1.0)?);
    Ok(sensor.with("shutter_open", Value::Float(open)).with("shutter_close", Value::Float(close)))
}

fn projected(entity: &Entity, pose: &Pose, scale: f64, window: &Window) -> Result<Object> {
    match entity.kind.as_str() {
        "perspective" => perspective(entity, pose, scale, window),
        "orthographic" => orthographic(entity, pose, scale, window),
        "spherical" => spherical(entity, pose),
        "realistic" => Err(entity.error("the camera `realistic` is not supported; use `perspective`")),
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

fn perspective(entity: &Entity, pose: &Pose, scale: f64, window: &Window) -> Result<Object> {
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

fn orthographic(entity: &Entity, pose: &Pose, scale: f64, window: &Window) -> Result<Object> {
    let parameters = &entity.parameters;
    if parameters.number("lensradius", 0.0)? > 0.0 {
        return Err(entity.error("an `orthographic` camera with a lens is not supported; remove `lensradius`"));
    }
    parameters.ignore(&["focaldistance", "fov"]);
    let center = DVec3::new(-0.5 * (window.left + window.right), 0.5 * (window.bottom + window.top), 0.0) * scale;
    let half = 0.5 * (window.right - window.left) * scale;
    if pose.end.is_some() && center != DVec3::ZERO {
        return Err(entity.error("an `orthographic` camera that moves needs a `screenwindow` around its center"));
    }
    Ok(posed(
        "orthographic",
        &pose.after(&(DMat4::from_translation(center) * DMat4::from_scale(DVec3::new(half, half, 1.0)))),
    ))
}

fn spherical(entity: &Entity, pose: &Pose) -> Result<Object> {
    let parameters = &entity.parameters;
    parameters.ignore(&["lensradius", "focaldistance"]);
    let sensor = posed("spherical", pose);
    match parameters.text("mapping")?.unwrap_or("equalarea") {
        "equalarea" => Ok(sensor.with("mapping", Value::Text("equal_area".into()))),
        // The picture begins on the right and runs over the front to the left.
        "equirectangular" => {
            let angles = [("longitude_min", 90.0), ("longitude_max", -270.0)];
            Ok(angles.into_iter().fold(sensor, |sensor, (name, angle)| sensor.with(name, Value::Float(angle))))
        }
        other => {
            let other = brief(other);
            Err(entity.error(format!("`mapping` is `equalarea` or `equirectangular`, not `{other}`")))
        }
    }
}

/// Place of a camera at the start and, where it moves, at the end of the motion.
struct Pose<'w> {
    start: DMat4,
    end: Option<DMat4>,
    world: &'w World,
}

impl Pose<'_> {
    /// This place after a transform.
    fn after(&self, first: &DMat4) -> Self {
        Self { start: self.start * *first, end: self.end.map(|end| end * *first), world: self.world }
    }
}

fn posed(plugin: &'static str, pose: &Pose) -> Object {
    let to_world = pose.world.placed(&pose.start, pose.end.as_ref());
    let entries = [("to_world", to_world), ("near_clip", Value::Float(NEAR)), ("far_clip", Value::Float(FAR))];
    object(Kind::Sensor, plugin, entries)
}
