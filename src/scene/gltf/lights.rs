//! Punctual lights (KHR_lights_punctual) to emitters.
//!
//! glTF counts light in photometric units and emissive surfaces in cd/m². One unit of radiance stands for 1 cd/m², so a
//! candela is one unit of intensity, and a lux is one unit of irradiance.

use gltf::khr_lights_punctual::{Kind, Light};
use glam::{DMat4, DVec3};

use super::cameras::without_scale;
use super::entries::{matrix, number, object, rgb};
use crate::scene::mitsuba::dictionary::{Array, Dictionary, Value};

/// Emitter of a light at `world`. It shines along `-z`.
pub(super) fn emitter(light: &Light, world: DMat4) -> Dictionary {
    let color = rgb(light.color().map(|channel| (channel * light.intensity()).max(0.0)));
    let vector = |v: DVec3| Value::Array(Array { shape: vec![3], values: v.to_array().to_vec() });
    let turned = without_scale(world) * DMat4::from_scale(DVec3::new(-1.0, 1.0, -1.0));
    match light.kind() {
        Kind::Directional => {
            object("directional", [("direction", vector(turned.z_axis.truncate())), ("irradiance", color)])
        }
        Kind::Point => object("point", [("position", vector(world.w_axis.truncate())), ("intensity", color)]),
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            object("spot", [
                ("to_world", matrix(turned)),
                ("intensity", color),
                ("cutoff_angle", number(outer_cone_angle.to_degrees())),
                ("beam_width", number(inner_cone_angle.to_degrees())),
            ])
        }
    }
}
