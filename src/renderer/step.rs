//! One step of a render: the paper's online pipeline.

use std::time::{Duration, Instant};

use super::Renderer;
use crate::film::noise::LEAST_SAMPLES;
use crate::generated::layout::{DispatchWeights, TracePush};
use crate::renderer::film_store::FilmStore;
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::learn::Learning;
use crate::renderer::phases::{Batch, Phase, phases, sample_index};
use crate::renderer::statistics::{Counts, StepReport};
use crate::renderer::trace::slices::Slice;
use crate::renderer::trace::tracer::Tracer;
use crate::{Error, Result};

/// A step that has begun.
pub(crate) struct Begun {
    samples: u32,
    pixels: u64,
    at: Instant,
}

impl Renderer {
    /// Takes `samples` more samples per pixel, then learns from them. The guide that a step follows was learned in the steps
    /// before it, so the first step samples BSDFs only.
    ///
    /// `stop` is asked between dispatches. Where it answers true, the step ends early and [`StepReport::complete`] is false.
    ///
    /// # Errors
    /// Where the device is lost, or a loop of a kernel was cut short and the picture would be wrong. Also after a step that
    /// was stopped: some pixels then lack its samples, so that none can follow.
    pub fn step(&mut self, samples: u32, stop: &dyn Fn() -> bool) -> Result<StepReport> {
        let step = self.begin_step(samples)?;
        let mut counts = Counts::default();
        let complete = self.run_phases(samples, &mut counts, stop).map_err(|error| self.explain(error))?;
        Ok(self.end_step(&step, complete, counts))
    }

    /// Runs the phases of a step. Returns whether `stop` let all of them run.
    fn run_phases(&mut self, samples: u32, counts: &mut Counts, stop: &dyn Fn() -> bool) -> Result<bool> {
        for phase in phases(&self.settings, self.samples_done, samples) {
            match phase {
                Phase::Trace(batch) => {
                    if !self.trace(batch, counts, stop)? {
                        return Ok(false);
                    }
                    self.samples_done = batch.end();
                }
                Phase::Learn => self.learn()?,
                Phase::Settle => self.settle()?,
            }
        }
        Ok(true)
    }

    /// Adds a batch of samples to every pixel of this device's share of the film. Returns whether `stop` let all of them run.
    pub(crate) fn trace(&self, batch: Batch, counts: &mut Counts, stop: &dyn Fn() -> bool) -> Result<bool> {
        for page in self.sets.frame.pages() {
            let mut next = 0;
            while let Some(slice) = self.slicer.slice(page, next) {
                if stop() {
                    return Ok(false);
                }
                let (elapsed, slice_counts) = self.trace_slice(page, slice, batch)?;
                self.slicer.measured(slice, elapsed);
                counts.add(&slice_counts);
                next = slice.end();
            }
        }
        Ok(true)
    }

    /// Learns from the sums of the batches so far: the radiance grid moves towards the targets (Eq. 7), then the marked normalizers
    /// are computed anew. Quadtrees are refined.
    pub(crate) fn learn(&self) -> Result<()> {
        match &self.learning {
            Learning::Nothing => Ok(()),
            Learning::Grids(updates) => updates.run(&self.context, &self.slicer, &self.sets, &self.cells, true),
            Learning::Quadtrees(refinement) => {
                refinement.end_batch(&self.context, &self.sets, &self.settings, self.samples_done)
            }
        }
    }

    /// Computes the tables that samplers read from what a guide of the grids has learned.
    pub(super) fn tabulate(&self) -> Result<()> {
        match &self.learning {
            Learning::Grids(updates) => updates.run(&self.context, &self.slicer, &self.sets, &self.cells, false),
            Learning::Nothing | Learning::Quadtrees(_) => Ok(()),
        }
    }

    /// Ends a step for the film: a part of a picture keeps sums of its steps, and noise may end tiles.
    pub(crate) fn settle(&mut self) -> Result<()> {
        match &mut self.film_store {
            FilmStore::Plain => Ok(()),
            FilmStore::Part(sums) => sums.add_step(&self.context, &self.sets.frame),
            FilmStore::Adaptive(_) => self.choose_tiles(),
        }
    }

