//! Principled surfaces of `glsl/include/bsdf/principled.glsl` and `bsdf/principled_thin.glsl`.

use glam::DVec3;
use support::twins::principled::{Principled, eval_bsdf_principled, pdf_bsdf_principled};
use support::twins::principled_thin::{PrincipledThin, eval_bsdf_principled_thin, pdf_bsdf_principled_thin};

use crate::fixture::{Row, rows};

fn principled(row: &Row) -> Principled {
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
        film: None,
    }
}

/// Largest relative deviation of the twin from Mitsuba, for f cos and for the density, with one parameter changed.
fn deviations(change: impl Fn(&mut Principled)) -> [f64; 2] {
    worst("principled/values.json", |row, wo, wi| {
        let mut b = principled(row);
        change(&mut b);
        (eval_bsdf_principled(&b, wo, wi), pdf_bsdf_principled(&b, wo, wi))
    })
}

/// Largest relative deviation of the value and of the density that a twin gives for the rows of a file.
fn worst(file: &str, twin: impl Fn(&Row, DVec3, DVec3) -> (DVec3, f64)) -> [f64; 2] {
    let relative = |a: DVec3, b: DVec3| (a - b).length() / (b.length() + 1.0e-4);
    let deviation = |row: Row| {
        let (value, pdf) = twin(&row, row.vector("wo"), row.vector("wi"));
        let [pdf, expected] = [pdf, row.number("pdf")].map(DVec3::splat);
        [relative(value, row.vector("eval")), relative(pdf, expected)]
    };
    let all = rows(file).into_iter().map(deviation);
    all.fold([0.0; 2], |worst, off| [worst[0].max(off[0]), worst[1].max(off[1])])
}

/// Largest relative deviation of the thin twin from Mitsuba, for f cos and for the density, with one parameter changed.
fn thin_deviations(change: impl Fn(&mut PrincipledThin)) -> [f64; 2] {
    worst("principled/thin.json", |row, wo, wi| {
        let mut b = PrincipledThin {
            base_color: row.vector("base_color"),
            eta: row.number("eta"),
            roughness: row.number("roughness"),
            anisotropic: row.number("anisotropic"),
            spec_trans: row.number("spec_trans"),
            spec_tint: row.number("spec_tint"),
            sheen: row.number("sheen"),
            sheen_tint: row.number("sheen_tint"),
            flatness: row.number("flatness"),
            diff_trans: row.number("diff_trans"),
        };
        change(&mut b);
        (eval_bsdf_principled_thin(&b, wo, wi), pdf_bsdf_principled_thin(&b, wo, wi))
    })
}

#[test]
fn the_thin_twin_has_mitsubas_values() {
    let [eval, pdf] = thin_deviations(|_| ());
    println!("largest relative deviations: {eval:.1e}, {pdf:.1e}");
    assert!(eval < 3.0e-4 && pdf < 3.0e-4, "{eval} {pdf}");
}

#[test]
fn every_parameter_of_a_thin_sheet_matters() {
    type Field = fn(&mut PrincipledThin) -> &mut f64;
    let fields: [Field; 9] = [
        |b| &mut b.eta,
        |b| &mut b.roughness,
        |b| &mut b.anisotropic,
        |b| &mut b.spec_trans,
        |b| &mut b.spec_tint,
        |b| &mut b.sheen,
        |b| &mut b.sheen_tint,
        |b| &mut b.flatness,
        |b| &mut b.diff_trans,
    ];
    for (index, field) in fields.iter().enumerate() {
        let [eval, _] = thin_deviations(|b| *field(b) *= 0.97);
        assert!(eval > 1.0e-3, "the twin: parameter {index} 3 % off is {eval} off");
    }
}

#[test]
fn the_twin_has_mitsubas_values() {
    let [eval, pdf] = deviations(|_| ());
    println!("largest relative deviations: {eval:.1e}, {pdf:.1e}");
    assert!(eval < 3.0e-4 && pdf < 3.0e-4, "{eval} {pdf}");
}

#[test]
fn every_parameter_matters() {
    type Field = fn(&mut Principled) -> &mut f64;
    let fields: [Field; 11] = [
        |b| &mut b.eta,
        |b| &mut b.roughness,
        |b| &mut b.anisotropic,
        |b| &mut b.metallic,
        |b| &mut b.spec_trans,
        |b| &mut b.spec_tint,
        |b| &mut b.sheen,
        |b| &mut b.sheen_tint,
        |b| &mut b.flatness,
        |b| &mut b.clearcoat,
        |b| &mut b.clearcoat_gloss,
    ];
    for (index, field) in fields.iter().enumerate() {
        let [eval, _] = deviations(|b| *field(b) *= 0.97);
        assert!(eval > 1.0e-3, "the twin: parameter {index} 3 % off is {eval} off");
    }
}
