//! Reproduction of the paper's tables and figures on any device. Every method renders every scene for the same time;
//! the methods take turns. The results stand beside the numbers of the paper.
//!
//! [`Plan::run`] does all of it. [`methods::METHODS`] lists the methods of Tables 1 and 2, each other target lists its
//! own, and [`paper::SCENES`] lists the scenes. Each result is a JSON file in the output folder. A result that exists
//! already under the same conditions is not measured again.

pub mod ablation;
pub mod changes;
pub mod contest;
pub mod error_map;
pub mod figure1;
pub mod figure6;
pub mod figure7;
mod files;
pub mod methods;
pub mod paper;
pub mod plot;
pub mod protocol;
pub mod record;
pub mod resolution;
pub mod results;
pub mod sheet;
mod stage;
pub mod table1;
pub mod table2;
#[cfg(test)]
mod testing;

use std::path::PathBuf;
use std::sync::Arc;

use crate::gpu::Context;
use crate::{Error, Result};
use methods::Method;
use results::Results;
use stage::SceneStage;

/// Table, figure or experiment to reproduce.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
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
    fn includes(self, other: Self) -> bool {
        self == other || (self == Self::All && other != Self::Ablation)
    }

    /// Methods to measure, each once.
    fn methods(self) -> Vec<Method> {
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

/// Callbacks of a run.
pub struct Watch<'a> {
    /// Whether the user has asked to stop.
    pub stop: &'a dyn Fn() -> bool,
    /// Shows the progress of the run.
    pub show: &'a dyn Fn(&Status),
}

/// Results of a run so far.
#[derive(Default)]
struct Findings {
    results: Results,
    maps: Vec<figure6::MapRecord>,
}

/// Progress of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Status {
    /// Name of the scene, and the work that is being done.
    pub doing: String,
    /// Rendering time of this run so far, in seconds.
    pub done: f64,
    /// Total rendering time of this run, in seconds.
    pub total: f64,
}

impl Plan {
    /// Measures what is missing, and writes the tables after every scene. Returns false if the user has stopped the
    /// run.
    ///
    /// # Errors
    /// Fails if a scene or reference cannot be read, if a file cannot be written, or if the device is lost. Earlier
    /// measurements are kept.
    pub fn run(&self, context: &Arc<Context>, watch: &Watch) -> Result<bool> {
        let names = self.scene_names()?;
        self.check_inputs(&names)?;
        let methods = self.target.methods();
        let maps = if self.target.includes(Target::Figure6) { figure6::methods().len() } else { 0 };
        let mut findings = Findings::default();
        let mut total = self.seconds * ((methods.len() + maps) * names.len()) as f64;
        let mut done = 0.0;
        for name in names {
            let show = |doing: &str, seconds: f64, total: f64| {
                (watch.show)(&Status { doing: format!("{name}: {doing}"), done: seconds, total });
            };
            show("loading", done, total);
            let stage = SceneStage::load(self, name, context)?;
            let (found, missing) = stage.look_up(&methods)?;
            let map = if maps > 0 { stage.look_up_maps() } else { None };
            let needs_map = maps > 0 && map.is_none();
            total -= self.seconds * (found.len() + map.as_ref().map_or(0, |_| maps)) as f64;
            findings.results.0.extend(found);
            findings.maps.extend(map);
            let advanced = |doing: &str, seconds: f64| show(doing, done + seconds, total);
            let Some(measured) = stage.measure(&missing, watch.stop, &advanced)? else { return Ok(false) };
            done += self.seconds * measured.len() as f64;
            findings.results.0.extend(measured);
            if needs_map {
                let advanced = |doing: &str, seconds: f64| show(doing, done + seconds, total);
                let Some(map) = stage.measure_maps(watch.stop, &advanced)? else { return Ok(false) };
                done += self.seconds * maps as f64;
                findings.maps.push(map);
            }
            self.write_tables(&findings, context)?;
        }
        Ok(true)
    }

    fn scene_names(&self) -> Result<Vec<&'static str>> {
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
    fn check_inputs(&self, names: &[&str]) -> Result<()> {
        let files = names.iter().flat_map(|name| [self.scene_file(name), self.reference_file(name)]);
        match files.into_iter().find(|file| !file.is_file()) {
            None => Ok(()),
            Some(file) => Err(Error::Settings(format!(
                "{}: file not found; give the folders with --scenes and --references, or select scenes with --only",
                file.display()
            ))),
        }
    }

    fn scene_file(&self, name: &str) -> PathBuf {
        self.scenes.join(name).join("scene.xml")
    }

    fn reference_file(&self, name: &str) -> PathBuf {
        self.references.join(format!("{name}.mean.exr"))
    }

    fn write_tables(&self, findings: &Findings, context: &Context) -> Result<()> {
        let Findings { results, maps } = findings;
        let writer = files::Writer { out: &self.out, seconds: self.seconds, device: &context.device().name };
        writer.write_records(results)?;
        if self.target.includes(Target::Table1) {
            writer.write_table1(results)?;
        }
        if self.target.includes(Target::Table2) {
            writer.write_table2(results)?;
        }
        if self.target.includes(Target::Figure1) {
            writer.write_figure1(results)?;
        }
        if self.target.includes(Target::Figure6) {
            writer.write_figure6(maps)?;
        }
        if self.target.includes(Target::Figure7) {
            writer.write_figure7(results)?;
        }
        if self.target.includes(Target::Resolution) {
            writer.write_resolution(results)?;
        }
        if self.target.includes(Target::Ablation) {
            writer.write_ablation(results)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
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
