//! The options that choose and tune a guide.

use lodestar::settings::{
    AUTO_GRID, BsdfShare, DirectionMap, GuideSet, Learner, Mix, Roulette, SampleWeights, Sampler, Settings,
    StepSchedule,
};

/// How directions are sampled and learned.
#[derive(Debug, clap::Args)]
pub struct GuidingArgs {
    /// How directions are sampled.
    #[arg(long, value_enum, default_value_t = Sampler::Product, help_heading = "Guiding")]
    pub sampler: Sampler,
    /// Which surfaces are guided: diffuse lobes, also rough conductors and dielectrics as in the authors' code, or all
    /// [default: all].
    #[arg(long, value_enum, help_heading = "Guiding")]
    pub guide_set: Option<GuideSet>,
    /// How the guide learns [default: sarsa; with quadtree: monte-carlo].
    #[arg(long, value_enum, help_heading = "Guiding")]
    pub learner: Option<Learner>,
    /// Directions over which the learner expected-sarsa takes its mean [default: 128].
    #[arg(long, value_name = "N", help_heading = "Guiding")]
    pub expected_directions: Option<u32>,
    /// What rejection-mix mixes with the uniform share: densities (Eq. 8) or acceptances (Eq. 9) [default: density].
    #[arg(long, value_enum, help_heading = "Guiding")]
    pub mix: Option<Mix>,
    /// Share that is mixed with the guide: of uniform directions with rejection-mix [default: the optimal one, Eq. 8], of
    /// the scattering function with product [default: what each cell learns].
    #[arg(long, value_name = "E", help_heading = "Guiding")]
    pub epsilon: Option<f32>,
    /// What a surface's own scattering function keeps of product's samples, the BSDF sampling fraction: what each cell learns, or
    /// a fixed share, 0.25 or --epsilon [default: learned; with monte-carlo: fixed].
    #[arg(long, value_enum, help_heading = "Guiding")]
    pub bsdf_share: Option<BsdfShare>,
    /// What Russian roulette goes by: throughput, after --rr-depth edges; or with product, from the first edge on, what the guide
    /// expects a path still to bring to its pixel [default: contribution with product, unless --rr-depth is no less than
    /// --max-depth, which leaves roulette out].
    #[arg(long, value_enum, help_heading = "Guiding")]
    pub roulette: Option<Roulette>,
    /// Map between directions and their bins [default: equal-area].
    #[arg(long, value_enum, help_heading = "Guiding")]
    pub map: Option<DirectionMap>,
    /// Cells of the guide along each axis, or `auto`: as many, near to cubes, as 8 MiB hold [default: 8].
    #[arg(long, value_name = "N|auto", value_parser = number_or_auto, help_heading = "Guiding")]
    pub grid: Option<u32>,
    /// Targets that what a cell's neighbors have learned counts for in each of its bins; 0: nothing [default: 0].
    #[arg(long, value_name = "K", help_heading = "Guiding")]
    pub fallback: Option<f32>,
    /// Direction bins of a cell along each axis [default: 16].
    #[arg(long, value_name = "N", help_heading = "Guiding")]
    pub directions: Option<u32>,
    /// Most samples per pixel between two updates of the guide [default: 8].
    #[arg(long, value_name = "N", help_heading = "Guiding")]
    pub spp_per_step: Option<u32>,
    /// Whether there are fewer at first: a quarter of the samples so far, from 1 up to the most [default: growing].
    #[arg(long, value_enum, help_heading = "Guiding")]
    pub steps: Option<StepSchedule>,
    /// What samples count for: all the same; or those of an early guide less, by a fixed schedule [default: growing with
    /// product, but for --noise and --sample-offset; else even].
    #[arg(long, value_enum, help_heading = "Guiding")]
    pub sample_weights: Option<SampleWeights>,
    /// Normal bins of a cell along each side [default: 16].
    #[arg(long, value_name = "N", help_heading = "Guiding")]
    pub normals: Option<u32>,
    /// What one step leaves of a bin's earlier count; 1 is the paper's running mean [default: 0.95].
    #[arg(long, value_name = "D", help_heading = "Guiding")]
    pub decay: Option<f32>,
    /// Tries of rejection sampling before it takes a uniform direction [default: 15].
    #[arg(long, value_name = "K", help_heading = "Guiding")]
    pub max_tries: Option<u32>,
    /// Least share of uniform directions in the guide [default: 0.0625]. Inversion has far fewer outliers with 0.25 to 0.5: it
    /// draws light that the table has missed hardly ever, and what it then draws weighs up to 2/E, edge after edge.
    #[arg(long, value_name = "E", help_heading = "Guiding")]
    pub min_uniform: Option<f32>,
}

fn number_or_auto(text: &str) -> Result<u32, String> {
    match text {
        "auto" => Ok(AUTO_GRID),
        _ => text.parse().map_err(|_| "neither a number nor auto".into()),
    }
}

impl GuidingArgs {
    /// Changes what the options say.
    pub fn apply(&self, settings: &mut Settings) {
        settings.sampler = self.sampler;
        settings.guide_set = self.guide_set.unwrap_or(settings.guide_set);
        settings.learner = self.learner.unwrap_or(self.sampler.default_learner());
        settings.expected_directions = self.expected_directions.unwrap_or(settings.expected_directions);
        settings.mix = self.mix.unwrap_or(settings.mix);
        settings.epsilon = self.epsilon;
        settings.bsdf_share = self.bsdf_share;
        settings.roulette = self.roulette;
        settings.map = self.map.unwrap_or(settings.map);
        settings.grid = self.grid.unwrap_or(settings.grid);
        settings.fallback = self.fallback.unwrap_or(settings.fallback);
        settings.directions = self.directions.unwrap_or(settings.directions);
        settings.normals = self.normals.unwrap_or(settings.normals);
        settings.spp_per_step = self.spp_per_step.unwrap_or(settings.spp_per_step);
        settings.steps = self.steps.unwrap_or(settings.steps);
        settings.sample_weights = self.sample_weights;
        settings.decay = self.decay.unwrap_or(settings.decay);
        settings.max_tries = self.max_tries.unwrap_or(settings.max_tries);
        settings.min_uniform = self.min_uniform.unwrap_or(settings.min_uniform);
    }
}
