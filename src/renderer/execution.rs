//! Which way paths are traced, where either gives the same picture: by what each takes.

/// A way to trace paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// One kernel follows each path to its end.
    Megakernel,
    /// All paths travel an edge, then the next.
    Wavefront,
}

/// Both have turns until each has been measured, and again once batches are longer by this factor: waves of few paths leave
/// a device idle.
const LONGER: u32 = 2;

/// Chooses the faster way, as measured on batches of samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Choice {
    /// Batches that each way has had. The first of each, when kernels, caches and slices are cold, does not count.
    turns: [u32; 2],
    /// Samples of the batches that were measured.
    batch: u32,
    seconds_per_sample: [Option<f64>; 2],
}

impl Choice {
    /// The way of the next batch, of so many samples per pixel.
    pub fn way(&mut self, batch: u32) -> Way {
        if batch >= LONGER.saturating_mul(self.batch.max(1)) {
            self.seconds_per_sample = [None; 2];
        }
        match self.seconds_per_sample {
            [Some(megakernel), Some(wavefront)] if wavefront < megakernel => Way::Wavefront,
            [Some(_), Some(_)] => Way::Megakernel,
            [Some(_), None] => Way::Wavefront,
            [None, Some(_)] => Way::Megakernel,
            [None, None] if self.turns[0] <= self.turns[1] => Way::Megakernel,
            [None, None] => Way::Wavefront,
        }
    }

    /// Takes note of a batch of so many samples per pixel.
    pub fn measured(&mut self, way: Way, batch: u32, seconds: f64) {
        let place = way as usize;
        self.turns[place] = self.turns[place].saturating_add(1);
        if self.turns[place] > 1 && self.seconds_per_sample[place].is_none() {
            self.batch = batch;
            self.seconds_per_sample[place] = Some(seconds / f64::from(batch.max(1)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ways of batches of so many samples, where a sample takes so many seconds of either.
    fn ways(batches: &[u32], megakernel: f64, wavefront: f64) -> Vec<Way> {
        let mut choice = Choice::default();
        let run = |&batch: &u32| {
            let way = choice.way(batch);
            let of_sample = if way == Way::Megakernel { megakernel } else { wavefront };
            choice.measured(way, batch, of_sample * f64::from(batch));
            way
        };
        batches.iter().map(run).collect()
    }

    #[test]
    fn the_faster_way_is_taken_once_both_are_known() {
        use Way::{Megakernel as M, Wavefront as W};
        assert_eq!(ways(&[8; 7], 1.0, 2.0), [M, W, M, W, M, M, M]);
        assert_eq!(ways(&[8; 7], 2.0, 1.0), [M, W, M, W, W, W, W]);
    }

    #[test]
    fn longer_batches_are_measured_anew() {
        use Way::{Megakernel as M, Wavefront as W};
        assert_eq!(ways(&[1, 1, 1, 1, 1, 3, 3, 3, 5, 8, 8, 8], 2.0, 1.0), [M, W, M, W, W, M, W, W, W, M, W, W]);
    }
}
