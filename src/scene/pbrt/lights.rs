//! Lights that no shape has.

use super::names::Names;
use super::textures::Textures;
use super::tokens::brief;
use super::world::World;
use super::{delta_lights, environment};
use crate::scene::Value;
use crate::scene::mitsuba::faults::Faults;

/// Emitters of a scene's lights. `exposure` is a factor of all light.
pub(super) fn of_scene(
    world: &World,
    exposure: f64,
    names: &Names,
    textures: &mut Textures,
    faults: &mut Faults,
) -> Vec<(String, Value)> {
    let mut lights = Vec::new();
    for (index, light) in world.lights.iter().enumerate() {
        let made = match light.kind.as_str() {
            "infinite" => environment::light(light, exposure, index, textures),
            _ => delta_lights::light(light, exposure, textures.files, textures.warnings),
        };
        let label = names.label(&light.parameters.place, &format!("light `{}`", brief(&light.kind)));
        lights.extend(faults.keep(made).map(|object| names.entry(label, "light", object)));
        textures.warnings.extend(light.parameters.unread());
    }
    lights
}
