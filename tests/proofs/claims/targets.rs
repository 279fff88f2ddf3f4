//! Claim: in a furnace, each step learns the radiance of the closed form. For a surface that emits `e` and reflects a
//! share `a`, the mean target of step k is e (1 - a^k) / (1 - a) (Eq. 5, Eq. 6), and the mean return over two edges is
//! e (1 + a).

use lodestar::generated::layout::LearnedRadiance;
use lodestar::renderer::{RenderState, Renderer};
use lodestar::settings::{Learner, SamplePattern, Sampler, Settings};
use statrs::distribution::{ContinuousCDF, StudentsT};
use support::rows::learners;
use support::scenes::ours;
use support::statistics::mean_and_error;

use crate::evidence::{Evidence, Record};
use crate::renders::Studio;
use crate::rows::{Row, Scope};
use crate::subject::Subject;

const SIDE: u32 = 16;
/// Bins along each side. They are few, so that every step reaches all of them. The grid has one cell.
const DIRECTIONS: u32 = 4;
/// Decay of old targets: all are forgotten, so a step's means depend on that step only.
const DECAY: f32 = 0.0;
const STEPS: i32 = 3;
/// Number of renders with other random numbers. Their spread gives the error.
const REPLICATES: u32 = 16;
/// Distance between the sample ranges of two replicates, in samples per pixel.
const STRIDE: u32 = 10_000;
const SEED: u32 = 300;
/// Relative error of single precision and fixed-point targets.
const ROUNDING: f64 = 3.0e-6;
/// Albedo and emission of the furnaces.
const FURNACES: [(&str, &str); 2] = [("0.5", "0.5"), ("0.9", "0.1")];

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    for (index, row) in scope.guided().iter().enumerate() {
        for (name, learner) in &learners() {
            // One sampler is enough for all of them.
            if scope.full || index == 0 || *learner == Learner::Sarsa {
                let furnaces = if scope.full || index == 0 { &FURNACES[..] } else { &FURNACES[..1] };
                for furnace in furnaces {
                    test_learner(&studio, subject, row, (name, *learner), *furnace, evidence);
                }
            }
        }
    }
}

fn test_learner(
    studio: &Studio,
    subject: &Subject,
    row: &Row,
    (name, learner): (&str, Learner),
    (albedo, emission): (&str, &str),
    evidence: &mut Evidence,
) {
    let scene = ours("furnace/scene.xml", &[("albedo", albedo), ("emission", emission)]);
    // Russian roulette starts at the first vertex that may be recorded.
    let (max_depth, rr_depth) = if learner == Learner::MonteCarlo { (3, 1) } else { (16, 2) };
    let mut settings = Settings {
        seed: SEED,
        max_depth,
        rr_depth,
        nee: false,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(&scene)
    };
    row.set(&mut settings);
    (settings.width, settings.height, settings.grid, settings.learner) = (SIDE, SIDE, Some(1), learner);
    // The product sampler needs at least 16 bins along each side. They need more samples to be reached.
    let (directions, spp_per_step) = match settings.sampler {
        Sampler::Product => (16, 16 * settings.spp_per_step),
        _ => (DIRECTIONS, settings.spp_per_step),
    };
    let settings = Settings { directions, spp_per_step, decay: DECAY, ..settings };
    let mut renderer = studio.renderer(subject, &scene, settings.clone());
    let empty = renderer.state().expect("a state");
    let [a, e] = [albedo, emission].map(|text| text.parse::<f64>().expect("a number"));
    let found: Vec<_> = (1..=REPLICATES).map(|k| replicate(&mut renderer, &empty, k, settings.spp_per_step)).collect();
    for step in 1..=STEPS {
        let expected = match learner {
            Learner::MonteCarlo => e * (1.0 + a),
            _ => e * (1.0 - a.powi(step)) / (1.0 - a),
        };
        let case = format!("{}, {name}, albedo {albedo}, step {step}, seed {SEED}", row.name);
        let of_step = found.iter().map(|steps| steps[step as usize - 1]);
        // Returns do not depend on the table.
        let reached = learner == Learner::MonteCarlo || of_step.clone().all(|(_, reached)| reached);
        evidence.hold(format!("bins, {case}"), reached, || "not every bin has targets".into());
        let (mean, error) = mean_and_error(of_step.map(|(mean, _)| mean));
        let t = (mean - expected) / error.hypot(ROUNDING * expected);
        let p = 2.0 * StudentsT::new(0.0, 1.0, f64::from(REPLICATES - 1)).expect("positive").sf(t.abs());
        evidence
            .test(format!("mean target, {case}: {mean:.6} +- {error:.6}, not {expected:.6}"), p, || Record::Nothing);
    }
}

/// Renders again with other samples. Returns for each step the mean of all targets, and whether every bin had one.
fn replicate(renderer: &mut Renderer, empty: &RenderState, number: u32, spp: u32) -> Vec<(f64, bool)> {
    renderer.restore(&RenderState { samples_done: number * STRIDE, ..empty.clone() }).expect("restored");
    let step = |_| {
        renderer.step(spp, &|| false).expect("a step");
        mean_target(&renderer.state().expect("a state"))
    };
    (0..STEPS).map(step).collect()
}

fn mean_target(state: &RenderState) -> (f64, bool) {
    let part = state.parts.iter().find(|part| part.name == "learned radiance").expect("a part");
    let learned: Vec<LearnedRadiance> = bytemuck::pod_collect_to_vec(&part.bytes);
    let weighted = |f: &dyn Fn(&LearnedRadiance) -> f32| -> f64 {
        learned.iter().map(|l| f64::from(l.weight) * f64::from(f(l))).sum()
    };
    (weighted(&|l| l.mean) / weighted(&|_| 1.0), learned.iter().all(|l| l.weight > 0.0))
}
