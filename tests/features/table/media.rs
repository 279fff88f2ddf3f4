//! Homogeneous media: phase functions, boundaries and lamps, seen from outside and from inside. Mitsuba's `volpath` is the reference.
//! Depths are unlimited, for `volpath` does not count what it passes.

use super::xml::{
    EYE, area, bsdf, default, diffuse, element, film, float, integer, lamp, perspective, placed, rgb, sensor, shape,
    two_sided,
};
use super::{Class::Media, Reference, Stage, Table};

fn volpath() -> String {
    element("integrator", "volpath", &(integer("max_depth", -1) + &integer("rr_depth", 5)))
}

fn phase(plugin: &str, inside: &str) -> String {
    element("phase", plugin, inside)
}

/// Medium on a side of a shape, or around the camera. Mitsuba's colors do not exceed 1, so that a denser medium needs a scale.
fn medium(side: &str, extinction: &str, albedo: &str, phase: &str) -> String {
    let channels: Vec<f64> = extinction.split(',').filter_map(|channel| channel.parse().ok()).collect();
    let densest = channels.iter().copied().fold(0.0, f64::max);
    let extinction = match densest > 1.0 {
        true => channels.iter().map(|channel| (channel / densest).to_string()).collect::<Vec<_>>().join(","),
        false => extinction.to_owned(),
    };
    let scale = float("scale", &densest.max(1.0).to_string());
    let inside = [&rgb("sigma_t", &extinction), &rgb("albedo", albedo), &scale, phase].concat();
    format!("<medium name='{side}' type='homogeneous'>{inside}</medium>")
}

fn emitter(plugin: &str, inside: &str) -> String {
    element("emitter", plugin, inside)
}

/// A ball in the middle.
fn ball(radius: &str, inside: &str) -> String {
    let center = "<point name='center' x='0' y='0.95' z='0.2'/>";
    shape("sphere", &[center, &float("radius", radius), inside].concat())
}

/// A box around everything.
fn around(inside: &str) -> String {
    shape("cube", &(placed("<scale value='9'/>") + inside))
}

/// Fog in a box around everything and around the camera.
fn in_fog(stage: &mut Stage, extinction: &str, albedo: &str, phase: &str) {
    stage.sensor = perspective(
        &("<float name='fov' value='40'/>".to_owned() + &medium("medium", extinction, albedo, phase)),
        &film("<rfilter type='box'/>"),
    );
    stage.subject = around(&(bsdf("null", "") + &medium("interior", extinction, albedo, phase)));
}

/// A ball of milk in glass and a ball of fog, on a scaled stage.
fn scaled(stage: &mut Stage, scale: f64) {
    let put = |steps: &str| placed(&format!("{steps}<scale value='{scale}'/>"));
    let at = |p: [f64; 3]| p.map(|v| (v * scale).to_string()).join(",");
    let eye = format!("<lookat origin='{}' target='{}' up='0,1,0'/>", at([0.3, 1.7, 5.2]), at([0.0, 0.8, 0.0]));
    let clips = float("near_clip", &(0.1 * scale).to_string()) + &float("far_clip", &(100.0 * scale).to_string());
    stage.integrator = volpath();
    stage.sensor = sensor("perspective", &eye, &(float("fov", "40") + &clips), &film("<rfilter type='box'/>"));
    let wall = |steps: &str, albedo: &str| {
        shape("rectangle", &(put(&format!("<scale value='3'/>{steps}")) + &diffuse(albedo)))
    };
    stage.room = wall("<rotate x='1' angle='-90'/>", "0.5,0.5,0.55") + &wall("<translate z='-2'/>", "0.6,0.3,0.2");
    stage.lamp = shape("rectangle", &(put(super::xml::ABOVE) + &area("9,8,6")));
    let per_unit = |colors: [f64; 3]| colors.map(|color| (color / scale).to_string()).join(",");
    let fog = medium("interior", &per_unit([1.0, 1.5, 2.0]), "0.9,0.8,0.7", "");
    let milk = medium("interior", &per_unit([6.0, 7.0, 9.0]), "0.98,0.95,0.9", &phase("hg", &float("g", "0.6")));
    stage.subject =
        shape("sphere", &(put("<scale value='0.7'/><translate x='-0.9' y='0.75'/>") + &bsdf("null", "") + &fog))
            + &shape(
                "sphere",
                &(put("<scale value='0.6'/><translate x='0.8' y='0.7' z='0.4'/>") + &bsdf("dielectric", "") + &milk),
            );
}

