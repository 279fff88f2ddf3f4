//! Which settings are in range, and which go together.

use super::{
    AUTO_GRID, BsdfShare, EXPECTED_DIRECTIONS, Execution, Learner, MAX_DEPTH_LIMIT, MAX_FILM_SIDE, MAX_KEPT_VERTICES,
    Mix, Roulette, SampleWeights, Sampler, Settings, in_range,
};
use crate::{Error, Result};

impl Settings {
    /// Checks every range.
    ///
    /// # Errors
    /// [`Error::Settings`], naming the option and what it allows.
    pub fn validate(&self) -> Result<()> {
        in_range("width", self.width, 1, MAX_FILM_SIDE)?;
        in_range("height", self.height, 1, MAX_FILM_SIDE)?;
        in_range("max-depth", self.max_depth, 1, MAX_DEPTH_LIMIT)?;
        in_range("rr-depth", self.rr_depth, 1, u32::MAX)?;
        if self.grid != AUTO_GRID {
            in_range("grid", self.grid, 1, 32)?;
        }
        in_range("fallback", self.fallback, 0.0, 1.0e6)?;
        self.validate_directions()?;
        in_range("normals", self.normals, 4, 32)?;
        in_range("spp-per-step", self.spp_per_step, 1, 65_536)?;
        in_range("noise", self.noise.unwrap_or(1.0), 1.0e-4, 1.0)?;
        if self.noise.is_some() && self.sample_offset.is_some() {
            return Err(Error::Settings(
                "--noise ends each part of a picture elsewhere, so it goes not with --sample-offset: give every part an --spp"
                    .into(),
            ));
        }
        in_range("samples-per-dispatch", self.samples_per_dispatch, 1, 64)?;
        in_range("max-tries", self.max_tries, 1, 1024)?;
        in_range("min-uniform", self.min_uniform, 1.0e-4, 1.0)?;
        in_range("decay", self.decay, 0.0, 1.0)?;
        in_range("epsilon", self.epsilon.unwrap_or(1.0), 1.0e-4, 1.0)?;
        in_range("expected-directions", self.expected_directions, 1, 4096)?;
        self.validate_sample_weights()?;
        self.validate_mix()?;
        self.validate_learner()?;
        in_range("slice-ms", self.slice_milliseconds.unwrap_or(1.0), 0.001, 60_000.0)?;
        if self.execution == Execution::Wavefront {
            self.check_wavefront()?;
        }
        self.validate_crop()
    }

    /// Whether paths can be traced as waves.
    pub(crate) fn check_wavefront(&self) -> Result<()> {
        let refused = |what: &str| {
            Err(Error::Settings(format!("--execution wavefront does not go with {what}: take --execution megakernel")))
        };
        if self.noise.is_some() {
            return refused("--noise");
        }
        if self.sampler != Sampler::Bsdf && self.learner == Learner::MonteCarlo {
            return refused("--learner monte-carlo, which keeps all vertices of a path");
        }
        Ok(())
    }

    fn validate_sample_weights(&self) -> Result<()> {
        if self.sample_weights() == SampleWeights::Even {
            return Ok(());
        }
        let refused = [
            (self.sampler == Sampler::Bsdf, "--sampler bsdf: without a guide, no sample is better than another"),
            (self.noise.is_some(), "--noise, which is estimated from samples that all count the same"),
            (
                self.sample_offset.is_some(),
                "--sample-offset: parts of a picture are averaged by their numbers of samples",
            ),
        ];
        let refusal = refused.iter().find(|(is_refused, _)| *is_refused);
        refusal.map_or(Ok(()), |(_, with)| {
            Err(Error::Settings(format!("--sample-weights growing does not go with {with}")))
        })
    }

    fn validate_mix(&self) -> Result<()> {
        if self.mix != Mix::Density && self.sampler != Sampler::RejectionMix {
            return Err(Error::Settings("--mix is for --sampler rejection-mix only".into()));
        }
        if self.epsilon.is_some() && !matches!(self.sampler, Sampler::RejectionMix | Sampler::Product) {
            return Err(Error::Settings("--epsilon is for the samplers rejection-mix and product only".into()));
        }
        if self.roulette == Some(Roulette::Contribution) && self.sampler != Sampler::Product {
            return Err(Error::Settings("--roulette contribution is for --sampler product only".into()));
        }
        if self.bsdf_share.is_some() && self.sampler != Sampler::Product {
            return Err(Error::Settings("--bsdf-share is for --sampler product only".into()));
        }
        if self.bsdf_share == Some(BsdfShare::Learned) && !self.learns_share() {
            return Err(Error::Settings(
                "--bsdf-share learned goes with neither --epsilon nor --learner monte-carlo".into(),
            ));
        }
        Ok(())
    }

    fn validate_directions(&self) -> Result<()> {
        in_range("directions", self.directions, 4, 64)?;
        if self.sampler == Sampler::Product && ![16, 32, 64].contains(&self.directions) {
            return Err(Error::Settings(format!(
                "--sampler product descends in steps of four, so --directions must be 16, 32 or 64, but it is {}",
                self.directions
            )));
        }
        Ok(())
    }

    fn validate_learner(&self) -> Result<()> {
        if self.sampler == Sampler::Bsdf && self.learner != Learner::Sarsa {
            return Err(Error::Settings(
                "--sampler bsdf learns nothing, so --learner is for the other samplers".into(),
            ));
        }
        if self.sampler == Sampler::Quadtree && self.learner != Learner::MonteCarlo {
            return Err(Error::Settings(
                "--sampler quadtree learns by --learner monte-carlo only: its squares of directions hold flux, not radiance"
                    .into(),
            ));
        }
        if self.sampler == Sampler::Quadtree && (self.grid == AUTO_GRID || self.fallback > 0.0) {
            return Err(Error::Settings(
                "--grid auto and --fallback are for samplers with cells, not for --sampler quadtree".into(),
            ));
        }
        if self.learner == Learner::IrradianceSarsa && self.sampler != Sampler::Product {
            return Err(Error::Settings("--learner irradiance-sarsa is for --sampler product only".into()));
        }
        if self.learner != Learner::ExpectedSarsa && self.expected_directions != EXPECTED_DIRECTIONS {
            return Err(Error::Settings("--expected-directions is for --learner expected-sarsa only".into()));
        }
        if self.learner == Learner::MonteCarlo && self.max_depth > MAX_KEPT_VERTICES {
            return Err(Error::Settings(format!(
                "--learner monte-carlo keeps every vertex of a path, so --max-depth must be at most {MAX_KEPT_VERTICES}, \
                 but it is {}",
                self.max_depth
            )));
        }
        Ok(())
    }
}
