//! Claim: Russian roulette ends paths without changing the picture's mean, without and with emitter sampling. Most samplers
//! play it by throughput, `product` by expected contribution. With emitter sampling, an ended path of `product` brings what the guide
//! expects.

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
const SPP: u32 = 1024;
const SEED: u32 = 800;
/// Rows of the short form: one with roulette by throughput, one with roulette by expected contribution.
const SHORT: [&str; 2] = ["rejection-mix", "product"];

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    let without = [false, true].map(|nee| render(&studio, &SHIPPED, &row(UNGUIDED), nee, u32::MAX, SEED, SPP));
    let is_wanted = |row: &Row| scope.full || scope.is_narrow() || SHORT.contains(&row.name);
    for row in scope.all().iter().filter(|row| is_wanted(row)) {
        let rr_depths = if scope.full || scope.is_narrow() { &[1, 3][..] } else { &[1] };
        let cases = rr_depths.iter().flat_map(|&rr_depth| [(rr_depth, false), (rr_depth, true)]);
        for (rr_depth, nee) in cases {
            let without = &without[usize::from(nee)];
            let with = render(&studio, subject, row, nee, rr_depth, SEED + rr_depth, SPP);
            let comparison = Comparison::new(&Estimate::of(without), &Estimate::of(&with), &[6, WHOLE]);
            let case = format!(
                "picture, {}, emitter sampling {}, roulette from edge {rr_depth}, seeds {SEED} and {}: {comparison:?}",
                row.name,
                if nee { "on" } else { "off" },
                SEED + rr_depth
            );
            evidence.test(case, comparison.p, || Record::Pictures(vec![with.image(), without.image()]));
        }
    }
}

fn render(studio: &Studio, subject: &Subject, row: &Row, nee: bool, rr_depth: u32, seed: u32, spp: u32) -> Picture {
    let scene = ours("cornell-box/scene.xml", &[]);
    let mut settings = Settings {
        width: SIDE,
        height: SIDE,
        seed,
        rr_depth,
        nee,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(&scene)
    };
    row.set(&mut settings);
    studio.render(subject, &scene, steady(settings), spp).0
}
