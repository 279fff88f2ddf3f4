//! One step of a render: the paper's online pipeline.

use std::time::{Duration, Instant};

use super::Renderer;
use crate::film::noise::LEAST_SAMPLES;
use crate::generated::layout::{DispatchWeights, TracePush};
use crate::renderer::film_store::FilmStore;
use crate::renderer::film_store::adaptive::Adaptive;
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::film_store::part_sums::clear_film;
use crate::renderer::learn::Learning;
use crate::renderer::learn::quadtrees::{ended_iteration, first_of_iteration};
use crate::renderer::ranks::command::{Command, lead};
use crate::renderer::statistics::{Counts, StepReport};
use crate::renderer::trace::slices::Slice;
use crate::{Error, Result};

impl Renderer {
    /// Takes `samples` more samples per pixel, then learns from them. The guide that a step follows was learned in the steps
    /// before it, so the first step samples BSDFs only.
    ///
    /// `stop` is asked between dispatches. Where it answers true, the step ends early and [`StepReport::complete`] is false.
    ///
    /// # Errors
    /// Where the device is lost, or a loop of a kernel was cut short and the picture would be wrong. Also after a step that
    /// was stopped: some pixels lack its samples, so that none can follow.
    pub fn step(&mut self, samples: u32, stop: &dyn Fn() -> bool) -> Result<StepReport> {
        if self.stopped {
            return Err(Error::Render("a render cannot go on after a step that was stopped".into()));
        }
        let team = self.team.clone();
        lead(team.as_deref(), || Command::Step { samples }, || self.take_step(samples, stop))
    }

    /// Does this rank's part of a step.
    pub(super) fn take_step(&mut self, samples: u32, stop: &dyn Fn() -> bool) -> Result<StepReport> {
        let begin = Instant::now();
        let mut counts = Counts::default();
        let pixels = self.sampled_pixels();
        self.at_step_end &= samples == self.samples_of_next_step();
        // An error on the way leaves the renderer stopped, too.
        self.stopped = true;
        let complete = self.run_step(samples, &mut counts, stop).map_err(|error| self.needs.explain(error))?;
        self.stopped = !complete;
        Ok(StepReport { samples, pixels, complete, seconds: begin.elapsed().as_secs_f64(), counts })
    }

    /// The three phases of a step. Returns whether `stop` let all of them run.
    fn run_step(&mut self, samples: u32, counts: &mut Counts, stop: &dyn Fn() -> bool) -> Result<bool> {
        // 1. Trace: paths add light to the film, and learning targets to the guide's sums.
        if !self.trace(samples, counts, stop)? {
            return Ok(false);
        }
        // 2. Learn: the radiance grid moves towards the targets (Eq. 7), then the marked normalizers are computed anew.
        if matches!(self.learning, Learning::Grids(_)) {
            self.add_up_sums()?;
            self.on_every_device(&Self::update_grids)?;
        }
        // 3. Settle the film: a part of a picture keeps sums of its steps, and noise may end tiles.
        if matches!(self.film_store, FilmStore::Part(_)) {
            self.gather_film()?;
            self.others.iter().try_for_each(|other| clear_film(&other.context, &other.sets.frame))?;
        }
        let leads = self.leads();
        match &mut self.film_store {
            FilmStore::Part(sums) if leads => sums.add_step(&self.context, &self.sets.frame)?,
            FilmStore::Part(_) => clear_film(&self.context, &self.sets.frame)?,
            FilmStore::Plain | FilmStore::Adaptive(_) => {}
        }
        self.choose_tiles()?;
        Ok(true)
    }

    /// Updates this device's grids from the sums of a step.
    fn update_grids(&self) -> Result<()> {
        match &self.learning {
            Learning::Grids(updates) => updates.run(&self.context, &self.slicer, &self.sets, &self.cells),
            Learning::Nothing | Learning::Quadtrees(_) => Ok(()),
        }
    }

