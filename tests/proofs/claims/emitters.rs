//! Claim: emitter sampling and light hits add up to the radiance of a floor in closed form, with and without a guide.

use lodestar::settings::{SamplePattern, Settings};
use support::estimate::Estimate;
use support::floor::{DELTA, SPREAD, floor_radiance};
use support::scenes::{ours, steady};
use support::significance::two_sided;

use crate::evidence::{Evidence, Record};
use crate::renders::Studio;
use crate::rows::Scope;
use crate::subject::Subject;

const SIDE: u32 = 16;
const SPP: u32 = 512;
const SEED: u32 = 900;

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    let rows = scope.all();
    let rows = if scope.full || scope.is_narrow() { &rows[..] } else { &rows[..2] };
    // `tests/render/nee.rs` tests all lights, with and without emitter sampling, for two samplers.
    let few = ["rectangle", "constant"];
    let is_wanted = |light: &&str| scope.full || few.contains(light);
    for light in SPREAD.into_iter().chain(DELTA).filter(is_wanted) {
        let scene = ours("lights/floor.xml", &[("light", light)]);
        for row in rows {
            let mut settings = Settings {
                width: SIDE,
                height: SIDE,
                seed: SEED,
                nee: true,
                pattern: SamplePattern::Independent,
                ..Settings::for_scene(&scene)
            };
            row.set(&mut settings);
            let (picture, _) = studio.render(subject, &scene, steady(settings), SPP);
            let (mean, error) = Estimate::of(&picture).gray();
            let expected = floor_radiance(light);
            // The added error covers single precision and a camera that sees more than one point.
            let z = (mean - expected) / error.hypot(1.0e-5 * expected);
            let case = format!("floor, {light}, {}, seed {SEED}: {mean:.6} +- {error:.6}, not {expected:.6}", row.name);
            evidence.test(case, two_sided(z), || Record::Pictures(vec![picture.image()]));
        }
    }
}
