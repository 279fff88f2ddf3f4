//! Light that goes straight on through holes and thin sheets of glass: lamps of each kind behind them. Mitsuba's `path` loses the light
//! of small lamps there, so its `volpath` is the reference. Depths are unlimited, for `volpath` does not count what it passes.

use super::xml::{
    area, ball, bitmap, bsdf, checkerboard, default, diffuse, element, float, integer, lamp, numbers, on, placed, rgb,
    shape, sheet, string, two_sided,
};
use super::{Class::Passages, Table, plain_subject};

/// A square above the subject, below the lamps.
fn roof(steps: &str, bsdf: &str) -> String {
    let steps =
        format!("<scale x='1.6' y='1.3'/><rotate x='1' angle='90'/>{steps}<translate y='1.8' x='0.1' z='0.5'/>");
    shape("rectangle", &(placed(&steps) + bsdf))
}

fn mask(opacity: &str, inside: &str) -> String {
    bsdf("mask", &(opacity.to_owned() + inside))
}

fn emitter(plugin: &str, inside: &str) -> String {
    element("emitter", plugin, inside)
}

/// The integrator with these parameters more.
fn volpath(more: &str) -> String {
    element("integrator", "volpath", &(integer("max_depth", -1) + &integer("rr_depth", 5) + more))
}

pub fn add(table: &mut Table) {
    let sun = emitter(
        "directional",
        &("<vector name='direction' x='-0.2' y='-1' z='-0.4'/>".to_owned() + &rgb("irradiance", "3,2.7,2.2")),
    );
    let point = |intensity: &str| {
        emitter(
            "point",
            &("<point name='position' x='0.5' y='2.6' z='0.8'/>".to_owned() + &rgb("intensity", intensity)),
        )
    };
    let aimed = placed("<lookat origin='0.5,3.2,1.5' target='0,0.4,0' up='0,1,0'/>");
    let spot = emitter("spot", &(aimed.clone() + &float("cutoff_angle", "40") + &rgb("intensity", "30,25,20")));
    let sky = emitter("constant", &rgb("radiance", "0.5,0.7,1"));
    let green = two_sided(&diffuse("0.2,0.6,0.3"));
    let leaf = mask(&numbers("opacity", "numbers.png"), &green);
    let cut = mask(&checkerboard("opacity", "0", "1"), &green);
    let tints = rgb("specular_reflectance", "0.9,0.5,0.4") + &rgb("specular_transmittance", "0.4,0.6,0.9");
    let pane = bsdf("thindielectric", &tints);
    let clear = bsdf("thindielectric", "");
    let subject = plain_subject("0.6,0.6,0.6");
    let mut show = |name: &str, light: &str, above: String| {
        table.add(Passages, name, |stage| {
            stage.integrator = volpath("");
            stage.lamp = light.to_owned();
            stage.subject = subject.clone() + &above;
        });
    };
    let faded = default("opacity", "0.4") + &roof("", &mask(&float("opacity", "$opacity"), &green));
    show("mask-sun", &sun, faded);
    show("leaves-sun", &sun, roof("", &cut) + &roof("<translate y='0.2' x='0.13' z='0.07'/>", &leaf));
    show("leaves-spot", &spot, roof("<rotate x='1' angle='12'/>", &leaf));
    show("leaves-lamp", &lamp("9,8,6"), roof("<rotate z='1' angle='-9'/>", &cut));
    show("leaves-sky", &sky, roof("", &leaf));
    let projector = float("fov", "50") + &bitmap("irradiance", "colors.png", "") + &float("scale", "8");
    show("leaves-projector", &emitter("projector", &(aimed + &projector)), roof("", &leaf));
    show("sheet-of-holes-sun", &sun, sheet(&leaf));
    show("glass-point", &point("9,8,6"), roof("<rotate x='1' angle='25'/>", &clear));
    show("glass-tinted-sun", &sun, roof("<rotate z='1' angle='30'/>", &pane));
    show("glass-ball-lamp", &lamp("9,8,6"), ball(&pane));
    show("glass-masked-point", &point("9,8,6"), roof("", &mask(&numbers("opacity", "numbers.png"), &pane)));
    let blend = float("weight", "0.3") + &bsdf("null", "") + &green;
    show("blend-of-null-sun", &sun, roof("", &bsdf("blendbsdf", &blend)));
    let box_around = |side: &str, bsdf: &str| {
        let steps = format!("<scale value='{side}'/><translate x='0.5' y='2.6' z='0.8'/>");
        shape("cube", &(placed(&steps) + bsdf))
    };
    let null = bsdf("null", "");
    show("null-box-point", &point("9,8,6"), box_around("0.4", &null));
    let nested = roof("", &mask(&float("opacity", "0.3"), &green))
        + &roof("<translate y='0.1'/>", &clear)
        + &roof("<translate y='0.2'/>", &leaf);
    show("nested-lamp", &lamp("20,18,14"), nested.clone());
    show("nested-point", &point("30,25,20"), nested + &box_around("0.4", &null));
    let metal = bsdf("roughconductor", &(string("material", "Cu") + &float("alpha", "0.2")));
    let metal = mask(&numbers("opacity", "numbers.png"), &two_sided(&metal));
    show("metal-with-holes-sky-and-sun", &(sky.clone() + &sun), roof("", &metal));
    let glowing = roof("", &(mask(&numbers("opacity", "numbers.png"), &diffuse("0.2,0.3,0.6")) + &area("0.5,0.8,1.5")));
    show("glowing-holes-lamp", &lamp("9,8,6"), glowing);
    for (name, bsdf) in [("null", null), ("mask", leaf), ("glass", clear)] {
        table.add(Passages, format!("hidden-behind-{name}"), |stage| {
            stage.integrator = volpath(&on("hide_emitters"));
            let globe =
                "<point name='center' x='0.9' y='1.1' z='-0.6'/>".to_owned() + &float("radius", "0.4") + &area("2,1,1");
            stage.subject = ball(&bsdf) + &sheet(&bsdf) + &shape("sphere", &globe) + &sky;
        });
    }
}