    /// Refines this device's quadtrees where an iteration has ended.
    fn refine_quadtrees(&self) -> Result<()> {
        match &self.learning {
            Learning::Quadtrees(refinement) => {
                refinement.end_batch(&self.context, &self.sets, &self.settings, self.samples_done)
            }
            Learning::Nothing | Learning::Grids(_) => Ok(()),
        }
    }

    /// Adds `samples` samples to every pixel, in batches of one dispatch each for every slice of the film.
    fn trace(&mut self, samples: u32, counts: &mut Counts, stop: &dyn Fn() -> bool) -> Result<bool> {
        let first_of_step = self.sample_index(self.samples_done);
        let mut left = samples;
        while left > 0 {
            let batch = left.min(self.longest_batch());
            let first_of_sets = self.first_of_sets(first_of_step);
            if !self.trace_batch(batch, first_of_sets, counts, stop)? {
                return Ok(false);
            }
            self.samples_done += batch;
            left -= batch;
            // Quadtrees learn at the end of their own iterations, which grow faster than steps.
            if matches!(self.learning, Learning::Quadtrees(_)) && ended_iteration(self.samples_done).is_some() {
                self.add_up_sums()?;
                self.on_every_device(&Self::refine_quadtrees)?;
            }
        }
        Ok(true)
    }

    /// Adds `batch` samples to every pixel of this device's share of the film. Returns whether `stop` let all of them run.
    pub(super) fn trace_share(
        &self,
        batch: u32,
        first_of_sets: u32,
        counts: &mut Counts,
        stop: &dyn Fn() -> bool,
    ) -> Result<bool> {
        self.trace_clock.time(|| self.trace_pages(batch, first_of_sets, counts, stop))
    }

    fn trace_pages(
        &self,
        batch: u32,
        first_of_sets: u32,
        counts: &mut Counts,
        stop: &dyn Fn() -> bool,
    ) -> Result<bool> {
        for page in self.sets.frame.pages() {
            let mut next = 0;
            while let Some(slice) = self.slicer.slice(page, next) {
                if stop() {
                    return Ok(false);
                }
                let (elapsed, slice_counts) = self.trace_slice(page, slice, batch, first_of_sets)?;
                self.slicer.measured(slice, elapsed);
                counts.add(&slice_counts);
                next = slice.end();
            }
        }
        Ok(true)
    }

    /// Most samples per pixel of the next batch: the dispatch is bounded, all samples have the same weight, and a guide that is due
    /// to learn is not followed further.
    pub(super) fn longest_batch(&self) -> u32 {
        let of_same_weight = self.settings.samples_of_same_weight(self.samples_done);
        let until_learning = self.learning.samples_left(self.samples_done);
        self.settings.samples_per_dispatch.min(of_same_weight).min(until_learning)
    }

    /// Traces the samples of a slice. Returns how long that took.
    fn trace_slice(
        &self,
        page: &FilmPage,
        slice: Slice,
        sample_count: u32,
        first_of_sets: u32,
    ) -> Result<(Duration, Counts)> {
        let push = TracePush {
            first_workgroup: slice.first,
            workgroup_count: slice.count,
            workgroup_stride: slice.stride,
            page_first_pixel: page.first_pixel(),
            weights: self.weights_of_next_samples(),
            first_sample: self.sample_index(self.samples_done),
            sample_count,
            first_of_sets,
            tiles: page.tile_places(),
        };
        let (elapsed, counts) = self.tracer.trace(&self.context, &self.sets, page, push)?;
        match counts.overruns {
            0 => Ok((elapsed, counts)),
            _ => Err(self.overrun_error()),
        }
    }

    /// Index of a pixel's sample after so many others of this render.
    fn sample_index(&self, samples_before: u32) -> u32 {
        self.settings.sample_offset.unwrap_or(0).wrapping_add(samples_before)
    }

