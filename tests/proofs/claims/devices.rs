//! Claim: two devices that share a film leave the picture and the guide of one device, to the bit. So the sums of learning targets
//! reach both devices whole, and once.

use lodestar::fleet::Fleet;
use lodestar::renderer::RenderState;
use lodestar::settings::Settings;
use support::scenes::ours;

use crate::evidence::Evidence;
use crate::renders::Studio;
use crate::rows::Scope;
use crate::subject::Subject;

/// Samples per pixel: three steps, so that the guide of the second step decides what the third one learns.
const SPP: u32 = 24;

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let scene = ours("cornell-box/scene.xml", &[]);
    let sized = Settings { width: 40, height: 28, seed: 11, ..Settings::for_scene(&scene) };
    for row in scope.rendered() {
        let mut settings = sized.clone();
        row.set(&mut settings);
        let studios = [Studio::new(), Studio::new()];
        let one = left(studios[0].renderer(subject, &scene, settings.clone()).into(), &settings);
        let [first, second] = studios.each_ref().map(|studio| studio.renderer(subject, &scene, settings.clone()));
        let fleet = Fleet::with_sums(first, vec![second], subject.add_sums).expect("renderers without samples");
        let two = left(fleet, &settings);
        evidence.hold(format!("picture, {}", row.name), two.0 == one.0, || "two devices differ from one".into());
        for (theirs, ours) in two.1.parts.iter().zip(&one.1.parts) {
            let case = format!("{}, {}", ours.name, row.name);
            evidence.hold(case, theirs == ours, || "two devices differ from one".into());
        }
    }
}

/// Bits of the picture, and the state.
fn left(mut fleet: Fleet, settings: &Settings) -> (Vec<u32>, RenderState) {
    for _ in 0..SPP / settings.spp_per_step {
        fleet.step(settings.spp_per_step, &|| false).expect("a step");
    }
    let bits = fleet.picture().expect("a picture").radiance.iter().flatten().map(|value| value.to_bits()).collect();
    (bits, fleet.state().expect("a state"))
}
