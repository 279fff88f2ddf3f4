//! Figure 6: the radiance that each learner has learned at one point, at a higher directional resolution, beside the
//! truth.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::changes::word;
use super::contest::Entrant;
use super::methods::Method;
use super::paper::TABLE2;
use super::record::Conditions;
use super::sheet::Sheet;
use super::stage::SceneStage;
use crate::film::{self, Picture};
use crate::image::{ToneCurve, png};
use crate::radiance_map::{MappedScene, SurfacePoint, false_colors, relative_error};
use crate::settings::{Sampler, Settings};
use crate::{Result, files};

/// Direction bins along each side of the map: twice the default.
const DIRECTIONS: u32 = 32;
/// Samples per pixel of each of the six views from which the true radiance is computed.
const TRUE_SPP: u32 = 64;
/// Candidate positions on the film, as fractions of its sides. The first one at which a surface is visible is used.
const MARKS: [[f32; 2]; 4] = [[0.5, 0.5], [0.5, 0.75], [0.25, 0.75], [0.75, 0.75]];

/// Radiance that the learners have learned at a point of one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapRecord {
    /// Conditions of the measurement. The settings are those of the first learner.
    pub conditions: Conditions,
    /// Name of the scene.
    pub scene: String,
    /// Pixel whose center shows the point.
    pub pixel: [u32; 2],
    /// Maps of the learners, in the order of Table 2.
    pub learners: Vec<LearnedMap>,
}

/// Map of one learner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedMap {
    /// Name of the learner.
    pub learner: String,
    /// Mean absolute difference from the truth over the bins above the surface, relative to the truth's mean there.
    pub relative_error: f64,
    /// Samples per pixel from which the learner has learned.
    pub spp: u32,
    /// Milliseconds per sample per pixel.
    pub ms_per_sample: f64,
}

/// Methods that the figure compares.
pub fn methods() -> Vec<Method> {
    TABLE2.iter().map(|row| Method::new(Sampler::RejectionMix, row.learner)).collect()
}

/// Table with one row per scene: error and time per sample of each learner.
pub fn sheet(records: &[MapRecord]) -> Sheet {
    let columns = TABLE2.iter().flat_map(|row| [format!("{}: error", row.name), format!("{}: ms", row.name)]);
    let mut sheet = Sheet::new(["scene".to_owned(), "pixel".into()].into_iter().chain(columns));
    for record in records {
        let [x, y] = record.pixel;
        let cell = |map: &LearnedMap| [format!("{:.4}", map.relative_error), format!("{:.2}", map.ms_per_sample)];
        let cells = record.learners.iter().flat_map(cell);
        sheet.push([record.scene.clone(), format!("{x},{y}")].into_iter().chain(cells));
    }
    sheet
}

impl SceneStage<'_> {
    /// Record of an earlier run under the same conditions, if there is one.
    pub fn look_up_maps(&self) -> Option<MapRecord> {
        let text = fs::read_to_string(self.file("figure6.json")).ok()?;
        let record: MapRecord = serde_json::from_str(&text).ok()?;
        (record.conditions == self.map_conditions()).then_some(record)
    }

    /// Learns with each learner, and writes maps and record. Returns `None` if the user has stopped the run.
    pub fn measure_maps(&self, stop: &dyn Fn() -> bool, advanced: &dyn Fn(&str, f64)) -> Result<Option<MapRecord>> {
        advanced("the true radiance at a point", 0.0);
        let settings = self.map_settings(&methods()[0]);
        let place = self.place();
        let (pixel, point) = mark(&place, &settings)?;
        let truth = place.true_radiance(&settings, &point, TRUE_SPP)?;
        write_map(&self.file("figure6-truth"), &truth)?;
        let entering: Vec<_> = methods().iter().map(|method| (*method, self.map_settings(method))).collect();
        let learned = |entrant: &Entrant| {
            let map = entrant.radiance_at(point.position)?;
            let learner = word(entrant.method.learner);
            write_map(&self.file(&format!("figure6-{learner}")), &map)?;
            Ok(LearnedMap {
                learner,
                relative_error: relative_error(&map, &truth, &settings, point.normal),
                spp: entrant.spp,
                ms_per_sample: 1000.0 * entrant.seconds / f64::from(entrant.spp.max(1)),
            })
        };
        let Some(learners) = self.contest(entering, stop, advanced, &learned)? else { return Ok(None) };
        let record = MapRecord { conditions: self.map_conditions(), scene: self.name().into(), pixel, learners };
        files::write_json(&self.file("figure6.json"), &record)?;
        Ok(Some(record))
    }

    fn map_settings(&self, method: &Method) -> Settings {
        Settings { directions: DIRECTIONS, ..self.settings(method) }
    }

    fn map_conditions(&self) -> Conditions {
        self.conditions(&self.map_settings(&methods()[0]))
    }
}

/// First candidate position at which a surface is visible, or the error at the last one.
fn mark(place: &MappedScene, settings: &Settings) -> Result<([u32; 2], SurfacePoint)> {
    let at = |mark: [f32; 2]| {
        let pixel = [(mark[0] * settings.width as f32) as u32, (mark[1] * settings.height as f32) as u32];
        place.visible_point(settings, pixel).map(|point| (pixel, point))
    };
    let [first, others @ ..] = MARKS;
    others.into_iter().fold(at(first), |found, mark| found.or_else(|_| at(mark)))
}

fn write_map(stem: &Path, map: &[f32]) -> Result<()> {
    let radiance = map.iter().map(|&value| [value; 3]).collect();
    let size = [DIRECTIONS; 2];
    let picture = Picture { radiance, ..Picture::empty(DIRECTIONS, DIRECTIONS, [0, 0], size) };
    film::write_picture(&stem.with_extension("exr"), &picture, &[])?;
    png::write(&stem.with_extension("png"), &false_colors(map, DIRECTIONS), ToneCurve::Srgb, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::testing::record;

    #[test]
    fn a_row_has_every_learner() {
        let map =
            |learner: &str| LearnedMap { learner: learner.into(), relative_error: 0.25, spp: 8, ms_per_sample: 1.5 };
        let conditions = record("kitchen", &methods()[0], 0.1).conditions;
        let learners = methods().iter().map(|method| map(&word(method.learner))).collect();
        let records = [MapRecord { conditions, scene: "kitchen".into(), pixel: [4, 2], learners }];
        let markdown = sheet(&records).markdown();
        assert!(
            markdown.ends_with("| kitchen | 4,2 | 0.2500 | 1.50 | 0.2500 | 1.50 | 0.2500 | 1.50 |\n"),
            "{markdown}"
        );
    }
}
