//! Changes that a method makes to its settings, besides sampler, learner and emitter sampling.

use crate::settings::{
    AUTO_GRID, BsdfShare, GuideSet, LightSelection, Roulette, SamplePattern, SampleWeights, Settings, StepSchedule,
    Words,
};

/// Replacements of settings. `None` keeps the setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Changes {
    /// Replaces [`Settings::grid`].
    pub grid: Option<u32>,
    /// Replaces [`Settings::fallback`].
    pub fallback: Option<f32>,
    /// Replaces [`Settings::directions`].
    pub directions: Option<u32>,
    /// Replaces [`Settings::guide_set`].
    pub guide_set: Option<GuideSet>,
    /// Replaces [`Settings::steps`].
    pub steps: Option<StepSchedule>,
    /// Replaces [`Settings::sample_weights`].
    pub sample_weights: Option<SampleWeights>,
    /// Replaces [`Settings::pattern`].
    pub pattern: Option<SamplePattern>,
    /// Replaces [`Settings::bsdf_share`].
    pub bsdf_share: Option<BsdfShare>,
    /// Replaces [`Settings::light_selection`].
    pub light_selection: Option<LightSelection>,
    /// Replaces [`Settings::roulette`].
    pub roulette: Option<Roulette>,
}

impl Changes {
    /// Changes that keep every setting.
    pub const NONE: Self = Self {
        grid: None,
        fallback: None,
        directions: None,
        guide_set: None,
        steps: None,
        sample_weights: None,
        pattern: None,
        bsdf_share: None,
        light_selection: None,
        roulette: None,
    };

    /// Applies the changes to the settings.
    pub fn apply(&self, settings: &mut Settings) {
        settings.grid = self.grid.or(settings.grid);
        settings.fallback = self.fallback.or(settings.fallback);
        settings.directions = self.directions.unwrap_or(settings.directions);
        settings.guide_set = self.guide_set.unwrap_or(settings.guide_set);
        settings.steps = self.steps.unwrap_or(settings.steps);
        settings.sample_weights = self.sample_weights.or(settings.sample_weights);
        settings.pattern = self.pattern.unwrap_or(settings.pattern);
        settings.bsdf_share = self.bsdf_share.or(settings.bsdf_share);
        settings.light_selection = self.light_selection.or(settings.light_selection);
        settings.roulette = self.roulette.or(settings.roulette);
    }

    /// Command-line options for the changes, such as ` --grid auto --fallback 4`.
    pub fn options(&self) -> String {
        self.words().map(|(option, value)| format!(" --{option} {value}")).collect()
    }

    /// Suffix of a method's name, such as `-g4-d32-steps-even`. A number follows the first letter of its option; a word
    /// follows the whole option.
    pub fn name(&self) -> String {
        let part = |(option, value): (&str, String)| match value.parse::<f32>() {
            Ok(_) => format!("-{}{value}", &option[..1]),
            Err(_) => format!("-{option}-{value}"),
        };
        self.words().map(part).collect()
    }

    /// Options with their values.
    fn words(&self) -> impl Iterator<Item = (&'static str, String)> {
        let grid = |grid: u32| if grid == AUTO_GRID { "auto".into() } else { grid.to_string() };
        let words = [
            ("grid", self.grid.map(grid)),
            ("fallback", self.fallback.map(|targets| targets.to_string())),
            ("directions", self.directions.map(|directions| directions.to_string())),
            ("guide-set", self.guide_set.map(word)),
            ("steps", self.steps.map(word)),
            ("sample-weights", self.sample_weights.map(word)),
            ("pattern", self.pattern.map(word)),
            ("bsdf-share", self.bsdf_share.map(word)),
            ("light-selection", self.light_selection.map(word)),
            ("roulette", self.roulette.map(word)),
        ];
        words.into_iter().filter_map(|(option, value)| Some((option, value?)))
    }
}

/// Spelling of a value on the command line.
pub(super) fn word(value: impl Words) -> String {
    value.word().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_named_as_the_command_line_has_them() {
        let fine = Changes { grid: Some(4), directions: Some(32), ..Changes::NONE };
        let adaptive = Changes { grid: Some(AUTO_GRID), fallback: Some(4.0), ..Changes::NONE };
        let even = Changes { steps: Some(StepSchedule::Even), guide_set: Some(GuideSet::All), ..Changes::NONE };
        assert_eq!(
            [fine, adaptive, even].map(|changes| changes.name()),
            ["-g4-d32", "-grid-auto-f4", "-guide-set-all-steps-even"]
        );
        assert_eq!(adaptive.options(), " --grid auto --fallback 4");
        assert_eq!((Changes::NONE.name(), Changes::NONE.options()), Default::default());
    }
}
