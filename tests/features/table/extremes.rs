//! Scales from 10^-6 to 10^6, places far from the origin, and large beside small.

use super::xml::{area, bsdf, default, diffuse, film, float, placed, rgb, sensor, shape, string, two_sided};
use super::{Class::Extremes, Known, Reference, Stage, Table};

/// The stage, scaled by `scale` and moved by `offset` after that, with a ball, a block and a mesh. Radiance does not depend on
/// either.
fn moved(stage: &mut Stage, scale: f64, offset: [f64; 3]) {
    let [x, y, z] = offset;
    let last = format!("<scale value='{scale}'/><translate x='{x}' y='{y}' z='{z}'/>");
    let put = |steps: &str| placed(&format!("{steps}{last}"));
    // A camera may not scale: its place is scaled instead.
    let at = |p: [f64; 3]| p.map(|v| (v * scale).to_string()).join(",");
    let eye = format!(
        "<lookat origin='{}' target='{}' up='0,1,0'/><translate x='{x}' y='{y}' z='{z}'/>",
        at([0.3, 1.7, 5.2]),
        at([0.0, 0.8, 0.0])
    );
    let clips = float("near_clip", &(0.1 * scale).to_string()) + &float("far_clip", &(100.0 * scale).to_string());
    stage.sensor = sensor("perspective", &eye, &(float("fov", "40") + &clips), &film("<rfilter type='box'/>"));
    let wall = |steps: &str, albedo: &str| {
        shape("rectangle", &(put(&format!("<scale value='3'/>{steps}")) + &diffuse(albedo)))
    };
    stage.room = wall("<rotate x='1' angle='-90'/>", "0.5,0.5,0.55") + &wall("<translate z='-2'/>", "0.6,0.3,0.2");
    stage.lamp = shape("rectangle", &(put(super::xml::ABOVE) + &area("9,8,6")));
    let plastic = bsdf("roughplastic", &(rgb("diffuse_reflectance", "0.2,0.5,0.7") + &float("alpha", "0.2")));
    let red = diffuse("0.7,0.3,0.2");
    stage.subject = default("size", "0.7")
        + &shape("sphere", &(put("<scale value='$size'/><translate x='-0.9' y='0.75'/>") + &plastic))
        + &shape(
            "cube",
            &(put("<scale value='0.35'/><rotate y='1' angle='30'/><translate x='0.9' y='0.36' z='0.6'/>") + &red),
        )
        + &shape(
            "obj",
            &(put("<scale value='0.4'/><translate x='0.6' y='1.4' z='-0.4'/>")
                + &string("filename", "smooth.obj")
                + &red),
        )
        + &shape(
            "disk",
            &(put("<scale value='0.3'/><rotate y='1' angle='-30'/><translate x='0' y='0.4' z='1.2'/>")
                + &two_sided(&red)),
        );
}

/// Objects of size 0.1 on a ground, seen from 1.1.
fn on_ground(stage: &mut Stage, ground: &str) {
    let eye = "<lookat origin='0,0.5,1' target='0,0.06,0' up='0,1,0'/>";
    stage.sensor = sensor("perspective", eye, &float("fov", "40"), &film("<rfilter type='box'/>"));
    stage.room = ground.to_owned();
    let steps = "<scale value='0.5'/><rotate x='1' angle='90'/><translate y='2' x='0.5'/>";
    stage.lamp = shape("rectangle", &(placed(steps) + &area("9,8,6")));
    let blue = diffuse("0.2,0.5,0.7");
    stage.subject =
        shape(
            "sphere",
            &("<point name='center' x='-0.12' y='0.08' z='0'/>".to_owned() + &float("radius", "0.08") + &blue),
        ) + &shape("cube", &(placed("<scale x='0.1' y='0.03' z='0.1'/><translate x='0.12' y='0.03'/>") + &blue));
}

