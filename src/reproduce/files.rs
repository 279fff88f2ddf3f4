//! Output files of a run: tables and figures.

use std::path::Path;

use super::figure6::MapRecord;
use super::methods::Method;
use super::record::Record;
use super::results::Results;
use super::sheet::{self, Sheet};
use super::{ablation, figure1, figure6, figure7, resolution, table1, table2};
use crate::Result;
use crate::image::{ToneCurve, exr, png};
use crate::reproduce::paper::PATH_VERTEX_BYTES;

/// Writer of the output files: the folder, and the conditions that the captions state.
pub(super) struct Writer<'a> {
    pub out: &'a Path,
    pub seconds: f64,
    pub device: &'a str,
}

impl Writer<'_> {
    fn write(&self, name: &str, text: &str) -> Result<()> {
        sheet::write(&self.out.join(name), text)
    }

    /// Writes every measurement, one per line.
    pub fn write_records(&self, results: &Results) -> Result<()> {
        self.write("measurements.csv", &records(results).csv())
    }

    pub fn write_table1(&self, results: &Results) -> Result<()> {
        let sheet = table1::sheet(results);
        let count = results.scenes(&table1::methods()).len();
        let title = "Table 1: error of the displayed image (MAE) at equal time";
        self.write("table1.csv", &sheet.csv())?;
        self.write("table1.md", &format!("# {title}\n\n{}\n{}", self.caption(count), sheet.markdown()))
    }

    pub fn write_table2(&self, results: &Results) -> Result<()> {
        let count = results.scenes(&table2::methods()).len();
        let parts = [
            ("mae", "Error of the displayed image (MAE) at equal time", table2::mae(results)),
            ("ms", "Time per sample", table2::milliseconds(results)),
            ("mae-equal-spp", "MAE at equal samples on each scene", table2::mae_of_equal_samples(results)),
            ("invalid", "Samples below the surface", table2::invalid_rates(results)),
            ("tries", "Proposals per guided sample", table2::tries(results)),
        ];
        let mut text = format!("# Table 2: every sampler with every learner\n\n{}", self.caption(count));
        for (name, title, sheet) in parts {
            self.write(&format!("table2-{name}.csv"), &sheet.csv())?;
            text += &format!("\n## {title}\n\n{}", sheet.markdown());
        }
        self.write("table2.md", &text)
    }

    /// Writes a strip for each scene, from the pictures that are stored beside the records.
    pub fn write_figure1(&self, results: &Results) -> Result<()> {
        let methods = figure1::methods();
        for scene in results.scenes(&methods) {
            let folder = self.out.join(scene.name);
            let picture = |method: &Method| exr::read_rgb(&folder.join(format!("{}.exr", method.name())));
            let mut pictures = methods.iter().map(picture).collect::<Result<Vec<_>>>()?;
            pictures.push(exr::read_rgb(&folder.join("reference.exr"))?);
            let (corner, side) = figure1::worst_window(&pictures[0], &pictures[pictures.len() - 1]);
            let strip = figure1::strip(&pictures, corner, side);
            png::write(&self.out.join(format!("figure1-{}.png", scene.name)), &strip, ToneCurve::Paper, 0.0)?;
        }
        let sheet = figure1::sheet(results);
        let text = "# Figure 1: insets at equal time\n\nEach strip shows these methods from left to right, then the reference. \
                    The inset is the square in which the first picture differs most from the reference. The MAE is that of \
                    the whole picture.\n\n";
        self.write("figure1.csv", &sheet.csv())?;
        self.write("figure1.md", &format!("{text}{}\n{}", self.conditions(), sheet.markdown()))
    }

    pub fn write_figure6(&self, maps: &[MapRecord]) -> Result<()> {
        let sheet = figure6::sheet(maps);
        let text = "# Figure 6: learned radiance at one point\n\nThe error is the mean absolute difference from the truth over \
                    directions above the surface, relative to the truth's mean there.\n\n";
        self.write("figure6.csv", &sheet.csv())?;
        self.write("figure6.md", &format!("{text}{}\n{}", self.conditions(), sheet.markdown()))
    }

    pub fn write_figure7(&self, results: &Results) -> Result<()> {
        self.write("figure7a.csv", &figure7::steps_sheet(results).csv())?;
        self.write("figure7bc.csv", &figure7::shares_sheet(results).csv())?;
        figure7::plots(results).iter().try_for_each(|(name, plot)| self.write(name, &plot.svg()?))
    }

    pub fn write_resolution(&self, results: &Results) -> Result<()> {
        let text = "# Resolution of the grids\n\nError of the displayed image (MAE) at equal time, relative to that at the paper's \
                    resolution: 8 cells along each axis (grid), 16 x 16 direction bins.\n\n";
        let sheet = resolution::sheet(results);
        self.write("resolution.csv", &resolution::measurements(results).csv())?;
        self.write("resolution.md", &format!("{text}{}\n{}", self.conditions(), sheet.markdown()))
    }

    pub fn write_ablation(&self, results: &Results) -> Result<()> {
        let Self { seconds, device, .. } = self;
        let count = results.scenes(&ablation::methods()).len();
        let mut text = format!(
            "# Effect of each part of the default guide\n\nMeasured on {device} with {seconds} s per picture, at most 16 \
             edges, and Russian roulette after 8 edges. Settings that a row does not name have their defaults. Errors are those \
             of the displayed image (MAE) at equal time. Means are geometric and over {count} of 12 scenes.\n"
        );
        for (nee, title) in [(false, "off"), (true, "on")] {
            text += &format!("\n## Emitter sampling {title}\n\n{}", ablation::sheet(results, nee).markdown());
        }
        self.write("ablation.csv", &ablation::measurements(results).csv())?;
        self.write("ablation.md", &text)
    }

    fn caption(&self, scenes: usize) -> String {
        format!(
            "{}Means are over {scenes} of 12 scenes. The paper's means stand in parentheses. They are over the same scenes, or \
             over all 12 where the paper does not list each scene (40 s per picture on an NVIDIA GPU with OptiX).\n",
            self.conditions()
        )
    }

    fn conditions(&self) -> String {
        let Self { seconds, device, .. } = self;
        format!(
            "Measured on {device} with {seconds} s per picture, no emitter sampling, at most 16 edges, and Russian roulette \
             after 8 edges.\n"
        )
    }
}

