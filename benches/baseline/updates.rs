//! Time of the kernels that end a step, in milliseconds by the device's clock
//! (`tests/support/src/bench/guide_updates.rs`).

use std::cell::RefCell;
use std::rc::Rc;

use lodestar::settings::Sampler;
use support::bench::guide_updates::{Ground, Stepper, steppers};

use crate::quantity::{Place, Quantity, Unit};

/// Minimum time for which each measurement is repeated, in seconds.
const SECONDS: f64 = 0.15;
/// Number of samples per pixel after which the quadtrees have been refined three times.
const QUADTREE_SAMPLES: u32 = 7;

pub fn quantities() -> Vec<Quantity> {
    let ground = Ground::new();
    let steppers = steppers(&ground).into_iter().map(|stepper| Rc::new(RefCell::new(stepper)));
    let mut quantities: Vec<_> = steppers.flat_map(|stepper| of_steps(&stepper)).collect();
    quantities.push(of_quadtrees(ground));
    quantities
}

fn quantity(name: String, run: Box<dyn FnMut() -> f64>) -> Quantity {
    Quantity { name, unit: Unit::Milliseconds, place: Place::Device, run, request: None }
}

fn of_steps(stepper: &Rc<RefCell<Stepper>>) -> Vec<Quantity> {
    let title = stepper.borrow().title;
    let of_kernel = |&kernel: &&'static str| {
        let stepper = Rc::clone(stepper);
        let run = move || stepper.borrow_mut().seconds_per_step(kernel, SECONDS);
        quantity(format!("update: {kernel}, {title}"), Box::new(run))
    };
    let kernels = stepper.borrow().kernels;
    kernels.iter().map(of_kernel).collect()
}

/// Time of all refinements of quadtrees in a render of few samples.
fn of_quadtrees(ground: Rc<Ground>) -> Quantity {
    let run = move || {
        let mut renderer = ground.renderer(Sampler::Quadtree, 0.0);
        renderer.step(QUADTREE_SAMPLES, &|| false).expect("a step");
        ground.seconds_of("refine_quadtrees")
    };
    quantity("update: refine_quadtrees, three times".into(), Box::new(run))
}
