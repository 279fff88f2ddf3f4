//! Rendering methods that the tables compare.

use super::changes::{Changes, word};
use super::protocol::{self, Base};
use crate::settings::{Learner, Mix, Sampler, Settings};

/// Rendering method: a sampler, a learner and settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Method {
    /// Sampler.
    pub sampler: Sampler,
    /// Learner.
    pub learner: Learner,
    /// Quantity that `rejection-mix` mixes.
    pub mix: Mix,
    /// Share e of `rejection-mix`; `None` selects the optimal one.
    pub epsilon: Option<f32>,
    /// Source of all other settings.
    pub base: Base,
    /// Whether emitter sampling is on.
    pub nee: bool,
    /// Changes to the settings of `base`.
    pub changes: Changes,
}

/// Position of a method in the tables. Columns have the paper's names, or our own where the paper has no such column.
#[derive(Debug, Clone, Copy)]
pub struct TablePlace {
    /// Method.
    pub method: Method,
    /// Column in Table 1.
    pub table1: Option<&'static str>,
    /// Column in Table 2, given by the sampler. The learner gives the row.
    pub table2: Option<&'static str>,
}

const SPHERE: Option<&str> = Some("sphere, inversion");
const HEMISPHERE: Option<&str> = Some("hemisphere, inversion");
const REJECTION: Option<&str> = Some("hemisphere, rejection");
const REJECTION_MIX: Option<&str> = Some("hemisphere, Rej+");
/// Column for Eq. 9. The paper states this equation beside Eq. 8 but has no column for it.
const ACCEPTANCE: Option<&str> = Some("hemisphere, Rej+ of acceptances");

/// Column for the product sampler, which is not in the paper.
const PRODUCT: Option<&str> = Some("product");

use Learner::{ExpectedSarsa, MonteCarlo, Sarsa};

/// Methods of Tables 1 and 2. To add a method, add a line here.
pub const METHODS: [TablePlace; 20] = [
    place(Method::PLAIN, Some("BRDF"), None),
    place(Method::new(Sampler::Quadtree, MonteCarlo), Some("Quadtree"), None),
    place(Method::new(Sampler::SphereInversion, ExpectedSarsa), None, SPHERE),
    place(Method::new(Sampler::SphereInversion, MonteCarlo), None, SPHERE),
    place(Method::new(Sampler::SphereInversion, Sarsa), None, SPHERE),
    place(Method::new(Sampler::HemisphereInversion, ExpectedSarsa), None, HEMISPHERE),
    place(Method::new(Sampler::HemisphereInversion, MonteCarlo), None, HEMISPHERE),
    place(Method::new(Sampler::HemisphereInversion, Sarsa), None, HEMISPHERE),
    place(Method::new(Sampler::Rejection, ExpectedSarsa), None, REJECTION),
    place(Method::new(Sampler::Rejection, MonteCarlo), None, REJECTION),
    place(Method::new(Sampler::Rejection, Sarsa), Some("ours w/o Rej+"), REJECTION),
    place(Method::new(Sampler::RejectionMix, ExpectedSarsa), Some("ours w/o SARSA"), REJECTION_MIX),
    place(Method::new(Sampler::RejectionMix, MonteCarlo), None, REJECTION_MIX),
    place(Method::new(Sampler::RejectionMix, Sarsa), Some("ours"), REJECTION_MIX),
    place(Method::new(Sampler::RejectionMix, ExpectedSarsa).mixing_acceptances(), None, ACCEPTANCE),
    place(Method::new(Sampler::RejectionMix, MonteCarlo).mixing_acceptances(), None, ACCEPTANCE),
    place(Method::new(Sampler::RejectionMix, Sarsa).mixing_acceptances(), None, ACCEPTANCE),
    place(Method::new(Sampler::Product, ExpectedSarsa), None, PRODUCT),
    place(Method::new(Sampler::Product, MonteCarlo), None, PRODUCT),
    place(Method::new(Sampler::Product, Sarsa), PRODUCT, PRODUCT),
];

