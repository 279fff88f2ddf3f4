//! `glsl/include/bsdf_principled.glsl`

use glam::DVec3;
use lodestar::reference::principled::{Principled, eval_bsdf_principled, pdf_bsdf_principled};

use crate::fixture::{Row, rows};

pub fn principled(row: &Row) -> Principled {
    Principled {
        base_color: row.vector("base_color"),
        eta: row.number("eta"),
        roughness: row.number("roughness"),
        anisotropic: row.number("anisotropic"),
        metallic: row.number("metallic"),
        spec_trans: row.number("spec_trans"),
        spec_tint: row.number("spec_tint"),
        sheen: row.number("sheen"),
        sheen_tint: row.number("sheen_tint"),
        flatness: row.number("flatness"),
        clearcoat: row.number("clearcoat"),
        clearcoat_gloss: row.number("clearcoat_gloss"),
    }
}

/// The largest relative deviation of the twin's values from Mitsuba's, of f cos and of the density.
fn deviations(change: impl Fn(Principled) -> Principled) -> [f64; 2] {
    let relative = |a: DVec3, b: DVec3| (a - b).length() / (b.length() + 1.0e-4);
    rows("principled/values.json").iter().fold([0.0; 2], |[value, density], row| {
        let (b, wo, wi) = (change(principled(row)), row.vector("wo"), row.vector("wi"));
        let eval = relative(eval_bsdf_principled(&b, wo, wi), row.vector("eval"));
        let pdf = relative(DVec3::splat(pdf_bsdf_principled(&b, wo, wi)), DVec3::splat(row.number("pdf")));
        assert!(
            eval < 1.0e-3 && pdf < 1.0e-3,
            "{eval} {pdf}: {} {} {row:?}",
            eval_bsdf_principled(&b, wo, wi),
            pdf_bsdf_principled(&b, wo, wi)
        );
        [value.max(eval), density.max(pdf)]
    })
}

#[test]
fn the_twin_has_mitsubas_values() {
    let [eval, pdf] = deviations(|b| b);
    println!("largest relative deviations: {eval:.1e}, {pdf:.1e}");
    assert!(eval < 1.0e-3 && pdf < 1.0e-3, "{eval} {pdf}");
}
