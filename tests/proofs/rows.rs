//! Rows of the table that are proven. All claims test every row.

use lodestar::settings::{Learner, Settings};
use support::guide_cases::Kind;
pub use support::rows::Row;
use support::rows::{self, Held};
use support::scenes::ours;
use support::tier;
use support::twins::normalization_entry::Rules;

/// Name of the plain path tracer's row.
pub const UNGUIDED: &str = "bsdf";

/// Constants of a row, in the form that kernels of single functions and their twins take.
pub fn kind_of(row: &Row) -> Kind {
    let mut s = Settings::for_scene(&ours("furnace/scene.xml", &[]));
    row.set(&mut s);
    let rules = Rules {
        sampler: s.sampler,
        mix: s.mix,
        epsilon: s.epsilon.map(f64::from),
        max_tries: s.max_tries,
        min_uniform_share: f64::from(s.min_uniform),
    };
    Kind { rules, map: s.map }
}

/// Learners besides the default, by name.
pub fn further_learners() -> Vec<(String, Learner)> {
    rows::learners().split_off(1)
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

    /// Rows that claims about single functions test. They follow a guide.
    pub fn guided(&self) -> Vec<Row> {
        self.wanted(Held::Functions)
    }

    /// Rows that follow a guide, and the plain path tracer.
    pub fn all(&self) -> Vec<Row> {
        let unguided = self.only.is_none_or(|name| name == UNGUIDED).then(|| rows::row(UNGUIDED));
        unguided.into_iter().chain(self.guided()).collect()
    }

    /// All rows that pictures are rendered with.
    pub fn rendered(&self) -> Vec<Row> {
        self.all().into_iter().chain(self.wanted(Held::Renders)).collect()
    }

    fn wanted(&self, held: Held) -> Vec<Row> {
        let is_wanted = |row: &Row| match self.only {
            Some(name) => row.name == name && row.is_held_to(held),
            None => row.is_quick(held) || self.full && row.is_held_to(held),
        };
        rows::rows().filter(is_wanted).collect()
    }

    /// Whether it is a single row.
    pub fn is_narrow(&self) -> bool {
        self.only.is_some()
    }
}
