//! Renders with the kernels and settings of a subject.

use std::sync::Arc;

use lodestar::encode::bvh::Bvh;
use lodestar::film::Picture;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::renderer::{Counts, Renderer};
use lodestar::scene::Scene;
use lodestar::settings::Settings;
use support::{mutated, tier};

use crate::subject::Subject;

/// A device, under the validation layer in the long tier.
pub struct Studio {
    context: Arc<Context>,
}

impl Studio {
    pub fn new() -> Self {
        let options = ContextOptions { device: None, validate: tier::is_full() };
        Self { context: Context::new(&options).expect("a Vulkan device") }
    }

    pub fn renderer(&self, subject: &Subject, scene: &Scene, settings: Settings) -> Renderer {
        let (bvh, settings) = (Bvh::of_scene(scene), subject.settings(settings));
        mutated::renderer(&self.context, scene, &bvh, &settings, subject.mutation)
    }

    /// Picture of `spp` samples per pixel, and the counts of the render. Steps have eight samples unless the subject
    /// changes that.
    pub fn render(&self, subject: &Subject, scene: &Scene, settings: Settings, spp: u32) -> (Picture, Counts) {
        let per_step = subject.settings(settings.clone()).spp_per_step;
        let mut renderer = self.renderer(subject, scene, settings);
        let counts = steps(&mut renderer, per_step, spp);
        (renderer.picture().expect("a picture"), counts)
    }
}

/// Takes `spp` more samples per pixel.
pub fn steps(renderer: &mut Renderer, per_step: u32, spp: u32) -> Counts {
    let mut counts = Counts::default();
    let mut left = spp;
    while left > 0 {
        let report = renderer.step(per_step.min(left), &|| false).expect("a step");
        counts.add(&report.counts);
        left -= report.samples;
    }
    counts
}

impl Drop for Studio {
    fn drop(&mut self) {
        let messages = self.context.validation_messages();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "{messages:#?}");
        }
    }
}
