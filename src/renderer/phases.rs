//! The phases of a step, in their order. Who drives a step runs one after the other, on one device or on several.

use std::iter;

use crate::renderer::learn::quadtrees::{ended_iteration, first_of_iteration, samples_left};
use crate::settings::{Sampler, Settings};

/// One phase of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Paths add light to the film, and learning targets to the guide's sums.
    Trace(Batch),
    /// The guide moves towards the targets of the batches before it (Eq. 7), and begins new sums.
    Learn,
    /// The film takes in the step: a part of a picture keeps sums of its steps, and noise may end tiles.
    Settle,
}

/// Samples of one dispatch for every slice of the film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Batch {
    /// Samples per pixel before the batch.
    pub first: u32,
    /// Samples per pixel of the batch.
    pub samples: u32,
    /// Index of the first sample that may share a set with the batch's samples. No set begins before the guide has learned, so that
    /// a sample's guide is independent of it.
    pub first_of_sets: u32,
}

impl Batch {
    /// Samples per pixel after the batch.
    pub fn end(self) -> u32 {
        self.first + self.samples
    }
}

/// The phases of a step of `samples` samples per pixel, after `samples_done` of them.
pub(crate) fn phases(settings: &Settings, samples_done: u32, samples: u32) -> impl Iterator<Item = Phase> + use<> {
    let sampler = settings.sampler;
    let of_step = sample_index(settings, samples_done);
    let end = samples_done + samples;
    let batches = {
        let settings = settings.clone();
        let mut first = samples_done;
        iter::from_fn(move || {
            let samples = longest_batch(&settings, first).min(end - first);
            let first_of_sets = match settings.sampler {
                Sampler::Bsdf => 0,
                Sampler::Quadtree => sample_index(&settings, first_of_iteration(first)),
                _ => of_step,
            };
            let batch = Batch { first, samples, first_of_sets };
            first = batch.end();
            (samples > 0).then_some(batch)
        })
    };
    let trace = move |batch: Batch| {
        // Quadtrees learn at the end of their own iterations, which grow faster than steps.
        let learns = sampler == Sampler::Quadtree && ended_iteration(batch.end()).is_some();
        iter::once(Phase::Trace(batch)).chain(learns.then_some(Phase::Learn))
    };
    let learns_grids = !matches!(sampler, Sampler::Bsdf | Sampler::Quadtree);
    batches.flat_map(trace).chain(learns_grids.then_some(Phase::Learn)).chain([Phase::Settle])
}

/// Most samples per pixel of the batch after `samples_done` of them: the dispatch is bounded, all samples have the same weight, and
/// quadtrees that are due to learn are not followed further.
pub(crate) fn longest_batch(settings: &Settings, samples_done: u32) -> u32 {
    let of_same_weight = settings.samples_of_same_weight(samples_done);
    let until_learning = if settings.sampler == Sampler::Quadtree { samples_left(samples_done) } else { u32::MAX };
    settings.samples_per_dispatch.min(of_same_weight).min(until_learning)
}

/// Index of a pixel's sample after so many others of the render.
pub(super) fn sample_index(settings: &Settings, samples_before: u32) -> u32 {
    settings.sample_offset.unwrap_or(0).wrapping_add(samples_before)
}

#[cfg(test)]
mod tests {
    use super::Phase::{Learn, Settle, Trace};
    use super::*;
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};

    fn of(sampler: Sampler, samples_done: u32, samples: u32) -> Vec<Phase> {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        let settings = Settings {
            sampler,
            samples_per_dispatch: 4,
            sample_weights: None,
            sample_offset: Some(100),
            ..Settings::for_film(&film, &IntegratorDescription::default())
        };
        phases(&settings, samples_done, samples).collect()
    }

    fn batch(first: u32, samples: u32, first_of_sets: u32) -> Phase {
        Trace(Batch { first, samples, first_of_sets })
    }

    #[test]
    fn grids_learn_once_at_the_end_of_a_step() {
        let expected = [batch(8, 4, 108), batch(12, 4, 108), batch(16, 2, 108), Learn, Settle];
        assert_eq!(of(Sampler::Product, 8, 10), expected);
        assert_eq!(of(Sampler::Product, 8, 0), [Learn, Settle]);
    }

    #[test]
    fn quadtrees_learn_where_their_iterations_end() {
        let expected =
            [batch(0, 1, 100), Learn, batch(1, 2, 101), Learn, batch(3, 4, 103), Learn, batch(7, 1, 107), Settle];
        assert_eq!(of(Sampler::Quadtree, 0, 8), expected);
        assert_eq!(of(Sampler::Quadtree, 8, 1), [batch(8, 1, 107), Settle]);
    }

    #[test]
    fn nothing_is_learned_without_a_guide() {
        assert_eq!(of(Sampler::Bsdf, 4, 5), [batch(4, 4, 0), batch(8, 1, 0), Settle]);
    }
}
