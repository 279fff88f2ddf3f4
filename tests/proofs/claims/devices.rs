//! Claim: two devices that share a film leave the picture and the guide of one device, to the bit. So the sums of learning targets
//! reach both devices whole, and once.

use lodestar::renderer::{RenderState, Renderer};
use lodestar::settings::Settings;
use support::scenes::ours;

use crate::evidence::Evidence;
use crate::renders::{Studio, steps};
use crate::rows::Scope;
use crate::subject::Subject;

/// Samples per pixel: three steps, so that the guide of the second step decides what the third one learns.
const SPP: u32 = 24;

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let scene = ours("cornell-box/scene.xml", &[]);
    let sized = Settings { width: 40, height: 28, seed: 11, ..Settings::for_scene(&scene) };
    for row in scope.rendered() {
        let mut settings = sized.clone();
        (row.set)(&mut settings);
        let studios = [Studio::new(), Studio::new()];
        let one = left(&mut studios[0].renderer(subject, &scene, settings.clone()), &settings);
        let [mut first, second] = studios.each_ref().map(|studio| studio.renderer(subject, &scene, settings.clone()));
        first.share_with_sums(vec![second], subject.add_sums).expect("renderers without samples");
        let two = left(&mut first, &settings);
        evidence.hold(format!("picture, {}", row.name), two.0 == one.0, || "two devices differ from one".into());
        for (theirs, ours) in two.1.parts.iter().zip(&one.1.parts) {
            let case = format!("{}, {}", ours.name, row.name);
            evidence.hold(case, theirs == ours, || "two devices differ from one".into());
        }
    }
}

/// Bits of the picture, and the state.
fn left(renderer: &mut Renderer, settings: &Settings) -> (Vec<u32>, RenderState) {
    steps(renderer, settings.spp_per_step, SPP);
    let bits = renderer.picture().expect("a picture").radiance.iter().flatten().map(|value| value.to_bits()).collect();
    (bits, renderer.state().expect("a state"))
}
