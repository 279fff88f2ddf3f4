//! Device that renders whole pictures. The long tier uses the validation layer in all tests, the quick tier in some.

use std::sync::Arc;

use lodestar::encode::bvh::Bvh;
use lodestar::film::Picture;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::renderer::{Counts, Renderer};
use lodestar::scene::Scene;
use lodestar::settings::{Settings, Traversal};
use support::{mutated, tier};

/// Context whose validation messages fail the test when it is dropped.
pub struct Device {
    context: Arc<Context>,
    mutation: Option<&'static str>,
    /// Whether the device's ray queries trace the rays of all renders.
    by_queries: bool,
}

impl Device {
    /// Device under the validation layer in the long tier.
    pub fn new() -> Self {
        Self::open(tier::is_full())
    }

    /// Device under the validation layer.
    pub fn validated() -> Self {
        Self::open(true)
    }

    fn open(validate: bool) -> Self {
        let context = Context::new(&ContextOptions { device: None, validate }).expect("a Vulkan device");
        Self { context, mutation: None, by_queries: false }
    }

    /// The device by each traversal that it has: in compute, and by ray queries.
    pub fn of_each_traversal() -> Vec<Self> {
        let device = Self::new();
        let has_queries = device.has_ray_queries("ray queries");
        let by_queries = Self { context: device.context.clone(), mutation: None, by_queries: true };
        if has_queries { vec![device, by_queries] } else { vec![device] }
    }

    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// Word for the traversal, for messages.
    pub fn traversal(&self) -> &'static str {
        if self.by_queries { "by ray queries" } else { "in compute" }
    }

    /// Whether the device has ray queries. Prints a line if not, because the test is then skipped.
    pub fn has_ray_queries(&self, name: &str) -> bool {
        let device = self.context.device();
        if !device.limits.has_ray_queries {
            println!("{name}: skipped, for {} has no ray queries", device.name);
        }
        device.limits.has_ray_queries
    }

    /// Device whose kernels have a mutation of `tests/tampered`.
    pub fn mutated(&self, mutation: &'static str) -> Self {
        Self { context: self.context.clone(), mutation: Some(mutation), by_queries: self.by_queries }
    }

    /// Name of the kernels' mutation.
    pub fn mutation(&self) -> &'static str {
        self.mutation.unwrap_or("no fault")
    }

    pub fn renderer(&self, scene: &Scene, settings: &Settings) -> Renderer {
        let traversal = if self.by_queries { Traversal::Query } else { settings.traversal };
        let settings = Settings { traversal, ..settings.clone() };
        mutated::renderer(&self.context, scene, &Bvh::of_scene(scene), &settings, self.mutation)
    }

    /// Error of a render that is refused.
    pub fn refusal(&self, scene: &Scene, settings: &Settings) -> String {
        let refused = Renderer::new(&self.context, scene, &Bvh::of_scene(scene), settings);
        refused.map(drop).expect_err("a refusal").to_string()
    }

    pub fn render(&self, scene: &Scene, settings: &Settings, spp: u32) -> Picture {
        let mut renderer = self.renderer(scene, settings);
        steps(&mut renderer, settings, spp);
        renderer.picture().expect("a picture")
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let messages = self.context.validation_messages();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "{messages:#?}");
        }
    }
}

/// Takes `spp` samples per pixel in steps of the settings. Returns the counts of every step.
pub fn steps(renderer: &mut Renderer, settings: &Settings, spp: u32) -> Vec<Counts> {
    let mut counts = Vec::new();
    while renderer.samples_done() < spp {
        let samples = settings.spp_per_step.min(spp - renderer.samples_done());
        let report = renderer.step(samples, &|| false).expect("a step");
        assert!(report.complete);
        assert_eq!((report.counts.nonfinite, report.counts.overruns), (0, 0));
        counts.push(report.counts);
    }
    counts
}
