//! Media that are grids: filters, borders, colors, albedos, boundaries and lamps. Mitsuba's `volpath` is the reference.

use super::xml::{EYE, bsdf, element, film, float, integer, lamp, perspective, placed, rgb, sensor, shape, string};
use super::{Class::Media, Reference, Stage, Table};

fn volpath() -> String {
    element("integrator", "volpath", &(integer("max_depth", -1) + &integer("rr_depth", 5)))
}

/// Place of a ball's box: its middle, and the half of its side.
const MIDDLE: [f64; 3] = [0.0, 0.95, 0.2];
const HALF: f64 = 0.9;

/// Steps of the transform that puts the unit cube around the ball.
fn around_ball(turn: &str) -> String {
    let [x, y, z] = MIDDLE;
    let side = 2.0 * HALF;
    format!("<translate value='-0.5,-0.5,-0.5'/>{turn}<scale value='{side}'/><translate value='{x},{y},{z}'/>")
}

/// Grid of a file over the ball's box.
fn grid(name: &str, file: &str, turn: &str, more: &str) -> String {
    let inside = string("filename", file) + &placed(&around_ball(turn)) + more;
    format!("<volume name='{name}' type='gridvolume'>{inside}</volume>")
}

fn medium(side: &str, inside: &str, scale: &str) -> String {
    format!("<medium name='{side}' type='heterogeneous'>{inside}{}</medium>", float("scale", scale))
}

fn emitter(plugin: &str, inside: &str) -> String {
    element("emitter", plugin, inside)
}

/// Ball within the grid's box.
fn ball(inside: &str) -> String {
    let center = "<point name='center' x='0' y='0.95' z='0.2'/>";
    shape("sphere", &[center, &float("radius", "0.85"), inside].concat())
}

pub fn add(table: &mut Table) {
    let sun = emitter(
        "directional",
        &("<vector name='direction' x='-0.2' y='-1' z='-0.4'/>".to_owned() + &rgb("irradiance", "3,2.7,2.2")),
    );
    let point =
        emitter("point", &("<point name='position' x='0.5' y='2.6' z='0.8'/>".to_owned() + &rgb("intensity", "9,8,6")));
    let sky = emitter("constant", &rgb("radiance", "0.5,0.7,1"));
    let area = lamp("9,8,6");
    let null = bsdf("null", "");
    let forward = element("phase", "hg", &float("g", "0.7"));
    let mut show = |name: String, light: &str, subject: String| {
        table.add(Media, name, |stage| {
            stage.integrator = volpath();
            stage.lamp = light.to_owned();
            stage.subject = subject;
        });
    };
    let inside = |volumes: &str, scale: &str| null.clone() + &medium("interior", volumes, scale);
    let gray = rgb("albedo", "0.8,0.8,0.8");
    let smoke = grid("sigma_t", "smoke.vol", "", "");
    for (of, light) in [("lamp", &area), ("sun", &sun), ("point", &point), ("sky", &sky)] {
        show(format!("grid-smoke-{of}"), light, ball(&inside(&(smoke.clone() + &gray), "6")));
        let tinted = grid("sigma_t", "tinted.vol", "", "") + &rgb("albedo", "0.95,0.9,0.7") + &forward;
        show(format!("grid-tinted-{of}"), light, ball(&inside(&tinted, "12")));
    }
    // Mitsuba inverts a rotation wrongly if its axis has another length than 1.
    let turn = "<rotate x='0' y='0.6' z='0.8' angle='40'/>";
    let nearest = string("filter_type", "nearest");
    let repeat = string("wrap_mode", "repeat");
    for (name, volumes, scale) in [
        ("turned", grid("sigma_t", "smoke.vol", turn, "") + &gray, "6"),
        ("nearest", grid("sigma_t", "smoke.vol", "", &nearest) + &gray, "6"),
        ("repeat", grid("sigma_t", "tinted.vol", "", &repeat) + &gray, "6"),
        ("albedo", smoke.clone() + &grid("albedo", "tinted.vol", turn, ""), "6"),
        ("dense", smoke.clone() + &rgb("albedo", "0.99,0.97,0.9"), "60"),
        ("constant", float("sigma_t", "0.8") + &grid("albedo", "tinted.vol", "", &nearest), "1"),
    ] {
        show(format!("grid-{name}"), &area, ball(&inside(&volumes, scale)));
    }
    let glass = bsdf("dielectric", "") + &medium("interior", &(smoke.clone() + &gray), "6");
    show("grid-in-glass".into(), &area, ball(&glass));
    table.add(Media, "grid-around-camera", |stage| {
        stage.integrator = volpath();
        let smoke = medium("medium", &(smoke.clone() + &gray), "6");
        stage.sensor =
            perspective(&("<float name='fov' value='40'/>".to_owned() + &smoke), &film("<rfilter type='box'/>"));
    });
    for (name, phase) in [("isotropic", ""), ("forward", &forward)] {
        table.add(Media, format!("grid-furnace-{name}"), |stage: &mut Stage| {
            stage.integrator = volpath();
            stage.room = String::new();
            stage.lamp = sky.clone();
            stage.sensor = sensor("perspective", EYE, "<float name='fov' value='20'/>", &film("<rfilter type='box'/>"));
            let white = grid("sigma_t", "tinted.vol", "", "") + &rgb("albedo", "1,1,1") + phase;
            stage.subject = ball(&inside(&white, "12"));
            stage.reference = Reference::Uniform([0.5, 0.7, 1.0]);
        });
    }
}
