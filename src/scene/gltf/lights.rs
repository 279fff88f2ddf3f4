//! Punctual lights and cameras.

use std::collections::HashSet;

use glam::{DMat3, DMat4, DVec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::{Kind as LightKind, Light};

use super::asset::Asset;
use super::nodes::Placed;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{color, matrix, nested, number, object};
use crate::scene::description::object::{Object, Value};

/// Height of the film in pixels; its width follows from the camera's aspect ratio.
const FILM_HEIGHT: f32 = 720.0;
/// Width over height of the film of a camera that gives none.
const ASPECT: f32 = 16.0 / 9.0;
/// Distance of the far plane of a camera that gives none.
const FAR: f32 = 1.0e10;

/// Turns Mitsuba's lights and cameras, which look along `+z`, to glTF's, which look along `-z`. `+y` stays up.
fn turned(matrix: &DMat4) -> DMat4 {
    *matrix * DMat4::from_scale(DVec3::new(-1.0, 1.0, -1.0))
}

/// Emitter of a light.
pub(super) fn light(asset: &Asset, placed: &Placed, light: &Light) -> Result<Object> {
    let brightness = color(light.color().map(|channel| channel * light.intensity()));
    let world = placed.world_from_node;
    let axis = world.z_axis.truncate().normalize_or_zero();
    if axis == DVec3::ZERO {
        return Err(asset.error(format!("the node of light {} shrinks it to nothing", light.index())));
    }
    if light.range().is_some() {
        asset.warn("the `range` of lights is ignored: light reaches as far as it does in nature");
    }
    let vector = |vector: DVec3| Value::Vector(vector.to_array());
    Ok(match light.kind() {
        LightKind::Point => {
            object(Kind::Emitter, "point", [("position", vector(world.w_axis.truncate())), ("intensity", brightness)])
        }
        LightKind::Directional => {
            object(Kind::Emitter, "directional", [("direction", vector(-axis)), ("irradiance", brightness)])
        }
        LightKind::Spot { inner_cone_angle, outer_cone_angle } => {
            let outer = outer_cone_angle.clamp(1.0e-4, std::f32::consts::FRAC_PI_2);
            let pose = turned(&rigid(&world));
            let entries = [
                ("to_world", matrix(&pose)),
                ("intensity", brightness),
                ("cutoff_angle", number(outer.to_degrees())),
                ("beam_width", number(inner_cone_angle.clamp(0.0, outer).to_degrees())),
            ];
            object(Kind::Emitter, "spot", entries)
        }
    })
}

/// Cameras of the scene, in the order of their nodes.
#[derive(Default)]
pub(super) struct Cameras {
    /// Sensor of each camera with the camera's name, which may be empty.
    sensors: Vec<(String, Object)>,
}

impl Cameras {
    /// Adds the camera of a node. Its name is the node's, or else the camera's.
    pub fn add(&mut self, asset: &Asset, placed: &Placed, camera: &gltf::Camera) {
        let name = placed.node.name().or(camera.name()).unwrap_or_default();
        let pose = turned(&rigid(&placed.world_from_node));
        let (sensor, aspect) = match camera.projection() {
            Projection::Perspective(perspective) => {
                let fov = perspective.yfov().to_degrees().clamp(1.0e-3, 179.9);
                let near = perspective.znear().max(1.0e-6);
                let entries = [
                    ("to_world", matrix(&pose)),
                    ("fov", number(fov)),
                    ("fov_axis", Value::Text("y".into())),
                    ("near_clip", number(near)),
                    ("far_clip", number(perspective.zfar().filter(|far| *far > near).unwrap_or(FAR.max(2.0 * near)))),
                ];
                (object(Kind::Sensor, "perspective", entries), perspective.aspect_ratio().unwrap_or(ASPECT))
            }
            Projection::Orthographic(orthographic) => {
                let (half, height) = (orthographic.xmag().abs(), orthographic.ymag().abs());
                let scale = DMat4::from_scale(DVec3::new(f64::from(half), f64::from(half), 1.0));
                let near = orthographic.znear().max(1.0e-6);
                let entries = [
                    ("to_world", matrix(&(pose * scale))),
                    ("near_clip", number(near)),
                    ("far_clip", number(orthographic.zfar().max(2.0 * near))),
                ];
                (object(Kind::Sensor, "orthographic", entries), half / height)
            }
        };
        let aspect = if aspect.is_finite() && aspect > 0.0 { aspect.clamp(0.01, 100.0) } else { ASPECT };
        if aspect != camera_aspect(camera) {
            let label = if name.is_empty() { self.sensors.len().to_string() } else { format!("`{name}`") };
            asset.warn(format!("the camera {label} gives no aspect ratio; {aspect:.3} is used"));
        }
        let film = object(
            Kind::Film,
            "hdrfilm",
            [
                ("width", Value::Integer((FILM_HEIGHT * aspect).round().max(1.0) as i64)),
                ("height", Value::Integer(FILM_HEIGHT as i64)),
            ],
        );
        self.sensors.push((name.to_owned(), sensor.with("film", nested(film))));
    }

    pub fn is_empty(&self) -> bool {
        self.sensors.is_empty()
    }

    /// All cameras with the keys of their entries. The `id` of a camera is its name, or else `camera` with a number: always one
    /// that no other camera has, and that is not among the `ids` of other objects.
    pub fn into_objects(self, mut ids: HashSet<String>) -> Vec<(String, Object)> {
        let is_own = |(name, _): &(String, Object)| !name.is_empty() && ids.insert(name.clone());
        let are_own: Vec<bool> = self.sensors.iter().map(is_own).collect();
        let mut number = 0;
        let mut objects = Vec::with_capacity(self.sensors.len());
        for (index, ((name, sensor), is_own)) in self.sensors.into_iter().zip(are_own).enumerate() {
            let mut id = name;
            if !is_own {
                number = number.max(index);
                id = format!("camera{number}");
                while !ids.insert(id.clone()) {
                    number += 1;
                    id = format!("camera{number}");
                }
            }
            objects.push((format!("sensor{index}"), sensor.with_id(id)));
        }
        objects
    }
}

/// Aspect ratio that a camera gives.
fn camera_aspect(camera: &gltf::Camera) -> f32 {
    match camera.projection() {
        Projection::Perspective(perspective) => perspective.aspect_ratio().unwrap_or_default(),
        Projection::Orthographic(orthographic) => orthographic.xmag().abs() / orthographic.ymag().abs(),
    }
}

/// The matrix without its scale and shear, which do not change a camera.
fn rigid(matrix: &DMat4) -> DMat4 {
    let linear = DMat3::from_mat4(*matrix);
    let z = linear.z_axis.normalize_or(DVec3::Z);
    let y = (linear.y_axis - linear.y_axis.dot(z) * z).normalize_or(z.any_orthonormal_vector());
    let columns = [y.cross(z), y, z].map(|axis| axis.extend(0.0));
    DMat4::from_cols(columns[0], columns[1], columns[2], matrix.w_axis)
}
