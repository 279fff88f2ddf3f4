//! Measured materials: one that may be turned, one that may not, within a `twosided`, and as a part of a blend. The scenes come after the
//! others, which so keep their numbers, which are their seeds.

use super::Class::Bsdfs;
use super::Table;
use super::xml::{ball, block, bsdf, diffuse, element, float, rgb, sheet, string, two_sided};

pub fn add(table: &mut Table) {
    let of = |file: &str| bsdf("measured", &string("filename", file));
    let sky = element("emitter", "constant", &rgb("radiance", "0.5,0.6,0.8"));
    for (name, file) in [("measured", "isotropic.bsdf"), ("measured-anisotropic", "anisotropic.bsdf")] {
        table.show(Bsdfs, name, ball(&of(file)) + &block(&of(file)));
        table.add(Bsdfs, format!("{name}-sky"), |stage| {
            stage.lamp = sky.clone();
            stage.subject = ball(&of(file)) + &sheet(&two_sided(&of(file)));
        });
    }
    let blend = bsdf("blendbsdf", &(float("weight", "0.4") + &of("anisotropic.bsdf") + &diffuse("0.3,0.5,0.7")));
    table.show(Bsdfs, "measured-blend", ball(&blend) + &block(&blend));
}
