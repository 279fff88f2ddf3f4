//! Curves: placed, unevenly scaled, textured, as glass, in groups. They come after the other scenes, which so keep their
//! numbers, which are their seeds.

use super::Class::Curves;
use super::Table;
use super::shapes::subject;
use super::xml::{bsdf, default, placed, printed, rgb, shape, string};

pub fn add(table: &mut Table) {
    let glass = bsdf("dielectric", &rgb("specular_transmittance", "0.7,0.9,0.8"));
    for plugin in ["linearcurve", "bsplinecurve"] {
        let file = default("file", &format!("{plugin}.txt"));
        for (name, steps, inside) in [
            ("plain", "", &printed()),
            ("mirrored", "<scale x='-1'/>", &printed()),
            ("uneven", "<scale x='1.2' y='0.5' z='0.8'/>", &printed()),
            ("glass", "", &glass),
        ] {
            let subject = subject(plugin, "$file", steps, false, inside);
            table.show(Curves, format!("{plugin}-{name}"), file.clone() + &subject);
        }
        let curves = shape(plugin, &(string("filename", "$file") + &printed()));
        let group = format!("<shape type='shapegroup' id='group'>{curves}</shape>");
        let steps = "<scale x='0.6' y='0.8' z='0.7'/><rotate y='1' angle='60'/><translate y='0.9'/>";
        let instance = shape("instance", &(placed(steps) + "<ref id='group'/>"));
        table.show(Curves, format!("{plugin}-instance"), file + &group + &instance);
    }
}
