//! Integrators: depths, Russian roulette, hidden emitters.

use super::xml::{area, ball, block, bsdf, default, diffuse, element, float, integer, on, path, rgb, shape};
use super::{Class::Paths, Table, plain_subject};

pub fn add(table: &mut Table) {
    for depth in [1, 2, 3, 17] {
        table.add(Paths, format!("depth-{depth}"), |stage| {
            stage.integrator = default("depth", &depth.to_string()) + &path("$depth");
            let globe =
                "<point name='center' x='0.2' y='1.6' z='1'/>".to_owned() + &float("radius", "0.2") + &area("2,1,1");
            stage.subject = plain_subject("0.6,0.7,0.5") + &shape("sphere", &globe);
        });
    }
    for (name, depth) in [("depth-256-glass", 256), ("depth-unlimited-glass", -1)] {
        table.add(Paths, name, |stage| {
            stage.integrator = path(depth);
            let glass = bsdf("dielectric", "<string name='int_ior' value='diamond'/>");
            stage.subject =
                ball(&glass) + &block(&glass) + &element("emitter", "constant", &rgb("radiance", "0.5,0.6,0.8"));
        });
    }
    for start in [1, 2] {
        table.add(Paths, format!("roulette-{start}"), |stage| {
            stage.integrator = element("integrator", "path", &(integer("max_depth", 12) + &integer("rr_depth", start)));
            stage.subject = plain_subject("0.3,0.7,0.5");
        });
    }
    for (name, sky) in [("hidden", ""), ("hidden-sky", "0.3,0.5,0.8")] {
        table.add(Paths, name, |stage| {
            stage.integrator = element("integrator", "path", &(integer("max_depth", 6) + &on("hide_emitters")));
            let globe =
                "<point name='center' x='0.2' y='1.6' z='1'/>".to_owned() + &float("radius", "0.3") + &area("2,1,1");
            stage.subject = plain_subject("0.2,0.5,0.7") + &shape("sphere", &globe);
            if !sky.is_empty() {
                stage.subject += &element("emitter", "constant", &rgb("radiance", sky));
            }
        });
    }
    table.show(Paths, "furnace-inside", {
        let inside =
            "<point name='center' x='0' y='1.2' z='2'/>".to_owned() + &float("radius", "6") + &on("flip_normals");
        shape("sphere", &(inside + &diffuse("0.7,0.6,0.5"))) + &plain_subject("0.8,0.7,0.9")
    });
}
