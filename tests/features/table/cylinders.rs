//! Cylinders: mirrored, flipped, between two points, as glass, as lamps. They come last in the table, so that the other scenes
//! keep their numbers, which are their seeds.

use super::Class::{Emitters, Shapes};
use super::shapes::subject;
use super::xml::{area, bitmap, bsdf, default, element, float, lamp, on, placed, printed, rgb, shape};
use super::{Known, Reference, Table};

/// Two points, neither of which is the origin.
const BETWEEN: &str = "<point name='p0' x='-0.5' y='-0.3' z='0.4'/><point name='p1' x='0.9' y='0.5' z='-0.6'/>";

const LAMP: &str = "<scale value='0.4'/><rotate y='1' angle='65'/><rotate z='1' angle='20'/>\
                    <translate x='-0.3' y='1.1' z='0.4'/>";

pub fn add(table: &mut Table) {
    let between = BETWEEN.to_owned() + &float("radius", "0.6");
    let glass = bsdf("dielectric", &rgb("specular_transmittance", "0.7,0.9,0.8"));
    for (name, steps, flips, inside) in [
        ("plain", "", false, printed()),
        ("mirrored", "<scale x='-1'/>", false, printed()),
        ("mirrored-along", "<scale z='-1'/>", false, printed()),
        ("flipped", "", true, printed()),
        ("long", "<scale x='0.6' y='0.6' z='1.8'/>", false, printed()),
        ("between", "", false, between.clone() + &printed()),
        ("glass", "", false, between.clone() + &glass),
        ("flipped-glass", "", true, between.clone() + &glass),
    ] {
        table.show(Shapes, format!("cylinder-{name}"), subject("cylinder", "", steps, flips, &inside));
    }
    let glow = area("$radiance,3,2");
    let image = element("emitter", "area", &bitmap("radiance", "lights.exr", &on("raw")));
    for (name, first, inside) in [
        ("cylinder-plain", "", glow.clone()),
        ("cylinder-mirrored", "<scale x='-1'/>", glow.clone()),
        ("cylinder-flipped", "", on("flip_normals") + &glow),
        ("textured-cylinder", "", between + &image),
    ] {
        let inside = placed(&format!("{first}{LAMP}")) + &inside;
        table.add(Emitters, format!("lamp-{name}"), |stage| {
            stage.lamp = lamp("2,2,1.5");
            stage.subject = default("radiance", "4") + &shape("cylinder", &inside);
            // A cylinder is its own mirror image, also where Mitsuba's emitter sampling takes the wrong side.
            if name == "cylinder-mirrored" {
                stage.reference = Reference::Like("lamp-cylinder-plain");
            }
        });
        if name == "textured-cylinder" {
            table.known(Known {
                reason: "Mitsuba's emitter sampling finds 5 % less light than its BSDF sampling; ours finds what the latter does",
                mean: 0.08,
                block: 0.4,
            });
        }
    }
}
