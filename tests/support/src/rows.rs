//! The table of samplers and learners, `tests/samplers.table`. Its rows are options of the command line, so `tests/same_bits.sh`
//! reads the table, too.

use lodestar::settings::options;
use lodestar::settings::{Learner, Sampler, Settings, Word};

use crate::tier;

const TABLE: &str = include_str!("../../samplers.table");

/// Claims that go through the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Held {
    /// Claims of the proofs about single functions, and about renders.
    Functions,
    /// Claims of the proofs about renders only.
    Renders,
    /// Guided pictures beside unguided ones, and the same bits however the work is cut.
    Guided,
}

/// A way to draw directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    pub name: &'static str,
    /// Options of the command line that choose it.
    pub options: &'static str,
    claims: &'static str,
}

/// The whole table.
pub fn rows() -> impl Iterator<Item = Row> {
    TABLE.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(Row::read)
}

/// The row with this name.
pub fn row(name: &str) -> Row {
    rows().find(|row| row.name == name).unwrap_or_else(|| panic!("tests/samplers.table has no row {name}"))
}

/// Rows of this run that are held to a claim: all of them in the long tier, in the quick tier those with a star.
pub fn held_to(held: Held) -> Vec<Row> {
    rows().filter(|row| row.is_quick(held) || tier::is_full() && row.is_held_to(held)).collect()
}

impl Row {
    fn read(line: &'static str) -> Self {
        let mut columns = line.split('|').map(str::trim);
        let mut column = || columns.next().unwrap_or_else(|| panic!("a row of four columns, not {line}"));
        Self { name: column(), options: column(), claims: column() }
    }

    pub fn is_held_to(&self, held: Held) -> bool {
        self.has(held, "") || self.is_quick(held)
    }

    /// Whether the quick tier holds the row to the claim, too.
    pub fn is_quick(&self, held: Held) -> bool {
        self.has(held, "*")
    }

    fn has(&self, held: Held, mark: &str) -> bool {
        let word = match held {
            Held::Functions => "functions",
            Held::Renders => "renders",
            Held::Guided => "guided",
        };
        self.claims.split_whitespace().any(|claim| claim.strip_prefix(word) == Some(mark))
    }

    /// Sets the row's options.
    pub fn set(&self, settings: &mut Settings) {
        set(settings, self.options);
    }
}

/// Sets options as the command line writes them.
fn set(settings: &mut Settings, options: &str) {
    let mut words = options.split_whitespace();
    while let (Some(name), Some(value)) = (words.next(), words.next()) {
        let entry = name.strip_prefix("--").and_then(options::find).unwrap_or_else(|| panic!("no option {name}"));
        let set = entry.set().unwrap_or_else(|| panic!("{name} sets no setting"));
        set(settings, value).unwrap_or_else(|error| panic!("{name} {value}: {error}"));
    }
}

/// Every value of an option that takes words, read back from the settings.
fn values<T>(name: &str, read: impl Fn(&Settings) -> T) -> Vec<T> {
    let mut settings = options::defaults();
    let words = options::find(name).unwrap_or_else(|| panic!("no option {name}")).words();
    let value = |word: &Word| {
        set(&mut settings, &format!("--{name} {}", word.name));
        read(&settings)
    };
    words.iter().map(value).collect()
}

/// Every sampler; the plain path tracer is the first.
pub fn samplers() -> Vec<Sampler> {
    values("sampler", |settings| settings.sampler)
}

/// Every learner with its name; the default is the first.
pub fn learners() -> Vec<(String, Learner)> {
    let names = options::find("learner").into_iter().flat_map(|option| option.words());
    names.map(|word| word.name).zip(values("learner", |settings| settings.learner)).collect()
}

/// All samplers that follow a guide, each with every learner that it can be combined with. The quick tier has every
/// sampler with its default learner, and one sampler with every learner.
pub fn combinations() -> Vec<(Sampler, Learner)> {
    let all =
        samplers().into_iter().flat_map(|sampler| learners().into_iter().map(move |(_, learner)| (sampler, learner)));
    let is_legal = |&(sampler, learner): &(Sampler, Learner)| {
        let settings = Settings { sampler, learner, ..options::defaults() };
        sampler != Sampler::Bsdf && options::check(&settings).is_ok()
    };
    let is_wanted = |&(sampler, learner): &(Sampler, Learner)| {
        tier::is_full() || sampler == Sampler::RejectionMix || learner == sampler.default_learner()
    };
    all.filter(is_legal).filter(is_wanted).collect()
}

#[test]
fn every_row_is_legal_and_every_sampler_has_one() {
    let mut found = Vec::new();
    for (at, row) in rows().enumerate() {
        assert!(rows().take(at).all(|other| other.name != row.name && other.options != row.options), "{}", row.name);
        let mut settings = options::defaults();
        row.set(&mut settings);
        options::check(&settings).unwrap_or_else(|error| panic!("{}: {error}", row.name));
        found.push(settings.sampler);
        for claim in row.claims.split_whitespace() {
            let known = ["functions", "renders", "guided"].contains(&claim.trim_end_matches('*'));
            assert!(known, "{}: {claim} is no claim", row.name);
        }
    }
    assert!(samplers().iter().all(|sampler| found.contains(sampler)), "{found:?}");
    assert_eq!(samplers()[0], Sampler::Bsdf);
    assert_eq!(learners()[0].1, Learner::Sarsa);
}
