//! When a guide learns: how many samples the steps of a render have.

use crate::settings::{Sampler, Settings, StepSchedule};

/// A growing step has one of so many parts of the samples before it.
pub(crate) const PARTS: u32 = 4;

impl Settings {
    /// Samples per pixel of the step that begins after so many: at most [`Settings::spp_per_step`], and while steps grow the
    /// largest power of two that is no more than a quarter of those, at least 1.
    pub fn samples_of_step(&self, samples_done: u32) -> u32 {
        if !self.grows() || samples_done >= self.end_of_growth() {
            return self.spp_per_step;
        }
        (samples_done / PARTS).checked_ilog2().map_or(1, |exponent| 1 << exponent)
    }

    /// Where nothing depends on steps, none is short.
    fn grows(&self) -> bool {
        self.steps == StepSchedule::Growing && self.has_grids()
    }

    /// Whether there is a guide that learns by steps.
    pub(crate) fn has_grids(&self) -> bool {
        !matches!(self.sampler, Sampler::Bsdf | Sampler::Quadtree)
    }

    /// Samples after which steps are as long as they may be.
    fn end_of_growth(&self) -> u32 {
        PARTS * self.spp_per_step.next_power_of_two()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};

    fn settings(sampler: Sampler, steps: StepSchedule, spp_per_step: u32) -> Settings {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        let defaults = Settings::for_film(&film, &IntegratorDescription::default());
        Settings { sampler, steps, spp_per_step, ..defaults }
    }

    fn sizes(settings: &Settings, count: usize) -> Vec<u32> {
        let mut done = 0;
        let mut next = || {
            let size = settings.samples_of_step(done);
            done += size;
            size
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn steps_grow_to_their_full_length() {
        let growing = |spp_per_step| sizes(&settings(Sampler::Product, StepSchedule::Growing, spp_per_step), 20);
        assert_eq!(growing(8), [1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 4, 4, 4, 4, 8, 8, 8, 8]);
        assert_eq!(growing(3), [1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3]);
        assert_eq!(growing(1), [1; 20]);
    }

    #[test]
    fn even_steps_and_those_that_nothing_depends_on_do_not_grow() {
        let of = |sampler, steps| sizes(&settings(sampler, steps, 8), 5);
        assert_eq!(of(Sampler::Product, StepSchedule::Even), [8; 5]);
        assert_eq!(of(Sampler::Bsdf, StepSchedule::Growing), [8; 5]);
        assert_eq!(of(Sampler::Quadtree, StepSchedule::Growing), [8; 5]);
    }
}
