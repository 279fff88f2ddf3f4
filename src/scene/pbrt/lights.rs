//! Lights that no shape has.

use super::names::Names;
use super::textures::Textures;
use super::tokens::brief;
use super::world::{Entity, World};
use super::{delta_lights, environment, pictured_lights};
use crate::scene::description::object::Object;
use crate::scene::faults::Faults;

/// Emitters of a scene's lights. `exposure` is a factor of all light.
pub(super) fn of_scene(
    world: &World,
    exposure: f64,
    names: &Names,
    textures: &mut Textures,
    faults: &mut Faults,
) -> Vec<(String, Object)> {
    let (infinite, others): (Vec<&Entity>, Vec<&Entity>) =
        world.lights.iter().partition(|light| light.kind == "infinite");
    let label = |light: &Entity| names.label(&light.parameters.place, &format!("light `{}`", brief(&light.kind)));
    let mut lights = Vec::new();
    for light in &others {
        let images = &mut textures.images;
        let made = match light.kind.as_str() {
            "projection" => pictured_lights::projection(light, exposure, images),
            "goniometric" => pictured_lights::goniometric(light, exposure, images),
            _ => delta_lights::light(light, exposure, images.files, images.warnings).map(|object| vec![object]),
        };
        let made = faults.keep(made).into_iter().flatten();
        lights.extend(made.map(|object| names.entry(label(light), "light", object)));
    }
    let environment = faults.keep(environment::of_lights(&infinite, exposure, textures)).flatten();
    if let (Some(object), Some(first)) = (environment, infinite.first()) {
        lights.push(names.entry(label(first), "environment", object));
    }
    textures.images.warnings.extend(world.lights.iter().flat_map(|light| light.parameters.unread()));
    lights
}
