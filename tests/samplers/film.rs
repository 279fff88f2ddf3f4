//! Thin films of `glsl/include/math/thin_film.glsl`.

use glam::DVec3;
use support::scattering_cases::{Base, surfaces};
use support::substances::Substance;
use support::twins::conductor::Conductor;
use support::twins::film::Film;

use crate::fixture::{Row, rows};
use crate::scattering::{Bench, LOBE_DELTA, ScatteringInput, ScatteringOutput, d3};

/// Largest error of a color over dielectrics and over metals, and the largest mean: the sum ends after four terms, and Gaussians stand for
/// the observer.
const BOUNDS: [f64; 2] = [0.007, 0.025];
const MEANS: [f64; 2] = [8.0e-4, 2.0e-3];

fn seen_from(wo: DVec3, substance: &Substance) -> ScatteringInput {
    ScatteringInput { bsdf: substance.device(), wo: wo.as_vec3().into(), wi: [0.0, 0.0, 1.0], u: [0.5; 3] }
}

/// Largest and mean errors of the device, over dielectrics and over metals, if films are changed. A smooth metal shows the reflectance as its
/// weight; without absorption, it is a dielectric.
fn errors(rows: &[Row], change: impl Fn(&mut Film)) -> [[f64; 2]; 2] {
    let input = |row: &Row| {
        let mut film = Film { thickness: row.number("thickness"), eta: row.number("film") };
        change(&mut film);
        let [eta, k] = ["eta", "k"].map(|name| row.vector(name));
        let metal = Conductor { specular_reflectance: DVec3::ONE, eta, k, film: Some(film) };
        let cosine = row.number("cosine");
        seen_from(DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine), &Substance::Conductor(metal))
    };
    let outputs = Bench::new().map(&rows.iter().map(input).collect::<Vec<_>>());
    [false, true].map(|is_metal| {
        let of_base = rows.iter().zip(&outputs).filter(|(row, _)| row.is("metal") == is_metal);
        let offs: Vec<_> = of_base.map(|(row, o)| (d3(o.weight) - row.vector("color")).abs()).collect();
        let mean = offs.iter().map(|off| off.element_sum()).sum::<f64>() / (3 * offs.len()) as f64;
        [offs.iter().map(|off| off.max_element()).fold(0.0, f64::max), mean]
    })
}

/// Colors are those of Airy's formula at many wavelengths, seen by the standard observer.
#[test]
fn films_have_the_colors_of_airys_formula() {
    let rows = rows("film/values.json");
    assert_eq!(rows.len(), 300);
    let found = errors(&rows, |_| ());
    println!("largest and mean errors over dielectrics and metals: {found:.4?}");
    for (i, [most, mean]) in found.into_iter().enumerate() {
        assert!(most < BOUNDS[i] && mean < MEANS[i], "{found:?}");
    }
    let thicker = errors(&rows, |film| film.thickness *= 1.03);
    let denser = errors(&rows, |film| film.eta *= 1.03);
    for tampered in [thicker, denser] {
        assert!((0..2).all(|i| tampered[i][1] > MEANS[i]), "the twins, a film that is 3 % off: {tampered:?}");
    }
}

/// A film without thickness leaves every bit as it is without a film.
#[test]
fn a_film_without_thickness_is_none() {
    let bench = Bench::new();
    let directions = [[0.3, -0.2, 0.9], [0.8, 0.1, 0.3], [-0.4, 0.5, -0.6]].map(|v| DVec3::from(v).normalize());
    let outputs = |film: Option<[f32; 2]>| -> Vec<ScatteringOutput> {
        let filmed = surfaces().into_iter().filter(|surface| match &surface.base {
            Base::Principled(b) => b.film.is_some(),
            Base::Substance(b) => b.film().is_some(),
            _ => false,
        });
        let inputs: Vec<_> = filmed
            .flat_map(|surface| {
                let mut bsdf = surface.device();
                bsdf.film = film.unwrap_or(bsdf.film);
                directions.into_iter().flat_map(move |wo| {
                    [0.1, 0.5, 0.9].map(|u| ScatteringInput {
                        bsdf,
                        wo: wo.as_vec3().into(),
                        wi: directions[0].as_vec3().into(),
                        u: [0.4, 0.7, u],
                    })
                })
            })
            .collect();
        assert!(inputs.len() >= 90);
        bench.map(&inputs)
    };
    let bits = |outputs: &[ScatteringOutput]| bytemuck::cast_slice::<_, u8>(outputs).to_vec();
    let none = bits(&outputs(Some([0.0; 2])));
    assert_eq!(none, bits(&outputs(Some([0.0, 1.7]))));
    assert_ne!(none, bits(&outputs(None)), "the twin: films with a thickness");
    let plain = Conductor { specular_reflectance: DVec3::ONE, eta: DVec3::ONE, k: DVec3::splat(2.0), film: None };
    assert_eq!(bench.map(&[seen_from(DVec3::Z, &Substance::Conductor(plain))])[0].lobe, LOBE_DELTA);
}
