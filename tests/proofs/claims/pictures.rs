//! Claim: pictures with a guide agree with pictures without one, up to noise, at every scale, with and without emitter
//! sampling.

use std::collections::HashMap;
use std::sync::{LazyLock, Mutex};

use lodestar::film::Picture;
use lodestar::scene::Scene;
use lodestar::settings::{Learner, SamplePattern, Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::panes::with_panes;
use support::rows::row;
use support::scenes::{ours, steady};

use crate::evidence::{Evidence, Record};
use crate::renders::Studio;
use crate::rows::{Row, Scope, UNGUIDED, further_learners};
use crate::subject::{SHIPPED, Subject};

/// A scene and its samples per pixel: without and with a guide, each without and with emitter sampling.
struct Case {
    file: &'static str,
    size: [u32; 2],
    unguided: [u32; 2],
    guided: [u32; 2],
    sides: &'static [usize],
}

const CASES: [Case; 4] = [
    Case { file: "cornell-box", size: [24, 24], unguided: [2048, 256], guided: [512, 128], sides: &[6, WHOLE] },
    Case { file: "cornell-box-hard", size: [24, 24], unguided: [2048, 1024], guided: [512, 256], sides: &[12, WHOLE] },
    Case { file: "door-ajar", size: [32, 18], unguided: [4096, 1024], guided: [1024, 256], sides: &[WHOLE] },
    Case { file: PANES, size: [24, 24], unguided: [4096, 512], guided: [1024, 256], sides: &[6, WHOLE] },
];
/// The Cornell box with holes and thin sheets of glass below its lamp.
const PANES: &str = "cornell-box with panes";
const UNGUIDED_SEED: u32 = 600;
const GUIDED_SEED: u32 = 700;
/// Factor on the number of samples in the full form.
const FULL: u32 = 2;

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    // In the short form, the claim `doors` tests doors.
    let count = if scope.is_narrow() {
        1
    } else if scope.full {
        CASES.len()
    } else {
        2
    };
    let cases = &CASES[..count];
    for (index, case) in cases.iter().enumerate() {
        let scene = match case.file {
            PANES => with_panes(ours("cornell-box/scene.xml", &[])),
            file => ours(&format!("{file}/scene.xml"), &[]),
        };
        for nee in [false, true] {
            // All samplers and learners render the first scene. In the short form, the other scenes have one row each,
            // because `tests/render/ztest.rs` renders more pictures.
            let rows: Vec<_> = scope.rendered().into_iter().filter(|row| row.name != UNGUIDED).collect();
            let rows = if scope.full || (index == 0 && nee) { &rows[..] } else { &rows[..1] };
            let unguided = case.unguided(&studio, &scene, scope, nee);
            let mut compare = |row: &Row, learner: Option<Learner>, name: &str| {
                let guided = case.render(&studio, subject, &scene, scope, nee, |s| {
                    row.set(s);
                    (s.seed, s.learner) = (GUIDED_SEED, learner.unwrap_or(s.learner));
                });
                let comparison = Comparison::new(&Estimate::of(&unguided), &Estimate::of(&guided), case.sides);
                let name =
                    format!("{}, {name}, emitters sampled: {nee}, seeds {UNGUIDED_SEED}, {GUIDED_SEED}", case.file);
                let is_known = comparison.largest.iter().all(|&(_, count)| count > 0);
                evidence
                    .hold(format!("noise, {name}"), is_known, || "the noise is too strong to compare anything".into());
                evidence.test(format!("picture, {name}: {comparison:?}"), comparison.p, || {
                    Record::Pictures(vec![guided.image(), unguided.image()])
                });
            };
            rows.iter().for_each(|row| compare(row, None, row.name));
            if (index == 0 && !nee && !scope.is_narrow()) || scope.full {
                further_learners().iter().for_each(|(name, learner)| compare(&rows[0], Some(*learner), name));
            }
        }
    }
}

/// Pictures without a guide by file, emitter sampling and length. All subjects share them.
type Unguided = HashMap<(&'static str, bool, bool), Picture>;

impl Case {
    fn unguided(&self, studio: &Studio, scene: &Scene, scope: Scope, nee: bool) -> Picture {
        static KNOWN: LazyLock<Mutex<Unguided>> = LazyLock::new(Mutex::default);
        let mut known = KNOWN.lock().expect("no test panics with it");
        let render = || {
            self.render(studio, &SHIPPED, scene, scope, nee, |s| {
                row(UNGUIDED).set(s);
                s.seed = UNGUIDED_SEED;
            })
        };
        known.entry((self.file, nee, scope.full)).or_insert_with(render).clone()
    }

    fn render(
        &self,
        studio: &Studio,
        subject: &Subject,
        scene: &Scene,
        scope: Scope,
        nee: bool,
        change: impl FnOnce(&mut Settings),
    ) -> Picture {
        let [width, height] = self.size;
        let mut settings =
            Settings { width, height, nee, pattern: SamplePattern::Independent, ..Settings::for_scene(scene) };
        change(&mut settings);
        let settings = steady(settings);
        let guided = settings.sampler != Sampler::Bsdf;
        let spp = if guided { self.guided } else { self.unguided }[usize::from(nee)];
        let spp = if scope.full { FULL * spp } else { spp };
        studio.render(subject, scene, settings, spp).0
    }
}