/// Shares e of Figures 7b and 7c.
pub const SHARES: [f32; 7] = [1.0e-4, 1.0e-3, 1.0e-2, 0.1, 0.25, 0.5, 1.0];

const fn place(method: Method, table1: Option<&'static str>, table2: Option<&'static str>) -> TablePlace {
    TablePlace { method, table1, table2 }
}

impl Method {
    /// Plain path tracer.
    pub const PLAIN: Self = Self::new(Sampler::Bsdf, Sarsa);

    /// Method with a sampler and a learner.
    pub const fn new(sampler: Sampler, learner: Learner) -> Self {
        let (mix, epsilon, base, nee, changes) = (Mix::Density, None, Base::Paper, false, Changes::NONE);
        Self { sampler, learner, mix, epsilon, base, nee, changes }
    }

    /// Mixes acceptances (Eq. 9).
    pub const fn mixing_acceptances(self) -> Self {
        Self { mix: Mix::Acceptance, ..self }
    }

    /// Fixes the share e.
    pub const fn with_share(self, share: f32) -> Self {
        Self { epsilon: Some(share), ..self }
    }

    /// Changes the settings.
    pub const fn with(self, changes: Changes) -> Self {
        Self { changes, ..self }
    }

    /// Name of the method and of its files, such as `rejection-mix+sarsa` or `product+sarsa-default-nee-steps-even`.
    pub fn name(&self) -> String {
        let mix = if self.mix == Mix::Acceptance { "-acceptance" } else { "" };
        let share = self.epsilon.map(|share| format!("-e{share}")).unwrap_or_default();
        let learner = match self.sampler {
            Sampler::Bsdf => String::new(),
            _ => format!("+{}", word(self.learner)),
        };
        let base = if self.base == Base::Defaults { "-default" } else { "" };
        let nee = if self.nee { "-nee" } else { "" };
        format!("{}{mix}{share}{learner}{base}{nee}{}", word(self.sampler), self.changes.name())
    }

    /// Settings of the method for a scene with these defaults and a picture of this width and height.
    pub fn settings(&self, defaults: Settings, size: [u32; 2]) -> Settings {
        let Self { sampler, learner, mix, epsilon, nee, .. } = *self;
        let base = protocol::settings(self.base, defaults, size);
        let min_uniform = sampler.default_min_uniform();
        let mut settings = Settings { sampler, learner, mix, epsilon, nee, min_uniform, ..base };
        self.changes.apply(&mut settings);
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::{Target, paper};
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};

    #[test]
    fn every_method_is_valid_and_has_a_name_of_its_own() {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        let methods: Vec<_> = [Target::All, Target::Ablation].into_iter().flat_map(Target::methods).collect();
        let mut names: Vec<_> = methods.iter().map(Method::name).collect();
        let mut settings: Vec<_> = Vec::new();
        for method in &methods {
            let own = method.settings(Settings::for_film(&film, &IntegratorDescription::default()), [8, 8]);
            own.validate().expect("a method that can be rendered");
            assert!(!settings.contains(&own), "{} is what another method is", method.name());
            settings.push(own);
        }
        names.sort();
        names.dedup();
        assert_eq!(names.len(), methods.len());
        let fixed = Method::new(Sampler::RejectionMix, Sarsa).with_share(1.0e-4);
        assert_eq!((Method::PLAIN.name(), fixed.name()), ("bsdf".into(), "rejection-mix-e0.0001+sarsa".into()));
    }

    /// Checks that one of our methods stands beside every number of the paper's tables.
    #[test]
    fn methods_stand_in_the_papers_columns() {
        let table1: Vec<_> = METHODS.iter().filter_map(|place| place.table1).collect();
        assert_eq!(table1, ["BRDF", "Quadtree", "ours w/o Rej+", "ours w/o SARSA", "ours", "product"]);
        assert!(table1[..5].iter().all(|column| paper::table1_column(column).is_some()));
        for column in paper::TABLE2_COLUMNS {
            for row in paper::TABLE2 {
                let found = METHODS.iter().filter(|p| p.table2 == Some(column) && p.method.learner == row.learner);
                assert_eq!(found.count(), 1, "{column}, {}", row.name);
            }
        }
    }
}
