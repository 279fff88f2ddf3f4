//! Methods that render one scene for the same time, by turns, so that a slow minute of the machine hits them all.

use std::sync::Arc;

use glam::Vec3;

use super::methods::Method;
use super::record::{Memory, StepRecord};
use crate::encode::bvh::Bvh;
use crate::film::Picture;
use crate::gpu::Context;
use crate::image::{Image, metrics};
use crate::renderer::{Counts, Renderer};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::{Error, Result};

/// Turns of every method; at least a step each.
const TURNS: f64 = 20.0;
/// Longest turn, in seconds.
const LONGEST_TURN: f64 = 2.0;

/// What all methods share.
pub struct Stage<'a> {
    /// The device.
    pub context: &'a Arc<Context>,
    /// The scene.
    pub scene: &'a Scene,
    /// Its hierarchy.
    pub bvh: &'a Bvh,
    /// What pictures are measured against, of their size.
    pub reference: &'a Image,
    /// Seconds of rendering for each method.
    pub budget: f64,
    /// Whether the user wants an end.
    pub stop: &'a dyn Fn() -> bool,
    /// Told of every second that a method has rendered, with the method's name.
    pub advanced: &'a dyn Fn(&str, f64),
}

/// A method under way, and in the end its result.
pub struct Entrant {
    /// The method.
    pub method: Method,
    /// Its settings.
    pub settings: Settings,
    /// Samples per pixel so far.
    pub spp: u32,
    /// Seconds so far.
    pub seconds: f64,
    /// What was counted so far.
    pub counts: Counts,
    /// The steps so far.
    pub steps: Vec<StepRecord>,
    renderer: Renderer,
}

impl Stage<'_> {
    /// Renders with each of these methods for the whole budget. Returns fewer where there is no memory for all at once: the
    /// first ones. `None` where the user has stopped it.
    ///
    /// # Errors
    /// Where not even one method fits the device, or it is lost.
    pub fn run(&self, methods: &[(Method, Settings)]) -> Result<Option<Vec<Entrant>>> {
        let mut entrants = self.enter(methods)?;
        let turn = (self.budget / TURNS).min(LONGEST_TURN);
        while entrants.iter().any(|entrant| !entrant.is_done(self.budget)) {
            for entrant in entrants.iter_mut().filter(|entrant| !entrant.is_done(self.budget)) {
                let begin = entrant.seconds;
                while entrant.seconds < begin + turn && !entrant.is_done(self.budget) {
                    if !entrant.step(self)? {
                        return Ok(None);
                    }
                }
            }
        }
        Ok(Some(entrants))
    }

    fn enter(&self, methods: &[(Method, Settings)]) -> Result<Vec<Entrant>> {
        let mut entrants: Vec<Entrant> = Vec::new();
        for (method, settings) in methods {
            match Entrant::new(self, *method, settings.clone()) {
                Ok(entrant) => entrants.push(entrant),
                Err(error) if entrants.is_empty() || !is_lack_of_memory(&error) => return Err(error),
                // What did not fit comes next.
                Err(_) => break,
            }
        }
        Ok(entrants)
    }
}

/// The arithmetic before a render refuses by a setting's error; the device by its own.
fn is_lack_of_memory(error: &Error) -> bool {
    matches!(error, Error::OutOfDeviceMemory { .. } | Error::Settings(_))
}

impl Entrant {
    fn new(stage: &Stage, method: Method, settings: Settings) -> Result<Self> {
        let renderer = Renderer::new(stage.context, stage.scene, stage.bvh, &settings)?;
        Ok(Self { method, settings, spp: 0, seconds: 0.0, counts: Counts::default(), steps: Vec::new(), renderer })
    }

    /// Whether the budget is used up to within half a step.
    fn is_done(&self, budget: f64) -> bool {
        let last = self.seconds - self.steps.len().checked_sub(2).map_or(0.0, |at| self.steps[at].seconds);
        self.seconds > 0.0 && self.seconds + 0.5 * last >= budget
    }

    /// A step; false where it was stopped.
    fn step(&mut self, stage: &Stage) -> Result<bool> {
        let report = self.renderer.step(self.settings.samples_of_step(self.spp), stage.stop)?;
        if !report.complete {
            return Ok(false);
        }
        self.seconds += report.seconds;
        self.spp = self.renderer.samples_done();
        self.counts.add(&report.counts);
        let mut step = StepRecord::new(&report, self.spp, self.seconds);
        if (self.steps.len() + 1).is_power_of_two() {
            step.mae = Some(metrics::compare(&self.renderer.picture()?.image(), stage.reference)?.mae_ldr);
        }
        self.steps.push(step);
        (stage.advanced)(&self.method.name(), report.seconds);
        Ok(true)
    }

    /// The picture so far.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn picture(&self) -> Result<Picture> {
        self.renderer.picture()
    }

    /// What it has learned at a point.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn radiance_at(&self, position: Vec3) -> Result<Vec<f32>> {
        self.renderer.radiance_at(position)
    }

    /// What it takes of the device's memory besides film and scene.
    pub fn memory(&self) -> Memory {
        Memory { guide_bytes: self.renderer.guide_bytes(), path_bytes: self.settings.path_bytes() }
    }
}
