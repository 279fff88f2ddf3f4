//! Contest: several methods render one scene for the same time. They take turns, so that a slow minute of the machine
//! affects all of them.

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

/// Number of turns of every method. A turn is at least one step.
const TURNS: f64 = 20.0;
/// Maximum length of a turn, in seconds.
const LONGEST_TURN: f64 = 2.0;

/// Data that all methods of a contest share.
pub struct Stage<'a> {
    /// Device.
    pub context: &'a Arc<Context>,
    /// Scene.
    pub scene: &'a Scene,
    /// Bounding volume hierarchy of the scene.
    pub bvh: &'a Bvh,
    /// Reference that pictures are compared with, of the same size.
    pub reference: &'a Image,
    /// Rendering time of each method, in seconds.
    pub budget: f64,
    /// Whether the user has asked to stop.
    pub stop: &'a dyn Fn() -> bool,
    /// Called with a method's name and the seconds that it has just rendered.
    pub advanced: &'a dyn Fn(&str, f64),
}

/// Method that takes part in a contest, with its results so far.
pub struct Entrant {
    /// Method.
    pub method: Method,
    /// Settings of the method.
    pub settings: Settings,
    /// Samples per pixel so far.
    pub spp: u32,
    /// Rendering time so far, in seconds.
    pub seconds: f64,
    /// Statistics so far.
    pub counts: Counts,
    /// Steps so far.
    pub steps: Vec<StepRecord>,
    renderer: Renderer,
}

impl Stage<'_> {
    /// Renders with each of these methods for the whole time. If the device's memory does not suffice for all, only the
    /// first ones render and are returned. Returns `None` if the user has stopped the run.
    ///
    /// # Errors
    /// Fails if not even one method fits into the device's memory, or if the device is lost.
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
                // Methods that did not fit take part in the next contest.
                Err(_) => break,
            }
        }
        Ok(entrants)
    }
}

/// Whether an error means that memory is lacking. A render that is refused beforehand fails with a settings error, the
/// device with its own error.
fn is_lack_of_memory(error: &Error) -> bool {
    matches!(error, Error::OutOfDeviceMemory { .. } | Error::Settings(_))
}

impl Entrant {
    fn new(stage: &Stage, method: Method, settings: Settings) -> Result<Self> {
        let renderer = Renderer::new(stage.context, stage.scene, stage.bvh, &settings)?;
        Ok(Self { method, settings, spp: 0, seconds: 0.0, counts: Counts::default(), steps: Vec::new(), renderer })
    }

    /// Whether the rendering time is used up to within half a step.
    fn is_done(&self, budget: f64) -> bool {
        let last = self.seconds - self.steps.len().checked_sub(2).map_or(0.0, |at| self.steps[at].seconds);
        self.seconds > 0.0 && self.seconds + 0.5 * last >= budget
    }

    /// Renders one step. Returns false if the user has stopped it.
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

    /// Picture so far.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn picture(&self) -> Result<Picture> {
        self.renderer.picture()
    }

    /// Radiance that the guide has learned at a point.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn radiance_at(&self, position: Vec3) -> Result<Vec<f32>> {
        self.renderer.radiance_at(position)
    }

    /// Device memory of the method, without film and scene.
    pub fn memory(&self) -> Memory {
        Memory { guide_bytes: self.renderer.guide_bytes(), path_bytes: self.settings.path_bytes() }
    }
}
