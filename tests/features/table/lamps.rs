//! Lamps that face what they light. Mitsuba has none; a round room about one is evenly lit.

use super::xml::{area, diffuse, element, film, float, path, placed, sensor, shape};
use super::{Class::Emitters, Reference, Stage, Table};

/// A room of the radius 1 and the reflectance 0.5 about a lamp. Reflections double the light, so that the walls have the
/// lamp's radiance times r^2 / (1 + r^2).
fn room(stage: &mut Stage, radius: &str) {
    let eye = "<lookat origin='0.2,0.1,0.3' target='0.9,-0.2,0.4' up='0,1,0'/>";
    let inside = float("fov", "60") + &float("near_clip", "0.001");
    stage.sensor = sensor("perspective", eye, &inside, &film("<rfilter type='box'/>"));
    stage.integrator = path(256);
    stage.room = shape("sphere", &(diffuse("0.5") + "<boolean name='flip_normals' value='true'/>"));
    let unseen = "<boolean name='visible_to_camera' value='false'/>";
    stage.lamp = shape("facingdisk", &[&float("radius", radius), unseen, &area("5,4,3")].concat());
}

pub fn add(table: &mut Table) {
    table.add(Emitters, "facingdisk-room", |stage| {
        room(stage, "0.5");
        stage.reference = Reference::Uniform([1.0, 0.8, 0.6]);
    });
    table.add(Emitters, "facingdisk-within-radius", |stage| {
        room(stage, "2");
        // The walls hide what lies beyond them.
        stage.reference = Reference::Uniform([2.5, 2.0, 1.5]);
    });
    // A hole on the way does not turn the lamp.
    table.add(Emitters, "facingdisk-behind-hole", |stage| {
        room(stage, "0.5");
        let place = placed("<scale value='0.45'/><translate x='0.3' y='0.2' z='-0.1'/>");
        stage.subject = shape("sphere", &(place + &element("bsdf", "null", "")));
        stage.reference = Reference::Uniform([1.0, 0.8, 0.6]);
    });
}
