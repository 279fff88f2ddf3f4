//! What a run measures, and where its files lie.

use std::path::PathBuf;

use super::methods::Method;
use super::{ablation, figure1, figure7, paper, resolution, table1, table2};
use crate::{Error, Result};

/// What can be reproduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// The errors of the main methods on every scene at equal time.
    Table1,
    /// Every sampler with every learner.
    Table2,
    /// The same inset of the pictures of Table 1's methods.
    Figure1,
    /// The radiance that each learner has learned at a point, beside the truth.
    Figure6,
    /// Light hits as learning goes on, and what a fixed share of uniform directions does.
    Figure7,
    /// The paper's method with coarser and finer grids.
    Resolution,
    /// Beyond the paper, and not a part of `all`: what each part of the default guide brings.
    Ablation,
    /// All of these but `ablation`.
    All,
}

impl Target {
    pub(super) fn includes(self, other: Self) -> bool {
        self == other || (self == Self::All && other != Self::Ablation)
    }

    /// The methods to measure, each once.
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

/// What is to be measured, and where it goes.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What to reproduce.
    pub target: Target,
    /// Folder of the scenes: `NAME/scene.xml`.
    pub scenes: PathBuf,
    /// Folder of the references: `NAME.mean.exr`.
    pub references: PathBuf,
    /// Seconds of rendering for each method on each scene.
    pub seconds: f64,
    /// Pictures' size relative to the reference's; chosen by speed where `None`.
    pub scale: Option<f32>,
    /// Names of the scenes; all of the paper's where empty.
    pub only: Vec<String>,
    /// Where results go.
    pub out: PathBuf,
}

impl Plan {
    pub(super) fn scene_names(&self) -> Result<Vec<&'static str>> {
        let all = || paper::SCENES.iter().map(|scene| scene.name);
        if let Some(unknown) = self.only.iter().find(|only| !all().any(|name| name == **only)) {
            let known = all().collect::<Vec<_>>().join(", ");
            return Err(Error::Settings(format!("--only {unknown}: the paper has no such scene; it has {known}")));
        }
        Ok(all().filter(|name| self.only.is_empty() || self.only.iter().any(|only| only == name)).collect())
    }

    /// Hours may pass before the last scene is needed.
    pub(super) fn check_inputs(&self, names: &[&str]) -> Result<()> {
        let files = names.iter().flat_map(|name| [self.scene_file(name), self.reference_file(name)]);
        match files.into_iter().find(|file| !file.is_file()) {
            None => Ok(()),
            Some(file) => Err(Error::Settings(format!(
                "{}: there is no such file; name the folders with --scenes and --references, and the scenes to take with --only",
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
        assert_eq!([Target::Resolution, Target::Ablation].map(|target| target.methods().len()), [9, 32]);
        // One of the resolutions is a method of Table 1; the ablation is no part of all.
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
