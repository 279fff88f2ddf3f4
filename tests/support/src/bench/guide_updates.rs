//! Renderers with short steps, to time the kernels that end a step. They use the Cornell box of relief, with 16 cells
//! along each axis, of which only those that contain surfaces count.

use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use glam::UVec3;
use lodestar::encode::bvh::Bvh;
use lodestar::encode::cells::Cells;
use lodestar::gpu::Context;
use lodestar::renderer::Renderer;
use lodestar::scene::Scene;
use lodestar::settings::{Sampler, Settings};

use crate::bench::relief::tessellated;
use crate::bench::{context, settings};

const TRIANGLES: usize = 10_000;
const SIZE: [u32; 2] = [64, 64];
const GRID: u32 = 16;
/// Weight of parent cells, where parents are measured.
const FALLBACK: f32 = 4.0;
/// Number of steps that fill the guide before anything is measured.
const FIRST_STEPS: u32 = 4;

/// Data that the renderers share. They have a context of their own, because its record of timings never ends.
pub struct Ground {
    context: Arc<Context>,
    scene: Scene,
    bvh: Bvh,
}

/// Renderer whose steps are timed kernel by kernel.
pub struct Stepper {
    pub title: &'static str,
    pub sampler: Sampler,
    /// Kernels of this renderer that are of interest.
    pub kernels: &'static [&'static str],
    ground: Rc<Ground>,
    renderer: Renderer,
}

impl Ground {
    pub fn new() -> Rc<Self> {
        let scene = tessellated(TRIANGLES);
        let ground = Self { context: context(), bvh: Bvh::of_scene(&scene), scene };
        ground.context.record_timings();
        Rc::new(ground)
    }

    pub fn cells(&self) -> Cells {
        Cells::new(&self.bvh, &[], UVec3::splat(GRID))
    }

    /// Renderer that has not taken a step yet.
    pub fn renderer(&self, sampler: Sampler, fallback: f32) -> Renderer {
        let learner = sampler.default_learner();
        let settings =
            Settings { learner, grid: Some(GRID), fallback: Some(fallback), ..settings(&self.scene, SIZE, sampler) };
        let renderer = Renderer::new(&self.context, &self.scene, &self.bvh, &settings).expect("a renderer");
        self.context.take_timings();
        renderer
    }

    /// Seconds of a kernel since the last call; NaN if the device does not time it.
    pub fn seconds_of(&self, kernel: &str) -> f64 {
        let timings = self.context.take_timings();
        let dispatches = timings.iter().flat_map(|submission| &submission.dispatches);
        let own = dispatches.filter(|dispatch| dispatch.kernel == kernel);
        let seconds = own.map(|dispatch| dispatch.span.map(|(from, to)| to.saturating_sub(from).as_secs_f64()));
        seconds.sum::<Option<f64>>().unwrap_or(f64::NAN)
    }
}

/// Renderers for all kernels that run once per step, or once per level of parent cells.
pub fn steppers(ground: &Rc<Ground>) -> Vec<Stepper> {
    let stepper = |title, sampler, fallback, kernels| {
        let mut renderer = ground.renderer(sampler, fallback);
        for _ in 0..FIRST_STEPS {
            renderer.step(1, &|| false).expect("a step");
        }
        Stepper { title, sampler, kernels, ground: Rc::clone(ground), renderer }
    };
    vec![
        stepper("product", Sampler::Product, 0.0, &["update_radiance", "update_normalization"]),
        stepper("rejection-mix", Sampler::RejectionMix, 0.0, &["update_normalization"]),
        stepper("product with parents", Sampler::Product, FALLBACK, &["pool_radiance", "blend_radiance"]),
    ]
}

impl Stepper {
    /// Takes steps for at least the given seconds. Returns the seconds of a kernel per step.
    pub fn seconds_per_step(&mut self, kernel: &str, at_least: f64) -> f64 {
        self.ground.context.take_timings();
        let (begin, mut steps) = (Instant::now(), 0);
        while steps == 0 || begin.elapsed().as_secs_f64() < at_least {
            self.renderer.step(1, &|| false).expect("a step");
            steps += 1;
        }
        self.ground.seconds_of(kernel) / f64::from(steps)
    }

    /// Number of entries of the normalization grid that are filled again in every step.
    pub fn marked_entries(&self) -> u64 {
        let state = self.renderer.state().expect("the state");
        let marks = state.parts.iter().find(|part| part.name == "marked normalizers").expect("marks");
        marks.bytes.iter().map(|byte| u64::from(byte.count_ones())).sum()
    }
}
