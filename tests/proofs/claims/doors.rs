//! Claim: infinite values and values that are not numbers are stopped before the film and before the grids, and are
//! counted. Where sums of finite numbers overflow, all directions are uniform.

use std::f64::consts::PI;

use glam::Vec3;
use lodestar::renderer::Renderer;
use lodestar::scene::emitter::AreaEmitter;
use lodestar::scene::{Scene, Textured};
use lodestar::settings::{Learner, Mix, SamplePattern, Sampler, Settings};
use support::guide_cases::{Guided, settings};
use support::scenes::ours;

use crate::evidence::Evidence;
use crate::renders::{Studio, steps};
use crate::rows::{Row, Scope, further_learners, kind_of};
use crate::subject::Subject;

const SIDE: u32 = 16;
const SEED: u32 = 1000;
/// Radiance of the light, and whether its samples must be counted as dropped.
const EMISSIONS: [(f32, bool); 5] =
    [(f32::NAN, true), (f32::INFINITY, true), (-1.0, false), (3.0e37, false), (f32::MIN_POSITIVE, false)];

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    for row in scope.guided() {
        check_tables(subject, &row, evidence);
        for (emission, is_counted) in EMISSIONS {
            check_emission(&studio, subject, &row, Learner::Sarsa, emission, is_counted, evidence);
        }
    }
    if !scope.is_narrow() {
        for (_, learner) in further_learners() {
            check_emission(&studio, subject, &scope.guided()[0], learner, f32::NAN, true, evidence);
        }
    }
}

/// The Cornell box with a lamp of radiance `emission`.
fn lit_by(emission: f32) -> Scene {
    let mut scene = ours("cornell-box/scene.xml", &[]);
    for emitter in &mut scene.emitters {
        *emitter = AreaEmitter::new(Textured::constant(Vec3::splat(emission)));
    }
    scene
}

fn check_emission(
    studio: &Studio,
    subject: &Subject,
    row: &Row,
    learner: Learner,
    emission: f32,
    is_counted: bool,
    evidence: &mut Evidence,
) {
    let scene = lit_by(emission);
    let mut settings = Settings {
        width: SIDE,
        height: SIDE,
        seed: SEED,
        grid: Some(4),
        nee: false,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(&scene)
    };
    row.set(&mut settings);
    settings.learner = learner;
    let case = format!("{}, {learner:?}, a lamp of {emission}", row.name);
    let spp = settings.spp_per_step;
    let mut renderer = studio.renderer(subject, &scene, settings.clone());
    let first = steps(&mut renderer, spp, spp);
    // The first step draws the samples of a plain path tracer. A plain path tracer has no targets, so it counts samples
    // alone.
    let plain =
        Settings { sampler: Sampler::Bsdf, learner: Learner::Sarsa, mix: Mix::Density, epsilon: None, ..settings };
    let plain = studio.render(subject, &scene, plain, spp).1;
    evidence.hold(format!("targets, {case}"), (first.nonfinite > plain.nonfinite) == is_counted, || {
        format!("{} were dropped with targets, {} without", first.nonfinite, plain.nonfinite)
    });
    let mut counts = steps(&mut renderer, spp, 2 * spp);
    counts.add(&first);
    let camera_samples = u64::from(SIDE * SIDE * 3 * spp);
    evidence.hold(format!("count, {case}"), (counts.nonfinite > 0) == is_counted, || {
        format!("{} of {camera_samples} samples were counted", counts.nonfinite)
    });
    let picture = renderer.picture().expect("a picture");
    let is_finite = picture.radiance.iter().flatten().all(|l| l.is_finite());
    evidence.hold(format!("film, {case}"), is_finite, || "it holds what is no number".into());
    check_grids(&renderer, row, &case, evidence);
}

/// Radiance and factors are finite, and none is negative. The product sampler has weights of a few bits in place of
/// factors. Every pattern of bits is a valid weight.
fn check_grids(renderer: &Renderer, row: &Row, case: &str, evidence: &mut Evidence) {
    let state = renderer.state().expect("a state");
    let names = ["radiance", "learned radiance", "normalizers"];
    let count = if kind_of(row).rules.sampler == Sampler::Product { 2 } else { 3 };
    for name in &names[..count] {
        let part = state.parts.iter().find(|part| part.name == *name).expect("a part");
        let values: Vec<f32> = bytemuck::pod_collect_to_vec(&part.bytes);
        let wrong = values.iter().filter(|value| !value.is_finite() || **value < 0.0).count();
        evidence
            .hold(format!("{name}, {case}"), wrong == 0, || format!("{wrong} of {} numbers are wrong", values.len()));
    }
}

/// Finite numbers whose sum overflows give uniform directions.
fn check_tables(subject: &Subject, row: &Row, evidence: &mut Evidence) {
    let kind = kind_of(row);
    let guided = Guided::with(kind, &subject.guide_kernels());
    let setting = &settings(kind.map)[0];
    for wrong in [f32::MAX, 1.0e38] {
        let table: Vec<f32> = (0..256).map(|bin| if bin == 77 { wrong } else { 1.0 }).collect();
        guided.fill(&table);
        let densities = guided.densities(setting);
        let integral = 4.0 * PI * densities.iter().map(|d| f64::from(d.pdf)).sum::<f64>() / densities.len() as f64;
        let case = format!("{}, a bin of {wrong}", row.name);
        evidence.hold(format!("density, {case}"), (integral - 1.0).abs() < 1.0e-4, || {
            format!("its integral is {integral}")
        });
        let drawn = guided.draw(setting, SEED, 4096);
        let is_finite = drawn.iter().all(|d| d.pdf.is_finite() && d.direction().is_finite() && d.overrun == 0);
        evidence.hold(format!("samples, {case}"), is_finite, || "some are no numbers".into());
    }
}
