//! Steps of a render: the number of samples between two updates of the guide.

use crate::settings::{Sampler, Settings, StepSchedule};

impl Settings {
    /// Samples per pixel of the step that begins after `samples_done`: at most [`Settings::spp_per_step`]. While steps grow, it is
    /// the largest power of two within `samples_done`, at least 1. A longer step costs fewer updates, and lanes that take several
    /// samples of a pixel wait less for each other.
    pub fn samples_of_step(&self, samples_done: u32) -> u32 {
        if !self.grows() {
            return self.spp_per_step;
        }
        samples_done.checked_ilog2().map_or(1, |exponent| 1 << exponent).min(self.spp_per_step)
    }

    /// Whether steps grow. Without a guide that learns by steps, every step has the full length.
    fn grows(&self) -> bool {
        self.steps == StepSchedule::Growing && self.has_grids()
    }

    /// Whether there is a guide that learns by steps.
    pub(crate) fn has_grids(&self) -> bool {
        !matches!(self.sampler, Sampler::Bsdf | Sampler::Quadtree)
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
        let growing = |spp_per_step| sizes(&settings(Sampler::Product, StepSchedule::Growing, spp_per_step), 6);
        assert_eq!(growing(8), [1, 1, 2, 4, 8, 8]);
        assert_eq!(growing(3), [1, 1, 2, 3, 3, 3]);
        assert_eq!(growing(1), [1; 6]);
    }

    #[test]
    fn even_steps_and_those_that_nothing_depends_on_do_not_grow() {
        let of = |sampler, steps| sizes(&settings(sampler, steps, 8), 5);
        assert_eq!(of(Sampler::Product, StepSchedule::Even), [8; 5]);
        assert_eq!(of(Sampler::Bsdf, StepSchedule::Growing), [8; 5]);
        assert_eq!(of(Sampler::Quadtree, StepSchedule::Growing), [8; 5]);
    }
}
