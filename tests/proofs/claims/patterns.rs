//! Claim: pictures from samples in sets agree with pictures from independent samples. Dependence between the samples of
//! a set does not change the mean.

use lodestar::film::Picture;
use lodestar::settings::{SamplePattern, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::rows::row;
use support::scenes::{ours, steady};

use crate::evidence::{Evidence, Record};
use crate::renders::Studio;
use crate::rows::{Row, Scope, UNGUIDED};
use crate::subject::{SHIPPED, Subject};

const SIDE: u32 = 24;
const SPP: u32 = 512;
const SEED: u32 = 1000;
/// Patterns with sets of samples.
const SETS: [SamplePattern; 2] = [SamplePattern::Sobol, SamplePattern::BlueNoise];
/// Rows of the short form: one whose sets reach over steps, and one whose sets do not.
const SHORT: [&str; 2] = ["bsdf", "product"];

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    let independent = render(&studio, &SHIPPED, &row(UNGUIDED), SamplePattern::Independent, SEED);
    let is_wanted = |row: &Row| scope.full || scope.is_narrow() || SHORT.contains(&row.name);
    for row in scope.rendered().iter().filter(|row| is_wanted(row)) {
        for pattern in SETS {
            let sets = render(&studio, subject, row, pattern, SEED + 1);
            // Both variances are those of independent samples. Sets have less error (`tests/render/pattern.rs`), so p
            // is too large.
            let comparison = Comparison::new(&Estimate::of(&independent), &Estimate::of(&sets), &[6, WHOLE]);
            let name = format!("{}, {pattern:?}, seeds {SEED} and {}", row.name, SEED + 1);
            let is_known = comparison.largest.iter().all(|&(_, count)| count > 0);
            evidence.hold(format!("noise, {name}"), is_known, || "the noise is too strong to compare anything".into());
            evidence.test(format!("picture, {name}: {comparison:?}"), comparison.p, || {
                Record::Pictures(vec![sets.image(), independent.image()])
            });
        }
    }
}

fn render(studio: &Studio, subject: &Subject, row: &Row, pattern: SamplePattern, seed: u32) -> Picture {
    let scene = ours("cornell-box/scene.xml", &[]);
    let mut settings = Settings { width: SIDE, height: SIDE, seed, nee: true, pattern, ..Settings::for_scene(&scene) };
    row.set(&mut settings);
    studio.render(subject, &scene, steady(settings), SPP).0
}
