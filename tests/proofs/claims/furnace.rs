//! Claim: inside a surface that emits and reflects alike everywhere, every path of `n` edges brings the same radiance,
//! with any sampler.

use lodestar::settings::{SamplePattern, Settings};
use support::estimate::Estimate;
use support::scenes::{ours, steady};
use support::significance::two_sided;

use crate::evidence::{Evidence, Record};
use crate::renders::Studio;
use crate::rows::{Row, Scope, further_learners};
use crate::subject::Subject;

const SIDE: u32 = 32;
const SPP: u32 = 64;
const SEED: u32 = 500;
/// Relative rounding error of a sum of `SPP` samples in single precision.
const ROUNDING: f64 = 1.0e-6;

/// Settings of one picture of the furnace.
struct Case {
    file: &'static str,
    rr_depth: u32,
    nee: bool,
}

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    let case = |file, rr_depth, nee| Case { file, rr_depth, nee };
    // `tests/render/analytic.rs` tests more cases in the short form.
    let mut cases = vec![case("furnace/scene.xml", 2, true)];
    if scope.full {
        cases.extend([
            case("furnace/scene.xml", 8, false),
            case("furnace/mesh.xml", 8, true),
            case("furnace/mesh.xml", 2, false),
        ]);
    }
    for row in scope.rendered() {
        cases.iter().for_each(|case| test_case(&studio, subject, &row, case, |_| {}, row.name, evidence));
    }
    // Learners differ only in the radiance that they learn, so one sampler is enough for all of them.
    for (name, learner) in further_learners().iter().filter(|_| !scope.is_narrow()) {
        let row = scope.guided()[0];
        test_case(&studio, subject, &row, &cases[0], |s| s.learner = *learner, name, evidence);
    }
}

fn test_case(
    studio: &Studio,
    subject: &Subject,
    row: &Row,
    case: &Case,
    change: impl FnOnce(&mut Settings),
    name: &str,
    evidence: &mut Evidence,
) {
    let Case { file, rr_depth, nee } = *case;
    let scene = ours(file, &[]);
    let mut settings = Settings {
        width: SIDE,
        height: SIDE,
        seed: SEED,
        rr_depth,
        nee,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(&scene)
    };
    row.set(&mut settings);
    change(&mut settings);
    let settings = steady(settings);
    // The surface emits 0.5 and reflects half.
    let expected = 1.0 - 0.5_f64.powi(settings.max_depth as i32);
    let (picture, _) = studio.render(subject, &scene, settings, SPP);
    let (mean, error) = Estimate::of(&picture).gray();
    let z = (mean - expected) / error.hypot(ROUNDING);
    let case = format!(
        "radiance, {file}, {name}, roulette from {rr_depth}, emitters sampled: {nee}, seed {SEED}: {mean:.5} +- {error:.5}"
    );
    evidence.test(case, two_sided(z), || Record::Pictures(vec![picture.image()]));
}