pub fn add(table: &mut Table) {
    let sun = emitter(
        "directional",
        &("<vector name='direction' x='-0.2' y='-1' z='-0.4'/>".to_owned() + &rgb("irradiance", "3,2.7,2.2")),
    );
    let point =
        emitter("point", &("<point name='position' x='0.5' y='2.6' z='0.8'/>".to_owned() + &rgb("intensity", "9,8,6")));
    let aimed = placed("<lookat origin='0.5,3.2,1.5' target='0,0.4,0' up='0,1,0'/>");
    let spot = emitter("spot", &(aimed + &float("cutoff_angle", "40") + &rgb("intensity", "30,25,20")));
    let sky = emitter("constant", &rgb("radiance", "0.5,0.7,1"));
    let area = lamp("9,8,6");
    let lamps = [("lamp", &area), ("sun", &sun), ("point", &point), ("spot", &spot), ("sky", &sky)];
    let [isotropic, forward, backward] =
        [phase("isotropic", ""), phase("hg", &float("g", "0.7")), phase("hg", &float("g", "-0.4"))];
    let rayleigh = phase("rayleigh", "");
    let blend = phase("blendphase", &(float("weight", "0.3") + &forward + &phase("hg", &float("g", "-0.3"))));
    let null = bsdf("null", "");
    let mut show = |name: String, light: &str, subject: String| {
        table.add(Media, name, |stage| {
            stage.integrator = volpath();
            stage.lamp = light.to_owned();
            stage.subject = subject;
        });
    };
    let smoke = |phase: &str| medium("interior", "2,2,2", "0.8,0.8,0.8", phase);
    for (name, phase) in [("isotropic", &isotropic), ("forward", &forward), ("backward", &backward)] {
        for (of, light) in lamps {
            show(format!("null-{name}-{of}"), light, ball("0.8", &(null.clone() + &smoke(phase))));
        }
    }
    for (name, phase) in [("rayleigh", &rayleigh), ("blend", &blend)] {
        for (of, light) in &lamps[..2] {
            let tinted = medium("interior", "1,2,4", "0.95,0.9,0.6", phase);
            show(format!("null-{name}-{of}"), light, ball("0.8", &(null.clone() + &tinted)));
        }
    }
    let milk = medium("interior", "12,14,18", "0.99,0.97,0.9", &forward);
    let tea = medium("interior", "0.3,0.8,3", "0,0,0", "");
    let glass = bsdf("dielectric", "");
    let frosted = bsdf("roughdielectric", &float("alpha", "0.2"));
    let leaky = bsdf("mask", &(float("opacity", "0.5") + &two_sided(&diffuse("0.2,0.6,0.3"))));
    for (name, boundary, inside) in [
        ("glass-milk", &glass, &milk),
        ("glass-tea", &glass, &tea),
        ("glass-smoke", &glass, &smoke(&isotropic)),
        ("frosted-milk", &frosted, &milk),
        ("frosted-tea", &frosted, &tea),
        ("leaky-smoke", &leaky, &smoke(&backward)),
        ("leaky-tea", &leaky, &tea),
        ("null-milk", &null, &milk),
        ("null-tea", &null, &tea),
    ] {
        for (of, light) in [lamps[0], lamps[4]] {
            show(format!("{name}-{of}"), light, ball("0.8", &(boundary.clone() + inside)));
        }
    }
    let inner = medium("interior", "8,4,2", "0.7,0.9,0.95", &forward) + &medium("exterior", "1,1,1", "0.8,0.8,0.8", "");
    let outer = ball("0.9", &(null.clone() + &medium("interior", "1,1,1", "0.8,0.8,0.8", "")));
    for (of, light) in [lamps[0], lamps[1]] {
        show(format!("nested-null-{of}"), light, outer.clone() + &ball("0.5", &(null.clone() + &inner)));
        show(format!("nested-glass-{of}"), light, outer.clone() + &ball("0.5", &(glass.clone() + &inner)));
    }
    let solid = diffuse("0.7,0.3,0.2") + &medium("exterior", "1,1,1", "0.8,0.8,0.8", "");
    show("nested-solid-lamp".into(), &area, outer + &ball("0.5", &solid));
    for (name, phase) in [("isotropic", &isotropic), ("forward", &forward)] {
        for (of, light) in [lamps[0], lamps[1], lamps[4]] {
            table.add(Media, format!("fog-{name}-{of}"), |stage| {
                in_fog(stage, "0.1,0.12,0.15", "0.9,0.85,0.8", phase);
                stage.integrator = volpath();
                stage.lamp = light.to_owned();
            });
        }
    }
    table.add(Media, "fog-twin", |stage| {
        in_fog(stage, "$density", "0.5,0.5,0.5", &isotropic);
        stage.integrator = default("density", "0.2") + &volpath();
    });
    table.add(Media, "fog-glass-ball", |stage| {
        in_fog(stage, "0.1,0.12,0.15", "0.9,0.85,0.8", "");
        stage.integrator = volpath();
        let outside = medium("exterior", "0.1,0.12,0.15", "0.9,0.85,0.8", "");
        stage.subject += &ball("0.6", &(glass.clone() + &tea + &outside));
    });
    table.add(Media, "media-1", |stage| scaled(stage, 1.0));
    for power in [-4, -2, 2, 4] {
        table.add(Media, format!("media-1e{power}"), |stage| {
            scaled(stage, 10f64.powi(power));
            stage.reference = Reference::Like("media-1");
        });
    }
    // A furnace: a medium that only scatters is invisible under an even sky.
    // So is one below a dielectric that light leaves diffusely, as below wax.
    let leaving =
        "<bsdf type='difftrans'><rgb name='transmittance' value='1,1,1'/><string name='int_ior' value='bk7'/></bsdf>";
    let wax = bsdf("twosided", &(glass.clone() + leaving));
    for (name, boundary) in [("null", &null), ("glass", &glass), ("wax", &wax)] {
        table.add(Media, format!("furnace-{name}"), |stage| {
            stage.integrator = volpath();
            stage.room = String::new();
            stage.lamp = emitter("constant", &rgb("radiance", "0.5,0.7,1"));
            stage.sensor = sensor("perspective", EYE, "<float name='fov' value='20'/>", &film("<rfilter type='box'/>"));
            stage.subject = ball("0.8", &(boundary.clone() + &medium("interior", "1,3,9", "1,1,1", &blend)));
            stage.reference = Reference::Uniform([0.5, 0.7, 1.0]);
        });
    }
}
