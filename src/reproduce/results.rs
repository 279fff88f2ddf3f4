//! Results of a run: its records, and means over its scenes.

use super::methods::Method;
use super::paper::{PaperScene, SCENES};
use super::record::Record;

/// Records of a run, in any order.
#[derive(Debug, Clone, Default)]
pub struct Results(pub Vec<Record>);

impl Results {
    /// Record of a method on a scene.
    pub fn of(&self, scene: &str, method: &Method) -> Option<&Record> {
        let name = method.name();
        self.0.iter().find(|record| record.scene == scene && record.method == name)
    }

    /// Scenes that were measured with all of these methods. Means over different sets of scenes could not be compared.
    pub fn scenes(&self, methods: &[Method]) -> Vec<PaperScene> {
        let is_whole = |scene: &&PaperScene| methods.iter().all(|method| self.of(scene.name, method).is_some());
        SCENES.iter().filter(is_whole).copied().collect()
    }

    /// Records of a method on some scenes.
    fn on(&self, scenes: &[PaperScene], method: &Method) -> impl Iterator<Item = &Record> {
        scenes.iter().filter_map(|scene| self.of(scene.name, method))
    }

    /// Mean of a number over scenes.
    pub fn mean(&self, scenes: &[PaperScene], method: &Method, number: impl Fn(&Record) -> f64) -> f64 {
        let values: Vec<_> = self.on(scenes, method).map(number).collect();
        values.iter().sum::<f64>() / values.len() as f64
    }

    /// Geometric mean of the ratio of a method's error to another's.
    pub fn ratio(&self, scenes: &[PaperScene], method: &Method, to: &Method, number: impl Fn(&Record) -> f64) -> f64 {
        let logarithms = self.on(scenes, method).zip(self.on(scenes, to)).map(|(a, b)| (number(a) / number(b)).ln());
        (logarithms.sum::<f64>() / scenes.len() as f64).exp()
    }
}

/// Geometric mean over scenes of the ratio of two of the paper's columns.
pub fn paper_ratio(scenes: &[PaperScene], column: usize, to: usize) -> f64 {
    let sum: f64 = scenes.iter().map(|scene| (scene.mae[column] / scene.mae[to]).ln()).sum();
    (sum / scenes.len() as f64).exp()
}

/// Mean over scenes of one of the paper's columns.
pub fn paper_mean(scenes: &[PaperScene], column: usize) -> f64 {
    scenes.iter().map(|scene| scene.mae[column]).sum::<f64>() / scenes.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the ratios that follow from the paper's own table.
    #[test]
    fn the_papers_ratios() {
        assert!((paper_ratio(&SCENES, 4, 0) - 0.82).abs() < 0.005);
        assert!((paper_ratio(&SCENES, 4, 1) - 0.99).abs() < 0.005);
        assert!((paper_mean(&SCENES, 0) - 0.0366).abs() < 5.0e-5);
    }
}
