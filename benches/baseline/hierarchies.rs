//! Time to load a scene and to build its hierarchy, in seconds, for scenes that are large enough to measure.

use std::rc::Rc;
use std::time::Instant;

use lodestar::encode::bvh::Bvh;
use lodestar::scene::{self, LoadOptions};
use serde_json::json;
use support::bench::subjects::Subject;

use crate::quantity::{Place, Quantity, Unit};

/// Minimum number of primitives. Smaller scenes load too fast to be measured.
const LEAST_PRIMITIVES: usize = 10_000;

pub fn quantities(subjects: &[Rc<Subject>]) -> Vec<Quantity> {
    let large: Vec<_> = subjects.iter().filter(|subject| subject.scene.primitives.len() >= LEAST_PRIMITIVES).collect();
    let loads = large.iter().filter_map(|subject| load(subject));
    loads.chain(large.iter().map(|subject| build(subject))).collect()
}

/// Time to load a scene and to build its hierarchy. Mitsuba's loading builds a hierarchy, too.
fn load(subject: &Subject) -> Option<Quantity> {
    let file = subject.file.clone()?;
    let request = Some(json!(["load", file]));
    let run = move || {
        let begin = Instant::now();
        let scene = scene::load(&file, &LoadOptions::default()).expect("the scene loads");
        let bvh = Bvh::build(&scene.primitives);
        let seconds = begin.elapsed().as_secs_f64();
        drop((scene, bvh));
        seconds
    };
    Some(quantity(format!("load and BVH: {}", subject.name), Box::new(run), request))
}

fn build(subject: &Rc<Subject>) -> Quantity {
    let subject = Rc::clone(subject);
    let name = format!("BVH: {}", subject.name);
    let run = move || {
        let begin = Instant::now();
        let bvh = Bvh::build(&subject.scene.primitives);
        let seconds = begin.elapsed().as_secs_f64();
        drop(bvh);
        seconds
    };
    quantity(name, Box::new(run), None)
}

fn quantity(name: String, run: Box<dyn FnMut() -> f64>, request: Option<serde_json::Value>) -> Quantity {
    Quantity { name, unit: Unit::Seconds, place: Place::Host, run, request }
}