fn records(results: &Results) -> Sheet {
    let header = "scene method width height seconds spp ms_per_sample mae_ldr mae mse relmse relmse_trim mean_ratio \
                  light_hit_rate invalid_rate tries_per_sample rays guide_bytes path_bytes_per_ray paper_path_bytes_per_ray";
    let mut sheet = Sheet::new(header.split_whitespace());
    for record in &results.0 {
        sheet.push(cells(record));
    }
    sheet
}

fn cells(record: &Record) -> Vec<String> {
    let Record { errors, counts, memory, .. } = record;
    let depth = record.conditions.settings["max_depth"].as_u64().unwrap_or_default();
    let paper_bytes = if memory.path_bytes > 0 { PATH_VERTEX_BYTES * depth } else { 0 };
    let whole = [record.width, record.height].map(|side| side.to_string());
    let times = [record.seconds, f64::from(record.spp), record.ms_per_sample()];
    let errors = [errors.mae_ldr, errors.mae, errors.mse, errors.relmse, errors.relmse_trim, errors.mean_ratio];
    let rates = [counts.light_hit_rate(), counts.invalid_rate(), counts.tries_per_sample()];
    let bytes = [counts.rays, memory.guide_bytes, memory.path_bytes, paper_bytes];
    let numbers = times.into_iter().chain(errors).chain(rates).map(|number| number.to_string());
    let names = [record.scene.clone(), record.method.clone()];
    names.into_iter().chain(whole).chain(numbers).chain(bytes.map(|bytes| bytes.to_string())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::testing::record;

    #[test]
    fn tables_are_written_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let all = table1::methods().into_iter().chain(table2::methods());
        let results = Results(all.map(|method| record("kitchen", &method, 0.02)).collect());
        let writer = Writer { out: folder.path(), seconds: 40.0, device: "a device" };
        writer.write_records(&results).expect("written");
        writer.write_table1(&results).expect("written");
        writer.write_table2(&results).expect("written");
        let swept = figure7::methods().iter().map(|method| record("kitchen", method, 0.02)).collect();
        writer.write_figure7(&Results(swept)).expect("written");
        let fine = resolution::methods().iter().map(|method| record("kitchen", method, 0.02)).collect();
        writer.write_resolution(&Results(fine)).expect("written");
        let changed = ablation::methods().iter().map(|method| record("kitchen", method, 0.02)).collect();
        writer.write_ablation(&Results(changed)).expect("written");
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
        let lines: Vec<_> = read("measurements.csv").lines().map(|line| line.split(',').count()).collect();
        assert_eq!(lines.len(), results.0.len() + 1);
        assert!(lines.iter().all(|&count| count == lines[0]), "{lines:?}");
        assert!(read("table1.md").contains("over 1 of 12 scenes") && read("table1.csv").contains("kitchen"));
        assert_eq!(read("table2.md").matches("\n## ").count(), 5);
        assert!(read("figure7a-kitchen.svg").contains("polyline") && read("figure7bc.csv").contains("kitchen"));
        assert!(
            read("resolution.md").contains("| kitchen | 1.000") && read("resolution.csv").contains("kitchen,16,32,")
        );
        assert_eq!(read("ablation.md").matches("| `product` | 1.000 | 1.000 |").count(), 2);
        assert!(
            read("ablation.md").contains("over 1 of 12 scenes") && read("ablation.csv").contains("kitchen,on,bsdf,")
        );
        assert!(read("table2-mae.csv").contains("\"sphere, inversion\""));
    }
}