    /// Chooses the tiles that go on, where noise ends them. The first samples do not tell how noisy a tile is.
    pub(super) fn choose_tiles(&mut self) -> Result<()> {
        match &mut self.film_store {
            FilmStore::Plain | FilmStore::Part(_) => Ok(()),
            FilmStore::Adaptive(adaptive) if self.samples_done < LEAST_SAMPLES => {
                adaptive.restart(self.sets.frame.pages())
            }
            FilmStore::Adaptive(adaptive) => adaptive.judge(&self.context, &self.slicer, &self.sets),
        }
    }

    /// Refuses to go on after a step that was stopped.
    pub(crate) fn check_goes_on(&self) -> Result<()> {
        match self.stopped {
            true => Err(Error::Render("a render cannot go on after a step that was stopped".into())),
            false => Ok(()),
        }
    }

    /// Begins a step. It is over only with [`Renderer::end_step`]: an error on the way leaves the renderer stopped.
    pub(crate) fn begin_step(&mut self, samples: u32) -> Result<Begun> {
        self.check_goes_on()?;
        let step = Begun { samples, pixels: self.sampled_pixels(), at: Instant::now() };
        self.at_step_end &= samples == self.samples_of_next_step();
        self.stopped = true;
        Ok(step)
    }

    /// Ends a step. One that is not complete leaves the renderer stopped.
    pub(crate) fn end_step(&mut self, step: &Begun, complete: bool, counts: Counts) -> StepReport {
        self.stopped = !complete;
        let Begun { samples, pixels, at } = *step;
        StepReport { samples, pixels, complete, seconds: at.elapsed().as_secs_f64(), counts }
    }

    /// Adds to an error that memory has run out what the render's memory went to.
    pub(crate) fn explain(&self, error: Error) -> Error {
        self.needs.explain(error)
    }

    /// Traces the samples of a slice. Returns how long that took.
    fn trace_slice(&self, page: &FilmPage, slice: Slice, batch: Batch) -> Result<(Duration, Counts)> {
        let push = TracePush {
            first_workgroup: slice.first,
            workgroup_count: slice.count,
            workgroup_stride: slice.stride,
            page_first_pixel: page.first_pixel(),
            weights: self.weights_after(batch.first),
            first_sample: sample_index(&self.settings, batch.first),
            sample_count: batch.samples,
            first_of_sets: batch.first_of_sets,
            tiles: page.tile_places(),
        };
        let (elapsed, counts) = self.tracer.trace(&self.context, &self.sets, page, push)?;
        match counts.overruns {
            0 => Ok((elapsed, counts)),
            _ => Err(self.overrun_error()),
        }
    }

    /// Weights of the next samples after so many others.
    fn weights_after(&self, samples: u32) -> DispatchWeights {
        let before = self.settings.weight_sums(samples);
        let lost = |effective: f64| (f64::from(samples) - effective) as f32;
        DispatchWeights {
            of_sample: self.settings.weight_of_sample(samples),
            lost_weight: lost(before.weight),
            lost_samples: lost(before.effective_samples()),
        }
    }

    /// Runs every kernel once. Tracing takes no sample, and updates of empty grids write the floor that later updates start
    /// from.
    pub(super) fn warm_up(&mut self) -> Result<()> {
        let page = self.sets.frame.first_page();
        if let Some(slice) = self.slicer.smallest_slice(page) {
            self.trace_slice(page, slice, Batch { first: 0, samples: 0, first_of_sets: 0 })?;
        }
        if let FilmStore::Adaptive(adaptive) = &mut self.film_store {
            // The empty film has no noise, so this ends all tiles. They begin again below.
            adaptive.judge(&self.context, &self.slicer, &self.sets)?;
        }
        self.choose_tiles()?;
        match &self.learning {
            Learning::Quadtrees(refinement) => refinement.refine(&self.context, &self.sets, &self.settings, 0),
            Learning::Nothing | Learning::Grids(_) => self.learn(),
        }
    }

    /// Error of a loop that the driver has cut. A wave's kernels have one edge of a path each, so their loops are short.
    fn overrun_error(&self) -> Error {
        let fewer = match self.settings.samples_per_dispatch {
            1 => String::new(),
            samples => format!("--samples-per-dispatch below {samples} or "),
        };
        let waves = match self.tracer {
            Tracer::Megakernel(_) if self.settings.check_wavefront().is_ok() => "--execution wavefront or ",
            _ => "",
        };
        Error::LoopCut(format!(
            "the driver of {} ended a loop of a kernel before its end, so pixels would come out dark: render again with \
             {fewer}{waves}a smaller --max-depth",
            self.context.device().name,
        ))
    }
}
