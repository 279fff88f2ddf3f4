//! Claim: emitter sampling and light hits add up to the radiance of a floor in closed form, with and without a guide, also where
//! light comes through holes and through surfaces that refract.

use lodestar::settings::{SamplePattern, Settings};
use support::estimate::Estimate;
use support::floor::{DELTA, SPREAD, floor_radiance};
use support::panes::{Pane, covered};
use support::scenes::{ours, steady};
use support::significance::two_sided;

use crate::evidence::{Evidence, Record};
use crate::renders::Studio;
use crate::rows::Scope;
use crate::subject::Subject;

/// Surfaces above the floor that let light through, and the lights that shine through them.
const PANES: [Pane; 2] = [Pane::Mask(0.4), Pane::Blend(0.2)];
const THROUGH_PANES: [&str; 4] = ["rectangle", "constant", "directional", "facing"];
/// Surfaces that refract, but do not bend light, and the lights that shine through them.
const INTERFACES: [Pane; 2] = [Pane::Interface(1.0), Pane::Mask(0.2)];
const THROUGH_INTERFACES: [&str; 3] = ["rectangle", "constant", "facing"];

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
    let open = SPREAD.into_iter().chain(DELTA).filter(is_wanted).map(|light| (light, &[][..]));
    let through = THROUGH_PANES.into_iter().map(|light| (light, &PANES[..]));
    let refracted = THROUGH_INTERFACES.into_iter().map(|light| (light, &INTERFACES[..]));
    for (light, panes) in open.chain(through).chain(refracted) {
        let scene = covered(ours("lights/floor.xml", &[("light", light)]), panes);
        let share: f64 = panes.iter().map(|pane| pane.share(1.0)).product();
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
            let expected = share * floor_radiance(light);
            // The added error covers single precision and a camera that sees more than one point.
            let z = (mean - expected) / error.hypot(1.0e-5 * expected);
            let case = format!(
                "floor, {light}, {} panes, {}, seed {SEED}: {mean:.6} +- {error:.6}, not {expected:.6}",
                panes.len(),
                row.name
            );
            evidence.test(case, two_sided(z), || Record::Pictures(vec![picture.image()]));
        }
    }
}
