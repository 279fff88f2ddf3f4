//! Resolution of the guide: the paper's method with fewer and with more cells and direction bins than in the paper.

use super::changes::Changes;
use super::methods::Method;
use super::protocol;
use super::record::Record;
use super::results::Results;
use super::sheet::Sheet;
use crate::settings::{Learner, Sampler};

/// Cells along each axis of the grid.
const GRIDS: [u32; 3] = [4, 8, 16];
/// Direction bins along each side of the map.
const DIRECTIONS: [u32; 3] = [8, 16, 32];
/// Method of the paper at the paper's resolution.
const PAPER: Method = Method::new(Sampler::RejectionMix, Learner::Sarsa);

/// Resolution, and the paper's method at this resolution.
#[derive(Clone, Copy)]
struct Resolution {
    grid: u32,
    directions: u32,
    method: Method,
}

impl Resolution {
    fn new(grid: u32, directions: u32) -> Self {
        let method = match (grid, directions) {
            (protocol::GRID, protocol::DIRECTIONS) => PAPER,
            _ => PAPER.with(Changes { grid: Some(grid), directions: Some(directions), ..Changes::NONE }),
        };
        Self { grid, directions, method }
    }
}

fn resolutions() -> impl Iterator<Item = Resolution> {
    GRIDS.into_iter().flat_map(|grid| DIRECTIONS.map(|directions| Resolution::new(grid, directions)))
}

/// Methods that the experiment compares.
pub fn methods() -> Vec<Method> {
    resolutions().map(|resolution| resolution.method).collect()
}

/// Table of each scene's errors relative to those at the paper's resolution, and of the cost of each resolution.
pub fn sheet(results: &Results) -> Sheet {
    let names =
        resolutions().map(|Resolution { grid, directions, .. }| format!("grid {grid}, directions {directions}"));
    let mut sheet = Sheet::new(["scene".to_owned()].into_iter().chain(names));
    let scenes = results.scenes(&methods());
    for scene in &scenes {
        let only = std::slice::from_ref(scene);
        let cells = methods().into_iter().map(|method| format!("{:.3}", results.ratio(only, &method, &PAPER, error)));
        sheet.push([scene.name.to_owned()].into_iter().chain(cells));
    }
    if scenes.is_empty() {
        return sheet;
    }
    let mut summary = |title: &str, cell: &dyn Fn(&Method) -> String| {
        sheet.push([format!("**{title}**")].into_iter().chain(methods().iter().map(cell)));
    };
    summary("geometric mean", &|method| format!("{:.3}", results.ratio(&scenes, method, &PAPER, error)));
    summary("time per sample, relative, geometric mean", &|method| {
        format!("{:.2}", results.ratio(&scenes, method, &PAPER, Record::ms_per_sample))
    });
    summary("memory of the guide (MiB)", &|method| {
        format!("{:.2}", results.mean(&scenes, method, |record| mebibytes(record.memory.guide_bytes)))
    });
    sheet
}

/// Measurements behind [`sheet`], one line per scene and resolution.
pub fn measurements(results: &Results) -> Sheet {
    let header = "scene grid directions mae_ldr relative_mae_ldr mse spp ms_per_sample guide_bytes";
    let mut sheet = Sheet::new(header.split_whitespace());
    for scene in results.scenes(&methods()) {
        for Resolution { grid, directions, method } in resolutions() {
            let Some(record) = results.of(scene.name, &method) else { continue };
            let relative = results.ratio(&[scene], &method, &PAPER, error);
            let errors = [record.errors.mae_ldr, relative, record.errors.mse].map(|number| number.to_string());
            let place = [scene.name.to_owned(), grid.to_string(), directions.to_string()];
            let cost =
                [record.spp.to_string(), record.ms_per_sample().to_string(), record.memory.guide_bytes.to_string()];
            sheet.push(place.into_iter().chain(errors).chain(cost));
        }
    }
    sheet
}

fn error(record: &Record) -> f64 {
    record.errors.mae_ldr
}

fn mebibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::testing::record;

    #[test]
    fn the_papers_resolution_is_the_method_of_table_1() {
        let names: Vec<_> = methods().iter().map(Method::name).collect();
        assert_eq!((names.len(), &names[4][..]), (9, "rejection-mix+sarsa"));
        assert_eq!([&names[2], &names[7]], ["rejection-mix+sarsa-g4-d32", "rejection-mix+sarsa-g16-d16"]);
        assert!(crate::reproduce::table1::methods().contains(&methods()[4]));
    }

    #[test]
    fn errors_are_relative_to_the_papers_resolution() {
        let mut records = Vec::new();
        for (place, method) in methods().iter().enumerate() {
            records.push(record("cornell-box", method, 0.01 * (place + 1) as f64));
            records.push(record("kitchen", method, if place == 0 { 0.4 } else { 0.1 }));
            // This scene lacks some methods, so it must have no row and must not enter any mean.
            if place < 3 {
                records.push(record("staircase", method, 0.5));
            }
        }
        let results = Results(records);
        let markdown = sheet(&results).markdown();
        let line = |begin: &str| markdown.lines().find(|line| line.starts_with(begin)).expect("a line").to_owned();
        assert_eq!(markdown.lines().count(), 2 + 2 + 3, "{markdown}");
        assert!(line("| cornell-box").starts_with("| cornell-box | 0.200 | 0.400 | 0.600 | 0.800 | 1.000 | 1.200 |"));
        assert!(line("| kitchen").starts_with("| kitchen | 4.000 | 1.000 |"), "{markdown}");
        // The geometric means are the square roots of 0.2 x 4 and of 0.4 x 1.
        assert!(line("| **geometric mean**").starts_with("| **geometric mean** | 0.894 | 0.632 |"), "{markdown}");
        assert!(line("| **memory").contains("| 1.00 | 1.00 |"), "{markdown}");
        let csv = measurements(&results).csv();
        assert_eq!(csv.lines().count(), 1 + 2 * 9);
        assert!(csv.contains("\nkitchen,4,8,0.4,4") && csv.contains(",16,62.5,1048576\n"), "{csv}");
    }

    #[test]
    fn nothing_measured_is_an_empty_table() {
        assert_eq!(sheet(&Results::default()).markdown().lines().count(), 2);
    }
}
