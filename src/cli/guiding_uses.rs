//! What is said where an option is given that the sampler or the learner has no use for.

use lodestar::settings::{Learner, Mix, Sampler, Settings, StepSchedule};
use lodestar::{Error, Result};

use super::guiding_args::GuidingArgs;

/// An option, and who has a use for it.
struct Use {
    option: &'static str,
    /// Whether it is given and asks for something: with 0, `--fallback` does not.
    is_given: bool,
    has_use: bool,
    /// What it is for.
    of: &'static str,
}

const GUIDED: &str = "for samplers that follow a guide, not for bsdf";
const WITH_CELLS: &str = "for samplers with cells, not for bsdf or quadtree";

impl GuidingArgs {
    /// Refuses what is given in vain. [`Settings::validate`] cannot tell what is given from what is left at its default.
    ///
    /// # Errors
    /// [`Error::Settings`], naming the option and what it is for.
    pub fn check_uses(&self, settings: &Settings) -> Result<()> {
        match self.uses(settings).iter().find(|of_option| of_option.is_given && !of_option.has_use) {
            Some(Use { option, of, .. }) => Err(Error::Settings(format!("--{option} is {of}"))),
            None => Ok(()),
        }
    }

    /// Of all options but those that have a use with any sampler, and those that `validate` refuses whatever they ask for.
    fn uses(&self, settings: &Settings) -> Vec<Use> {
        let Settings { sampler, learner, .. } = *settings;
        let is_guided = sampler != Sampler::Bsdf;
        let has_cells = is_guided && sampler != Sampler::Quadtree;
        let rejects = matches!(sampler, Sampler::Rejection | Sampler::RejectionMix);
        let inverts = matches!(sampler, Sampler::SphereInversion | Sampler::HemisphereInversion);
        // Where densities are mixed, that share takes the place of one that is found and has a least one.
        let has_fixed_share = settings.epsilon.is_some() && settings.mix == Mix::Density;
        let of_epsilon = "not for a share that --epsilon fixes";
        let is_positive = |number: Option<f32>| number.is_some_and(|number| number > 0.0);
        let given = |option, is_given, has_use, of| Use { option, is_given, has_use, of };
        vec![
            given("learner", self.learner.is_some(), is_guided, GUIDED),
            given("guide-set", self.guide_set.is_some(), is_guided, GUIDED),
            given("map", self.map.is_some(), is_guided, GUIDED),
            given("grid", self.grid.is_some(), is_guided, GUIDED),
            given("directions", self.directions.is_some(), is_guided, GUIDED),
            given("fallback", is_positive(self.fallback), has_cells, WITH_CELLS),
            given("decay", self.decay.is_some(), has_cells, WITH_CELLS),
            given("steps growing", self.steps == Some(StepSchedule::Growing), has_cells, WITH_CELLS),
            given(
                "normals",
                self.normals.is_some(),
                has_cells && sampler != Sampler::SphereInversion,
                "for samplers that tell normals apart, not for bsdf, sphere-inversion or quadtree",
            ),
            given("mix", self.mix.is_some(), sampler == Sampler::RejectionMix, "for --sampler rejection-mix only"),
            given("max-tries", self.max_tries.is_some(), rejects, "for the samplers rejection and rejection-mix only"),
            given(
                "min-uniform",
                self.min_uniform.is_some(),
                rejects || inverts,
                "for the samplers by rejection and inversion, not for bsdf, product or quadtree",
            ),
            given("min-uniform", self.min_uniform.is_some(), !has_fixed_share, of_epsilon),
            given(
                "expected-directions",
                self.expected_directions.is_some(),
                learner == Learner::ExpectedSarsa,
                "for --learner expected-sarsa only",
            ),
        ]
    }
}