pub fn add(table: &mut Table) {
    table.add(Extremes, "scale-1", |stage| moved(stage, 1.0, [0.0; 3]));
    for power in [-6, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6] {
        table.add(Extremes, format!("scale-1e{power}"), |stage| {
            moved(stage, 10f64.powi(power), [0.0; 3]);
            stage.reference = Reference::Like("scale-1");
        });
    }
    for (name, offset) in [
        ("offset-1e1", [10.0, -10.0, 10.0]),
        ("offset-1e2", [100.0, 0.0, -100.0]),
        ("offset-1e3", [0.0, 1000.0, 1000.0]),
        ("offset-1e4", [10000.0, 10000.0, 0.0]),
        ("offset-1e5", [-100000.0, 0.0, 0.0]),
    ] {
        table.add(Extremes, name, |stage| {
            moved(stage, 1.0, offset);
            stage.reference = Reference::Like("scale-1");
        });
        if name == "offset-1e5" {
            table.known(Known { reason: "coordinates near 10^5 have steps of 1/128", mean: 0.02, block: 0.08 });
        }
    }
    let gray = two_sided(&diffuse("0.6,0.6,0.6"));
    for (name, size) in
        [("1e1", "10"), ("1e2", "100"), ("1e3", "1000"), ("1e4", "10000"), ("1e5", "100000"), ("1e6", "1000000")]
    {
        let steps = placed(&format!("<scale value='{size}'/><rotate x='1' angle='-90'/>"));
        // From a half side of 10^4 on, no pixel tells a ground from a larger one. Mitsuba's blocks change by 0.5 % at 10^5, and by
        // 8 % at 10^6.
        let as_smaller = |stage: &mut Stage| {
            if name >= "1e5" {
                stage.reference = Reference::Like("ground-rectangle-1e4");
            }
        };
        table.add(Extremes, format!("ground-rectangle-{name}"), |stage| {
            on_ground(stage, &shape("rectangle", &(steps.clone() + &gray)));
            as_smaller(stage);
        });
        if name >= "1e3" {
            table.add(Extremes, format!("ground-mesh-{name}"), |stage| {
                on_ground(stage, &shape("obj", &(steps + &string("filename", "square.obj") + &gray)));
                as_smaller(stage);
            });
        }
        table.add(Extremes, format!("ground-sphere-{name}"), |stage| {
            let place = format!("<point name='center' x='0' y='-{size}' z='0'/>") + &float("radius", size);
            on_ground(stage, &shape("sphere", &(place + &gray)));
            // From a radius of 10^4 on, no pixel tells the ground from a plane.
            if name >= "1e4" {
                stage.reference = Reference::Like("ground-rectangle-1e4");
            }
        });
    }
    for (name, gap) in [("carpet", "0.005"), ("carpet-thin", "0.0001")] {
        table.add(Extremes, name, |stage| {
            let steps = placed("<scale value='1000'/><rotate x='1' angle='-90'/>");
            let lift = placed(&format!("<scale x='1' y='0.6'/><rotate x='1' angle='-90'/><translate y='{gap}'/>"));
            stage.room = shape("rectangle", &(steps + &diffuse("0.6")))
                + &shape("rectangle", &(lift + &two_sided(&diffuse("0.7,0.1,0.1"))));
            stage.subject = super::plain_subject("0.2,0.5,0.7");
        });
    }
    // Glass above a mirror, with a gap of a thousandth of its size, at two scales. A furnace: all light comes back.
    for (name, scale) in [("gap", 1.0), ("gap-small", 0.01)] {
        let clips = float("near_clip", "0.001");
        table.add(Extremes, name, |stage| {
            let last = format!("<scale value='{scale}'/>");
            let eye = format!("<lookat origin='0,{},{}' target='0,0,0' up='0,1,0'/>", 3.0 * scale, 4.0 * scale);
            stage.sensor = sensor("perspective", &eye, &(float("fov", "40") + &clips), &film("<rfilter type='box'/>"));
            stage.integrator = super::path(256);
            let mirror = bsdf("conductor", &string("material", "none"));
            let floor = placed(&format!("<scale value='1.2'/><rotate x='1' angle='-90'/>{last}"));
            let slab = placed(&format!("<scale x='0.7' y='0.1' z='0.7'/><translate y='0.101'/>{last}"));
            stage.room = shape("rectangle", &(floor + &two_sided(&mirror)));
            stage.subject = shape("cube", &(slab + &bsdf("dielectric", "")));
            stage.lamp = super::xml::element("emitter", "constant", &rgb("radiance", "1,0.8,0.6"));
            stage.reference = Reference::Uniform([1.0, 0.8, 0.6]);
        });
    }
}
