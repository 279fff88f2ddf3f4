//! Table of the rows that are proven: every sampler with every way to set it, and every learner. All claims test every
//! row.

use lodestar::settings::{BsdfShare, DirectionMap, GuideSet, Learner, Mix, SampleWeights, Sampler, Settings};
use support::guide_cases::Kind;
use support::scenes::ours;
use support::tier;
use support::twins::normalization_entry::Rules;

use crate::subject::Change;

/// A way to draw directions.
#[derive(Clone, Copy)]
pub struct Row {
    pub name: &'static str,
    pub set: Change,
    /// Whether the short form of the suite tests it.
    pub is_short: bool,
}

const fn row(name: &'static str, set: Change) -> Row {
    Row { name, set, is_short: true }
}

/// Row of the full form only.
const fn more(name: &'static str, set: Change) -> Row {
    Row { name, set, is_short: false }
}

/// Rows that follow a guide.
pub const GUIDED: &[Row] = &[
    row("rejection-mix", |s| s.sampler = Sampler::RejectionMix),
    more("rejection-mix, cylindrical", |s| (s.sampler, s.map) = (Sampler::RejectionMix, DirectionMap::Cylindrical)),
    more("rejection-mix, share 0.3", |s| (s.sampler, s.epsilon) = (Sampler::RejectionMix, Some(0.3))),
    more("acceptance mix", |s| (s.sampler, s.mix) = (Sampler::RejectionMix, Mix::Acceptance)),
    more("rejection", |s| s.sampler = Sampler::Rejection),
    more("sphere-inversion", |s| s.sampler = Sampler::SphereInversion),
    row("hemisphere-inversion", |s| s.sampler = Sampler::HemisphereInversion),
    row("product", |s| s.sampler = Sampler::Product),
    // With a much smaller share, the few uniform samples have such large weights that their sums are far from normally
    // distributed.
    more("rejection-mix, share 0.05, cylindrical", |s| {
        (s.sampler, s.epsilon, s.map) = (Sampler::RejectionMix, Some(0.05), DirectionMap::Cylindrical);
    }),
    more("rejection-mix, 1 try", |s| (s.sampler, s.max_tries) = (Sampler::RejectionMix, 1)),
    more("rejection-mix, 2 tries", |s| (s.sampler, s.max_tries) = (Sampler::RejectionMix, 2)),
    more("rejection-mix, 32 tries", |s| (s.sampler, s.max_tries) = (Sampler::RejectionMix, 32)),
    more("rejection-mix, half uniform", |s| (s.sampler, s.min_uniform) = (Sampler::RejectionMix, 0.5)),
    more("acceptance mix, cylindrical", |s| {
        (s.sampler, s.mix, s.map) = (Sampler::RejectionMix, Mix::Acceptance, DirectionMap::Cylindrical);
    }),
    more("acceptance mix, share 0.05, 2 tries", |s| {
        (s.sampler, s.mix, s.epsilon, s.max_tries) = (Sampler::RejectionMix, Mix::Acceptance, Some(0.05), 2);
    }),
    more("rejection, 32 tries, cylindrical", |s| {
        (s.sampler, s.max_tries, s.map) = (Sampler::Rejection, 32, DirectionMap::Cylindrical);
    }),
    more("sphere-inversion, cylindrical", |s| {
        (s.sampler, s.map) = (Sampler::SphereInversion, DirectionMap::Cylindrical)
    }),
    more("hemisphere-inversion, cylindrical", |s| {
        (s.sampler, s.map) = (Sampler::HemisphereInversion, DirectionMap::Cylindrical);
    }),
    more("product, cylindrical", |s| (s.sampler, s.map) = (Sampler::Product, DirectionMap::Cylindrical)),
    more("product, half by the cosine", |s| (s.sampler, s.epsilon) = (Sampler::Product, Some(0.5))),
    more("hemisphere-inversion, half uniform", |s| (s.sampler, s.min_uniform) = (Sampler::HemisphereInversion, 0.5)),
];

/// Rows that only claims about pictures test. They have no table of bins, or more parts than the kernels of single
/// functions have. `tests/samplers/quadtree.rs` tests samples and trees of quadtrees, `tests/samplers/shares.rs` tests
/// learned shares.
pub const RENDERED: &[Row] = &[
    row("quadtree", |s| (s.sampler, s.learner) = (Sampler::Quadtree, Learner::MonteCarlo)),
    row("product, every part", |s| {
        (s.sampler, s.guide_set, s.fallback) = (Sampler::Product, GuideSet::All, Some(4.0));
    }),
    // Cells that do not borrow send more paths where they expect little, so more survivors have little hope.
    row("product, growing weights, own cells", |s| {
        (s.sampler, s.sample_weights, s.fallback) = (Sampler::Product, Some(SampleWeights::Growing), Some(0.0));
    }),
    more("product, fixed share", |s| (s.sampler, s.bsdf_share) = (Sampler::Product, Some(BsdfShare::Fixed))),
];

/// Row of the plain path tracer.
pub const UNGUIDED: Row = row("bsdf", |s| s.sampler = Sampler::Bsdf);

/// All learners, by name.
pub const LEARNERS: &[(&str, Learner)] =
    &[("sarsa", Learner::Sarsa), ("expected-sarsa", Learner::ExpectedSarsa), ("monte-carlo", Learner::MonteCarlo)];

impl Row {
    /// Constants of this row, in the form that kernels of single functions and their twins take.
    pub fn kind(&self) -> Kind {
        let mut s = Settings::for_scene(&ours("furnace/scene.xml", &[]));
        (self.set)(&mut s);
        let rules = Rules {
            sampler: s.sampler,
            mix: s.mix,
            epsilon: s.epsilon.map(f64::from),
            max_tries: s.max_tries,
            min_uniform_share: f64::from(s.min_uniform),
        };
        Kind { rules, map: s.map }
    }
}

/// Part of the table that is tested.
#[derive(Clone, Copy)]
pub struct Scope {
    /// Whether it is the full form.
    pub full: bool,
    /// The only row to test, if there is one.
    only: Option<&'static str>,
}

impl Scope {
    /// Scope of this run: the full form if `LODESTAR_FULL` is set, else the short form.
    pub fn of_this_run() -> Self {
        Self { full: tier::is_full(), only: None }
    }

    /// Scope of the short form with one row of the table.
    pub const fn only(row: &'static str) -> Self {
        Self { full: false, only: Some(row) }
    }

    /// The rows that follow a guide.
    pub fn guided(&self) -> Vec<Row> {
        self.wanted(GUIDED)
    }

    /// Rows that follow a guide, and the plain path tracer.
    pub fn all(&self) -> Vec<Row> {
        let unguided = self.only.is_none_or(|name| name == UNGUIDED.name).then_some(UNGUIDED);
        unguided.into_iter().chain(self.guided()).collect()
    }

    /// All rows that pictures are rendered with.
    pub fn rendered(&self) -> Vec<Row> {
        self.all().into_iter().chain(self.wanted(RENDERED)).collect()
    }

    fn wanted(&self, rows: &[Row]) -> Vec<Row> {
        let is_wanted = |row: &&Row| self.only.map_or(row.is_short || self.full, |name| row.name == name);
        rows.iter().filter(is_wanted).copied().collect()
    }

    /// Whether it is a single row.
    pub fn is_narrow(&self) -> bool {
        self.only.is_some()
    }
}