    /// Index of the first sample that may share a set with the next ones: the first since the guide has learned, so that a
    /// sample's guide is independent of it. `first_of_step` begins the step that the next samples belong to.
    fn first_of_sets(&self, first_of_step: u32) -> u32 {
        match &self.learning {
            Learning::Nothing => 0,
            Learning::Grids(_) => first_of_step,
            Learning::Quadtrees(_) => self.sample_index(first_of_iteration(self.samples_done)),
        }
    }

    fn weights_of_next_samples(&self) -> DispatchWeights {
        let before = self.settings.weight_sums(self.samples_done);
        let lost = |effective: f64| (f64::from(self.samples_done) - effective) as f32;
        DispatchWeights {
            of_sample: self.settings.weight_of_sample(self.samples_done),
            lost_weight: lost(before.weight),
            lost_samples: lost(before.effective_samples()),
        }
    }

    /// Chooses the tiles that go on, where noise ends them. The first samples do not tell how noisy a tile is.
    pub(super) fn choose_tiles(&mut self) -> Result<()> {
        if self.film_store.adaptive().is_none() {
            return Ok(());
        }
        self.gather_film()?;
        match self.team.clone() {
            None => self.choose_own_tiles()?,
            // The first rank has the film.
            Some(team) if team.leads() => {
                let chosen = self.choose_own_tiles().map(|()| Vec::new());
                let tiles = self.film_store.adaptive().map(Adaptive::going_on).unwrap_or_default();
                team.meet(chosen, &|| false, |_| Ok(tiles))?;
            }
            Some(team) => {
                let tiles = team.meet(Ok(Vec::new()), &|| false, |_| Ok(Vec::new()))?;
                if let FilmStore::Adaptive(adaptive) = &mut self.film_store {
                    adaptive.go_on(&tiles, self.sets.frame.pages())?;
                }
            }
        }
        let adaptive = self.film_store.adaptive();
        let mut pages = self.others.iter().map(|other| other.sets.frame.pages());
        adaptive.map_or(Ok(()), |adaptive| pages.try_for_each(|pages| adaptive.sample_on(pages)))
    }

    fn choose_own_tiles(&mut self) -> Result<()> {
        match &mut self.film_store {
            FilmStore::Adaptive(adaptive) if self.samples_done < LEAST_SAMPLES => {
                adaptive.restart(self.sets.frame.pages())
            }
            FilmStore::Adaptive(adaptive) => adaptive.judge(&self.context, &self.slicer, &self.sets),
            FilmStore::Plain | FilmStore::Part(_) => Ok(()),
        }
    }

    /// Runs every kernel once. Tracing takes no sample, and updates of empty grids write the floor that later updates start
    /// from.
    pub(super) fn warm_up(&mut self) -> Result<()> {
        let page = self.sets.frame.first_page();
        if let Some(slice) = self.slicer.smallest_slice(page) {
            self.trace_slice(page, slice, 0, 0)?;
        }
        if let FilmStore::Adaptive(adaptive) = &mut self.film_store {
            // The empty film has no noise, so this ends all tiles. They begin again below.
            adaptive.judge(&self.context, &self.slicer, &self.sets)?;
        }
        self.choose_tiles()?;
        match &self.learning {
            Learning::Nothing => Ok(()),
            Learning::Grids(updates) => updates.run(&self.context, &self.slicer, &self.sets, &self.cells),
            Learning::Quadtrees(refinement) => refinement.refine(&self.context, &self.sets, &self.settings, 0),
        }
    }

    fn overrun_error(&self) -> Error {
        let fewer = match self.settings.samples_per_dispatch {
            1 => String::new(),
            samples => format!("--samples-per-dispatch below {samples} or "),
        };
        Error::LoopCut(format!(
            "the driver of {} ended a loop of a kernel before its end, so pixels would come out dark: render again with \
             {fewer}a smaller --max-depth",
            self.context.device().name,
        ))
    }
}
