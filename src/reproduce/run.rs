//! A run from its first scene to its last table.

use std::sync::Arc;

use super::plan::{Plan, Target};
use super::results::Results;
use super::stage::SceneStage;
use super::{figure6, files};
use crate::Result;
use crate::gpu::Context;

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
    /// Number of scenes that are finished.
    pub finished: usize,
    /// Number of scenes in all.
    pub scenes: usize,
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
        let scenes = names.len();
        for (finished, name) in names.into_iter().enumerate() {
            let show = |doing: &str, seconds: f64, total: f64| {
                let doing = format!("{name}: {doing}");
                (watch.show)(&Status { doing, done: seconds, total, finished, scenes });
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
