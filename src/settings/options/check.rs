//! Checks of settings against the table of options.

use super::entry::{Needs, OptionEntry, Rule, When};
use super::table::OPTIONS;
use crate::settings::Settings;
use crate::settings::value::{Value, Words};
use crate::{Error, Result};

/// Refuses values that are out of range and combinations that cannot be rendered.
///
/// # Errors
/// [`Error::Settings`], naming the option and the condition.
pub fn check(settings: &Settings) -> Result<()> {
    check_options(settings, &|_| false)
}

/// Refuses, besides everything that [`check`] refuses, options that were given without effect.
///
/// # Errors
/// [`Error::Settings`], naming the option and the condition.
pub fn check_given(settings: &Settings, is_given: &dyn Fn(&str) -> bool) -> Result<()> {
    check_options(settings, is_given)
}

fn check_options(settings: &Settings, is_given: &dyn Fn(&str) -> bool) -> Result<()> {
    let refusals = OPTIONS.iter().filter_map(|option| option.refusal(settings, is_given(option.name)));
    refusals.map(|text| Err(Error::Settings(text))).next().unwrap_or(Ok(()))
}

impl OptionEntry {
    /// Sentence that refuses the option's value in `settings`.
    fn refusal(&self, settings: &Settings, is_given: bool) -> Option<String> {
        let value = (self.setting?.get)(settings);
        let broken = |rule: &&Rule| (rule.always || is_given) && rule.when.holds(&value) && !rule.needs.holds(settings);
        let refused = || self.rules.iter().find(broken).map(|rule| rule.sentence(self.name, &value, settings));
        self.range_refusal(&value).or_else(refused)
    }

    fn range_refusal(&self, value: &Value) -> Option<String> {
        let (&Value::Number(number), Some((least, most))) = (value, self.range) else { return None };
        let is_inside = number >= least && number <= most;
        (!is_inside).then(|| format!("--{} is {number}, but must lie between {least} and {most}", self.name))
    }
}

impl When {
    fn holds(self, value: &Value) -> bool {
        match (self, value) {
            (_, Value::Nothing) => false,
            (Self::Any, _) => true,
            (Self::Word(wanted), Value::Word(word)) => word == wanted,
            (Self::AboveZero, Value::Number(number)) => *number > 0.0,
            _ => false,
        }
    }

    /// Option with the value that the rule is about.
    pub(super) fn option_text(self, name: &str) -> String {
        match self {
            Self::Any | Self::AboveZero => format!("--{name}"),
            Self::Word(word) => format!("--{name} {word}"),
        }
    }
}

impl Needs {
    fn holds(self, settings: &Settings) -> bool {
        match self {
            Self::Samplers(samplers) => samplers.contains(&settings.sampler),
            Self::Learners(learners) => learners.contains(&settings.learner),
            Self::Without(_, is_there) => !is_there(settings),
            Self::Value(_, holds) => holds(settings),
        }
    }

    /// Condition in words, as the end of a sentence that begins with the option.
    pub(super) fn words(self) -> String {
        match self {
            Self::Samplers(samplers) => format!("is used by the {} only", listed("sampler", samplers)),
            Self::Learners(learners) => format!("is used by the {} only", listed("learner", learners)),
            Self::Without(other, _) => format!("cannot be combined with {other}"),
            Self::Value(must, _) => format!("must be {must}"),
        }
    }

    /// Remark that says how `settings` break the condition.
    fn remark(self, value: &Value, settings: &Settings) -> String {
        match self {
            Self::Samplers(_) => format!("; the sampler here is {}", settings.sampler.word()),
            Self::Learners(_) => format!("; the learner here is {}", settings.learner.word()),
            Self::Without(..) => String::new(),
            Self::Value(..) => format!(", but it is {value}"),
        }
    }
}

impl Rule {
    /// Condition with its reason.
    pub(super) fn words(&self) -> String {
        match self.reason {
            "" => self.needs.words(),
            reason => format!("{}: {reason}", self.needs.words()),
        }
    }

    fn sentence(&self, name: &str, value: &Value, settings: &Settings) -> String {
        let (option, condition) = (self.when.option_text(name), self.needs.words());
        let reason = if self.reason.is_empty() { String::new() } else { format!(": {}", self.reason) };
        format!("{option} {condition}{}{reason}", self.needs.remark(value, settings))
    }
}

/// Noun and names: "sampler a", "samplers a and b", "samplers a, b and c".
fn listed<T: Words>(noun: &str, values: &[T]) -> String {
    let names: Vec<_> = values.iter().map(|value| value.word()).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{noun}s {} and {last}", rest.join(", ")),
        _ => format!("{noun} {}", names.concat()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::options::defaults;
    use crate::settings::options::table::OPTIONS;
    use crate::settings::{AUTO_GRID, BsdfShare, Learner, LightSelection, Mix, Roulette, Sampler};

    #[test]
    fn settings_without_meaning_are_refused() {
        let changes: [fn(&mut Settings); 12] = [
            |s| s.directions = 8,
            |s| s.mix = Mix::Acceptance,
            |s| (s.bsdf_share, s.epsilon) = (Some(BsdfShare::Learned), Some(0.5)),
            |s| (s.bsdf_share, s.learner) = (Some(BsdfShare::Learned), Learner::MonteCarlo),
            |s| (s.sampler, s.epsilon) = (Sampler::Rejection, Some(0.5)),
            |s| (s.sampler, s.roulette) = (Sampler::Bsdf, Some(Roulette::Contribution)),
            |s| (s.sampler, s.bsdf_share) = (Sampler::Bsdf, Some(BsdfShare::Fixed)),
            |s| (s.sampler, s.light_selection) = (Sampler::Bsdf, Some(LightSelection::Learned)),
            |s| (s.sampler, s.learner) = (Sampler::Bsdf, Learner::MonteCarlo),
            |s| s.sampler = Sampler::Quadtree,
            |s| (s.sampler, s.learner, s.grid) = (Sampler::Quadtree, Learner::MonteCarlo, Some(AUTO_GRID)),
            |s| (s.sampler, s.learner, s.fallback) = (Sampler::Quadtree, Learner::MonteCarlo, Some(4.0)),
        ];
        assert!(check(&defaults()).is_ok());
        for (at, change) in changes.into_iter().enumerate() {
            let mut settings = defaults();
            change(&mut settings);
            assert!(check(&settings).is_err(), "change {at}");
            assert!(check(&settings.without_guide()).is_ok(), "change {at}, without a guide");
        }
    }

    #[test]
    fn without_a_guide_its_options_are_as_they_begin() {
        let needs_guide = |rule: &Rule| matches!((rule.when, rule.needs), (When::Any, Needs::Samplers(list)) if !list.contains(&Sampler::Bsdf));
        for option in OPTIONS.iter().filter(|option| option.rules.iter().any(needs_guide)) {
            let setting = option.setting.expect("a setting");
            let first = (setting.get)(&defaults());
            let words = option.words().into_iter().map(|word| word.name.to_owned());
            let numbers =
                option.range.into_iter().flat_map(|(least, most)| [least, most]).map(|number| number.to_string());
            let mut settings = defaults();
            let is_other = words.chain(numbers).any(|text| {
                (setting.set.expect("it is set from text"))(&mut settings, &text).expect("a value of the option");
                (setting.get)(&settings) != first
            });
            assert!(is_other, "{}", option.name);
            assert_eq!((setting.get)(&settings.without_guide()), first, "{}", option.name);
        }
    }
}
