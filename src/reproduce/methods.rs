//! Every way to render that the tables compare.

use super::changes::{Changes, word};
use super::protocol::{self, Base};
use crate::settings::{Learner, Mix, Sampler, Settings};

/// How directions are sampled and learned, and with which settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Method {
    /// The sampler.
    pub sampler: Sampler,
    /// The learner.
    pub learner: Learner,
    /// What `rejection-mix` mixes.
    pub mix: Mix,
    /// The share e of `rejection-mix`; the optimal one where `None`.
    pub epsilon: Option<f32>,
    /// Where all else comes from.
    pub base: Base,
    /// Whether emitters are sampled.
    pub nee: bool,
    /// What it changes of that.
    pub changes: Changes,
}

/// A method's places in the tables, by the names of the paper's columns, or of ours where it has none.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// The method.
    pub method: Method,
    /// Its column in Table 1.
    pub table1: Option<&'static str>,
    /// Its sampler's column in Table 2; its learner is the row.
    pub table2: Option<&'static str>,
}

const SPHERE: Option<&str> = Some("sphere, inversion");
const HEMISPHERE: Option<&str> = Some("hemisphere, inversion");
const REJECTION: Option<&str> = Some("hemisphere, rejection");
const REJECTION_MIX: Option<&str> = Some("hemisphere, Rej+");
/// Eq. 9, which the paper states beside Eq. 8 and has no column for.
const ACCEPTANCE: Option<&str> = Some("hemisphere, Rej+ of acceptances");

/// Beyond the paper.
const PRODUCT: Option<&str> = Some("product");

use Learner::{ExpectedSarsa, MonteCarlo, Sarsa};

/// The methods of Tables 1 and 2. A line here is all that another one needs.
pub const METHODS: [Place; 20] = [
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

/// Shares e of Figure 7b and 7c.
pub const SHARES: [f32; 7] = [1.0e-4, 1.0e-3, 1.0e-2, 0.1, 0.25, 0.5, 1.0];

const fn place(method: Method, table1: Option<&'static str>, table2: Option<&'static str>) -> Place {
    Place { method, table1, table2 }
}

impl Method {
    /// A plain path tracer.
    pub const PLAIN: Self = Self::new(Sampler::Bsdf, Sarsa);

    /// A sampler with a learner.
    pub const fn new(sampler: Sampler, learner: Learner) -> Self {
        let (mix, epsilon, base, nee, changes) = (Mix::Density, None, Base::Paper, false, Changes::NONE);
        Self { sampler, learner, mix, epsilon, base, nee, changes }
    }

    /// By Eq. 9.
    pub const fn mixing_acceptances(self) -> Self {
        Self { mix: Mix::Acceptance, ..self }
    }

    /// With a fixed share e.
    pub const fn with_share(self, share: f32) -> Self {
        Self { epsilon: Some(share), ..self }
    }

    /// With other settings.
    pub const fn with(self, changes: Changes) -> Self {
        Self { changes, ..self }
    }

    /// Its name, also of its files: `rejection-mix+sarsa`, `product+sarsa-default-nee-steps-even`.
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

    /// Its settings on a scene with these defaults, for a picture of this width and height.
    pub fn settings(&self, defaults: Settings, size: [u32; 2]) -> Settings {
        let Self { sampler, learner, mix, epsilon, nee, .. } = *self;
        let base = protocol::settings(self.base, defaults, size);
        let mut settings = Settings { sampler, learner, mix, epsilon, nee, ..base };
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

    /// Every figure of the paper's tables has one of ours beside it.
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
