//! Measured materials of `glsl/include/bsdf/measured.glsl`: Mitsuba's values, densities and samples. `scattering.rs` tests their samples
//! together with those of all other kinds.

use glam::DVec3;
use support::substances::{Substance, measured_of};

use crate::fixture::{Row, rows};
use crate::scattering::{Bench, ScatteringInput, d3, relative};

const FILES: [&str; 3] = ["isotropic.bsdf", "anisotropic.bsdf", "spectral.bsdf"];

fn substance(row: &Row) -> Substance {
    measured_of(FILES.into_iter().find(|name| *name == row.text("file")).expect("a file"))
}

/// Cases in which the twin or the device differs from Mitsuba's values, densities and samples, multiplied by `tamper`.
fn differing(tamper: f64) -> Vec<String> {
    let rows = rows("measured/values.json");
    assert_eq!(rows.len(), 240);
    let input = |row: &Row| ScatteringInput {
        bsdf: substance(row).device(),
        wo: row.vector("wo").as_vec3().into(),
        wi: row.vector("wi").as_vec3().into(),
        u: row.vector("u").as_vec3().into(),
    };
    let outputs = Bench::new().map(&rows.iter().map(input).collect::<Vec<_>>());
    let of = |row: &Row, at: usize| {
        let (substance, output) = (substance(row), &outputs[at]);
        let (wo, wi) = (row.vector("wo"), row.vector("wi"));
        let (value, pdf) = (tamper * row.vector("eval"), DVec3::splat(tamper * row.number("pdf")));

        // Mitsuba mirrors some samples of the file with spectra, which has no azimuths, so that mirrors change nothing.
        let has_spectra = row.text("file") == "spectral.bsdf";
        let off = if has_spectra { 0.0 } else { (d3(output.wi) - tamper * row.vector("sampled")).length() };
        [
            ("twin's value", relative(substance.eval(wo, wi), value), 1.0e-3),
            ("device's value", relative(d3(output.value), value), 1.0e-3),
            ("twin's density", relative(DVec3::splat(substance.pdf(wo, wi)), pdf), 1.0e-3),
            ("device's density", relative(DVec3::splat(output.pdf.into()), pdf), 1.0e-3),
            ("device's sample", off, 1.0e-3),
        ]
    };
    let cases = rows.iter().enumerate().flat_map(|(at, row)| of(row, at).map(|case| (row, case)));
    let differing = cases.filter(|(_, (_, deviation, tolerance))| deviation > tolerance);
    differing.map(|(row, (what, deviation, _))| format!("{what}: {deviation} {row:?}")).collect()
}

#[test]
fn measured_materials_are_mitsubas() {
    let differing_now = differing(1.0);
    assert!(differing_now.is_empty(), "{} differ:\n{}", differing_now.len(), differing_now.join("\n"));
    let tampered = differing(1.005).len();
    assert!(tampered > 800, "0.5 % more differs in {tampered} places only");
}
