//! Rays per second of the traversal alone (`glsl/test/traverse.comp`), and of Mitsuba on the same rays.

use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use lodestar::generated::kernels::test;
use serde_json::json;
use support::bench::rates::{mean_seconds, seconds_of};
use support::bench::rays::{Batch, KINDS, Tracer, make, picture};
use support::bench::subjects::Subject;
use support::device::Device;

use crate::quantity::{Place, Quantity, Unit};

/// Minimum time for which each measurement is repeated, in seconds.
const SECONDS: f64 = 0.15;

pub fn quantities(device: &Arc<Device>, subjects: &[Rc<Subject>], folder: &Path) -> Vec<Quantity> {
    let fitting = subjects.iter().filter(|subject| Tracer::fits(device, &subject.bvh));
    fitting.flat_map(|subject| of_scene(device, subject, folder)).collect()
}

fn of_scene(device: &Arc<Device>, subject: &Subject, folder: &Path) -> Vec<Quantity> {
    let tracer = Rc::new(Tracer::new(device, &subject.bvh, &test::TRAVERSE));
    let kinds = make(device, &subject.scene, &subject.bvh, picture(device)).into_iter().zip(KINDS);
    let quantity = |(rays, (kind, any_hit)): (Vec<_>, (&str, bool))| {
        let file = folder.join(format!("{}-{kind}.bin", subject.name));
        std::fs::write(&file, bytemuck::cast_slice(&rays)).expect("rays are written");
        let unit = Unit::MillionsPerSecond(rays.len() as f64 / 1.0e6, "rays");
        let (tracer, batch) = (Rc::clone(&tracer), Batch::new(device, rays));
        Quantity {
            name: format!("rays: {kind}, {}", subject.name),
            unit,
            place: Place::Device,
            run: Box::new(move || mean_seconds(SECONDS, || seconds_of(tracer.trace(&batch)))),
            request: subject.file.as_ref().map(|scene| json!(["rays", scene, file, any_hit])),
        }
    };
    kinds.filter(|(rays, _)| !rays.is_empty()).map(quantity).collect()
}
