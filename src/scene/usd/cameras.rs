//! Cameras.

use std::collections::HashSet;

use glam::{DMat4, DVec3};

use super::asset::Prim;
use super::transforms::{rigid, turned};
use super::values;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, nested, object};
use crate::scene::description::object::{Object, Value};

/// Height of the film in pixels; its width follows from the aperture.
const FILM_HEIGHT: f64 = 720.0;
/// Units of the scene for one of the aperture and of the focal length.
const UNIT: f64 = 0.1;

/// Cameras of the scene, in the order of their prims.
#[derive(Default)]
pub(super) struct Cameras {
    sensors: Vec<(String, Object)>,
}

impl Cameras {
    /// Adds the camera of a prim.
    pub fn add(&mut self, prim: &Prim, world: &DMat4) -> Result<()> {
        let positive = |name: &str, default: f64| -> Result<Option<f64>> {
            Ok(Some(prim.number(name, default)?).filter(|value| *value > 0.0))
        };
        let width = positive("horizontalAperture", 20.955)?.unwrap_or(20.955);
        let height = positive("verticalAperture", 15.2908)?.unwrap_or(15.2908);
        let focal_length = positive("focalLength", 50.0)?.unwrap_or(50.0);
        let aspect = (width / height).clamp(0.01, 100.0);
        let range = prim.read("clippingRange", values::pairs)?.and_then(|list| list.first().copied());
        let [near, far] = range.unwrap_or([1.0, 1.0e6]);
        let near = if near.is_finite() { near.max(1.0e-6) } else { 1.0e-6 };
        let far = if far > near && far < 1.0e30 { far } else { near * 1.0e9 };
        let offsets = [
            prim.number("horizontalApertureOffset", 0.0)? / width,
            prim.number("verticalApertureOffset", 0.0)? / height,
        ];
        let pose = turned(&rigid(world));
        let mut entries = vec![("near_clip", Value::Float(near)), ("far_clip", Value::Float(far))];
        let plugin = match prim.text("projection")?.as_deref() {
            Some("orthographic") => {
                let half = 0.5 * UNIT * width;
                let shift = DVec3::new(-offsets[0] * 2.0 * half, offsets[1] * 2.0 * half / aspect, 0.0);
                let frame = DMat4::from_translation(shift) * DMat4::from_scale(DVec3::new(half, half, 1.0));
                entries.push(("to_world", matrix(&(pose * frame))));
                "orthographic"
            }
            _ => {
                let fov = 2.0 * (0.5 * width / focal_length).atan();
                entries.push(("to_world", matrix(&pose)));
                entries.push(("fov", Value::Float(fov.to_degrees().clamp(1.0e-3, 179.9))));
                entries.push(("fov_axis", Value::Text("x".into())));
                entries.push(("principal_point_offset_x", Value::Float(offsets[0])));
                entries.push(("principal_point_offset_y", Value::Float(-offsets[1])));
                let stop = positive("fStop", 0.0)?;
                match (stop, positive("focusDistance", 0.0)?) {
                    (Some(stop), Some(distance)) => {
                        entries.push(("aperture_radius", Value::Float(UNIT * focal_length / (2.0 * stop))));
                        entries.push(("focus_distance", Value::Float(distance)));
                        "thinlens"
                    }
                    _ => "perspective",
                }
            }
        };
        if prim.read("clippingPlanes", |value| Some(value.clone()))?.is_some_and(|value| has_elements(&value)) {
            prim.asset.warn_of(&prim.path, "its clipping planes are not rendered");
        }
        let is_exposed = prim.names().any(|name| name.starts_with("exposure:"));
        if is_exposed || prim.number("exposure", 0.0)? != 0.0 {
            prim.asset.warn_of(&prim.path, "its exposure is ignored; choose one for the picture");
        }
        let film = object(
            Kind::Film,
            "hdrfilm",
            [
                ("width", Value::Integer((FILM_HEIGHT * aspect).round().max(1.0) as i64)),
                ("height", Value::Integer(FILM_HEIGHT as i64)),
            ],
        );
        let sensor = entries
            .into_iter()
            .fold(object(Kind::Sensor, plugin, []), |sensor, (name, value)| sensor.with(name, value));
        self.sensors.push((prim.name().to_owned(), sensor.with("film", nested(film))));
        Ok(())
    }

    /// Number of cameras.
    pub fn len(&self) -> usize {
        self.sensors.len()
    }

    /// Forgets the cameras after the first ones.
    pub fn truncate(&mut self, count: usize) {
        self.sensors.truncate(count);
    }

    pub fn is_empty(&self) -> bool {
        self.sensors.is_empty()
    }

    /// All cameras with the keys of their entries. The `id` of a camera is its name, with a number where another has that name.
    pub fn into_objects(self, mut ids: HashSet<String>) -> Vec<(String, Object)> {
        let sensors = self.sensors.into_iter().enumerate();
        sensors
            .map(|(index, (name, sensor))| {
                let mut id = name.clone();
                let mut number = index;
                while id.is_empty() || !ids.insert(id.clone()) {
                    id = format!("{name}{number}");
                    number += 1;
                }
                (format!("sensor{index}"), sensor.with_id(id))
            })
            .collect()
    }
}

fn has_elements(value: &openusd::sdf::Value) -> bool {
    matches!(value, openusd::sdf::Value::Vec4fVec(list) if !list.is_empty())
}
