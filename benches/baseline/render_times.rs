//! Time of whole renders with equal numbers of samples and with emitter sampling, in seconds. The time runs from the
//! first step to the picture on the host. Loading, hierarchy, kernels and uploads are not included, neither here nor
//! for Mitsuba's `path`.

use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use lodestar::gpu::Context;
use lodestar::renderer::Renderer;
use lodestar::settings::{Sampler, Settings};
use serde_json::json;
use support::bench::settings;
use support::bench::subjects::Subject;

use crate::quantity::{Place, Quantity, Unit};

const SPP: u32 = 8;
/// Approximate number of pixels. The picture has the aspect ratio of the scene's film.
const PIXELS: f64 = 240.0 * 240.0;
const SAMPLERS: [(&str, Sampler); 3] =
    [("bsdf", Sampler::Bsdf), ("rejection-mix", Sampler::RejectionMix), ("product", Sampler::Product)];

pub fn quantities(context: &Arc<Context>, subjects: &[Rc<Subject>]) -> Vec<Quantity> {
    let read = subjects.iter().filter(|subject| subject.file.is_some());
    let pairs = read.flat_map(|subject| SAMPLERS.iter().map(move |sampler| (subject, sampler)));
    pairs.map(|(subject, &(name, sampler))| quantity(context, subject, name, sampler)).collect()
}

/// Size of the picture in pixels, rounded to whole tiles.
fn size(subject: &Subject) -> [u32; 2] {
    let aspect = f64::from(subject.scene.film.width) / f64::from(subject.scene.film.height);
    let tiles = |pixels: f64| ((pixels / 8.0).round() as u32).max(1) * 8;
    [tiles((PIXELS * aspect).sqrt()), tiles((PIXELS / aspect).sqrt())]
}

fn quantity(context: &Arc<Context>, subject: &Rc<Subject>, name: &str, sampler: Sampler) -> Quantity {
    let [width, height] = size(subject);
    let settings = Settings { nee: true, ..settings(&subject.scene, [width, height], sampler) };
    let (context, own) = (Arc::clone(context), Rc::clone(subject));
    let run = move || {
        let mut renderer = Renderer::new(&context, &own.scene, &own.bvh, &settings).expect("a renderer");
        let begin = Instant::now();
        while renderer.samples_done() < SPP {
            let done = renderer.samples_done();
            renderer.step(settings.samples_of_step(done).min(SPP - done), &|| false).expect("a step");
        }
        renderer.picture().expect("the picture");
        begin.elapsed().as_secs_f64()
    };
    Quantity {
        name: format!("render: {name}, {}", subject.name),
        unit: Unit::Seconds,
        place: Place::Device,
        run: Box::new(run),
        request: subject.file.as_ref().map(|file| json!(["render", file, width, height, SPP])),
    }
}
