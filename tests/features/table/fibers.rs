//! Hair: under a lamp and under the sky, pigments and absorption, textures, in instances, and white in a furnace. The scenes come after
//! the others, which so keep their numbers, which are their seeds.

use super::Class::Curves;
use super::shapes::subject;
use super::xml::{bsdf, checkerboard, default, element, float, placed, rgb, shape, string};
use super::{Known, Reference, Table};

pub fn add(table: &mut Table) {
    let spline = default("file", "bsplinecurve.txt");
    let with = |inside: &str| bsdf("hair", inside);
    let curves = |inside: &str| spline.clone() + &subject("bsplinecurve", "$file", "", false, inside);
    let light = with(&(float("eumelanin", "0.1") + &float("pheomelanin", "0.2")));
    let rough =
        [("longitudinal_roughness", "0.2"), ("azimuthal_roughness", "0.5"), ("scale_tilt", "6"), ("int_ior", "1.4")];
    let rough: String = rough.map(|(name, value)| float(name, value)).concat();
    let blue = with(&(rgb("sigma_a", "0.9,0.3,0.05") + &float("scale", "0.8") + &rough));
    let checkered = with(
        &(checkerboard("sigma_a", "0.8,0.3,0.2", "0.1,0.3,0.6") + &float("scale", "2") + &float("scale_tilt", "0")),
    );
    let sky = element("emitter", "constant", &rgb("radiance", "0.5,0.6,0.8"));

    table.show(Curves, "hair-lamp", curves(&with("")));
    table.show(Curves, "hair-light", curves(&light));
    table.show(Curves, "hair-blue", curves(&blue));
    table.show(Curves, "hair-checkered", curves(&checkered));
    let linear = default("file", "linearcurve.txt") + &subject("linearcurve", "$file", "", false, &blue);
    table.show(Curves, "hair-linear", linear);
    table.known(Known {
        reason: "Mitsuba's frame on a linear curve does not follow the fiber",
        mean: 0.05,
        block: 0.3,
    });
    for (name, inside) in [("hair-sky", &light), ("hair-sky-blue", &blue)] {
        table.add(Curves, name, |stage| {
            stage.lamp = sky.clone();
            stage.subject = curves(inside);
        });
    }
    let group = shape("bsplinecurve", &(string("filename", "$file") + &light));
    let steps = "<scale x='0.6' y='0.8' z='0.7'/><rotate y='1' angle='60'/><translate y='0.9'/>";
    let instance = shape("instance", &(placed(steps) + "<ref id='group'/>"));
    table.show(
        Curves,
        "hair-instance",
        spline.clone() + &format!("<shape type='shapegroup' id='group'>{group}</shape>") + &instance,
    );
    // In a mirror the scales still rise toward the end of the fiber.
    let tilted = with(&(float("scale_tilt", "20") + &float("longitudinal_roughness", "0.15")));
    let placed_curve = |steps: &str| {
        shape(
            "bsplinecurve",
            &(placed(&format!("<scale value='0.7'/>{steps}")) + &string("filename", "$file") + &tilted),
        )
    };
    let mirror = "<scale x='-1'/>";
    table.show(Curves, "hair-mirrored", spline.clone() + &placed_curve(mirror));
    let group = format!("<shape type='shapegroup' id='group'>{}</shape>", placed_curve(""));
    let instance = shape("instance", &(placed(mirror) + "<ref id='group'/>"));
    table.add(Curves, "hair-mirrored-instance", |stage| {
        stage.subject = spline.clone() + &group + &instance;
        stage.reference = Reference::Like("hair-mirrored");
    });
    table.add(Curves, "hair-furnace", |stage| {
        stage.room = String::new();
        stage.lamp = sky.clone();
        stage.subject = curves(&with(&(rgb("sigma_a", "0,0,0") + &rough)));
        stage.integrator = super::path(1000);
        stage.reference = Reference::Uniform([0.5, 0.6, 0.8]);
    });
}
