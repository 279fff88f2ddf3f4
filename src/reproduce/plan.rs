//! What a run measures, and where its files lie.

use std::path::PathBuf;

use strum::{EnumMessage, IntoStaticStr, VariantArray};

use super::methods::Method;
use super::{ablation, figure1, figure7, paper, resolution, table1, table2};
use crate::{Error, Result};

/// Table, figure or experiment to reproduce.
#[derive(Debug, Clone, Copy, PartialEq, Eq, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Target {
    /// Table 1: errors of the main methods on every scene at equal time.
    Table1,
    /// Table 2: every sampler with every learner.
    Table2,
    /// Figure 1: one inset of the pictures of Table 1's methods.
    Figure1,
    /// Figure 6: radiance that each learner has learned at a point, beside the truth.
    Figure6,
    /// Figure 7: light hits as learning proceeds, and the effect of a fixed share of uniform directions.
    Figure7,
    /// Method of the paper with coarser and finer grids.
    Resolution,
    /// Effect of each part of the default guide. Not in the paper, and not included in `all`.
    Ablation,
    /// All targets except `ablation`.
    All,
}

impl Target {
    pub(super) fn includes(self, other: Self) -> bool {
        self == other || (self == Self::All && other != Self::Ablation)
    }

    /// Methods to measure, each once.
    pub(super) fn methods(self) -> Vec<Method> {
        let mut methods = Vec::new();
        let all = [
            (Self::Table1, table1::methods()),
            (Self::Table2, table2::methods()),
            (Self::Figure1, figure1::methods()),
            (Self::Figure7, figure7::methods()),
            (Self::Resolution, resolution::methods()),
            (Self::Ablation, ablation::methods()),
        ];
        for (target, own) in all {
            if self.includes(target) {
                methods.extend(own);
            }
        }
        let mut unique: Vec<Method> = Vec::new();
        methods.into_iter().for_each(|method| {
            if !unique.contains(&method) {
                unique.push(method)
            }
        });
        unique
    }
}

/// Plan of a run: the measurements to make, their inputs and the output folder.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Target to reproduce.
    pub target: Target,
    /// Folder of the scenes: `NAME/scene.xml`.
    pub scenes: PathBuf,
    /// Folder of the references: `NAME.mean.exr`.
    pub references: PathBuf,
    /// Rendering time of each method on each scene, in seconds.
    pub seconds: f64,
    /// Size of the pictures relative to the references; `None` chooses it by speed.
    pub scale: Option<f32>,
    /// Names of the scenes; all scenes of the paper if empty.
    pub only: Vec<String>,
    /// Output folder.
    pub out: PathBuf,
}

impl Plan {
    pub(super) fn scene_names(&self) -> Result<Vec<&'static str>> {
        let all = || paper::SCENES.iter().map(|scene| scene.name);
        if let Some(unknown) = self.only.iter().find(|only| !all().any(|name| name == **only)) {
            let known = all().collect::<Vec<_>>().join(", ");
            return Err(Error::Settings(format!(
                "--only {unknown}: the paper has no such scene; its scenes are {known}"
            )));
        }
        Ok(all().filter(|name| self.only.is_empty() || self.only.iter().any(|only| only == name)).collect())
    }

    /// Checks that all input files exist. Otherwise hours may pass before a missing one is noticed.
    pub(super) fn check_inputs(&self, names: &[&str]) -> Result<()> {
        let files = names.iter().flat_map(|name| [self.scene_file(name), self.reference_file(name)]);
        match files.into_iter().find(|file| !file.is_file()) {
            None => Ok(()),
            Some(file) => Err(Error::Settings(format!(
                "{}: file not found; give the folders with --scenes and --references, or select scenes with --only",
                file.display()
            ))),
        }
    }

    pub(super) fn scene_file(&self, name: &str) -> PathBuf {
        self.scenes.join(name).join("scene.xml")
    }

    pub(super) fn reference_file(&self, name: &str) -> PathBuf {
        self.references.join(format!("{name}.mean.exr"))
    }
}

#[cfg(test)]
mod tests {
    use super::super::methods;
    use super::*;

    fn plan(only: &[&str]) -> Plan {
        Plan {
            target: Target::All,
            scenes: "scenes".into(),
            references: "references".into(),
            seconds: 1.0,
            scale: None,
            only: only.iter().map(|&name| name.into()).collect(),
            out: "out".into(),
        }
    }

    #[test]
    fn every_method_is_measured_once() {
        let figures = [Target::Figure1, Target::Figure6, Target::Figure7];
        assert_eq!(figures.map(|target| target.methods().len()), [6, 0, 3 + 3 * methods::SHARES.len()]);
        let counts = [Target::Table1, Target::Table2, Target::All];
        let shares = 3 * methods::SHARES.len();
        assert_eq!([Target::Resolution, Target::Ablation].map(|target| target.methods().len()), [9, 34]);
        // One of the nine resolutions is a method of Table 1. The ablation is not included in `All`.
        let all = methods::METHODS.len() + shares + 8;
        assert_eq!(counts.map(|target| target.methods().len()), [6, 18, all]);
    }

    #[test]
    fn scenes_are_the_papers() {
        assert_eq!(plan(&[]).scene_names().expect("names").len(), 12);
        assert_eq!(plan(&["kitchen", "bathroom"]).scene_names().expect("names"), ["bathroom", "kitchen"]);
        let error = plan(&["attic"]).scene_names().expect_err("a refusal").to_string();
        assert!(error.contains("--only attic") && error.contains("veach-ajar-2"), "{error}");
    }
}
