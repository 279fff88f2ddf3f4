//! Table 1: the errors of the paper's methods, and of the product sampler, on every scene at equal time.

use super::methods::{METHODS, Method};
use super::paper::{PaperScene, TABLE1_INVALID, TABLE1_MS, TABLE1_SPP, table1_column};
use super::record::Record;
use super::results::{Results, paper_mean, paper_ratio};
use super::sheet::Sheet;

/// Column of the table: the method, its name in the paper, and its index in the paper's table.
#[derive(Clone, Copy)]
struct Column {
    method: Method,
    name: &'static str,
    paper: Option<usize>,
}

fn columns() -> Vec<Column> {
    let column = |name| move |method| Column { method, name, paper: table1_column(name) };
    METHODS.iter().filter_map(|place| place.table1.map(|name| column(name)(place.method))).collect()
}

/// Methods that the table compares.
pub fn methods() -> Vec<Method> {
    columns().into_iter().map(|column| column.method).collect()
}

/// Our number, followed by the paper's number in parentheses if it has one.
fn beside(ours: f64, paper: Option<f64>, digits: usize) -> String {
    match paper {
        Some(paper) => format!("{ours:.digits$} ({paper:.digits$})"),
        None => format!("{ours:.digits$}"),
    }
}

/// Table of the completely measured scenes. The paper's numbers stand in parentheses.
pub fn sheet(results: &Results) -> Sheet {
    let columns = columns();
    let scenes = results.scenes(&methods());
    let names = columns.iter().map(|column| format!("{}: `{}`", column.name, column.method.name()));
    let mut sheet = Sheet::new(["scene".to_owned()].into_iter().chain(names).chain(["pixels".into()]));
    for scene in &scenes {
        sheet.push(scene_row(results, &columns, scene));
    }
    if scenes.is_empty() {
        return sheet;
    }
    let mut summary = |title: &str, cell: &dyn Fn(&Column) -> String| {
        let cells = columns.iter().map(cell);
        sheet.push([format!("**{title}**")].into_iter().chain(cells).chain([String::new()]));
    };
    let mean = |column: &Column, number: &dyn Fn(&Record) -> f64| results.mean(&scenes, &column.method, number);
    summary("mean MAE", &|column| {
        let paper = column.paper.map(|at| paper_mean(&scenes, at));
        beside(mean(column, &|record| record.errors.mae_ldr), paper, 4)
    });
    let plain = columns[0];
    summary(&format!("MAE relative to `{}`, geometric mean", plain.method.name()), &|column| {
        let paper = column.paper.zip(plain.paper).map(|(at, plain)| paper_ratio(&scenes, at, plain));
        beside(results.ratio(&scenes, &column.method, &plain.method, |record| record.errors.mae_ldr), paper, 2)
    });
    summary("time per sample (ms)", &|column| {
        beside(mean(column, &Record::ms_per_sample), column.paper.map(|at| TABLE1_MS[at]), 2)
    });
    summary(&format!("time per sample relative to `{}`", plain.method.name()), &|column| {
        let paper = column.paper.zip(plain.paper).map(|(at, plain)| TABLE1_MS[at] / TABLE1_MS[plain]);
        beside(results.ratio(&scenes, &column.method, &plain.method, Record::ms_per_sample), paper, 2)
    });
    summary("samples per pixel", &|column| {
        beside(mean(column, &|record| f64::from(record.spp)), column.paper.map(|at| TABLE1_SPP[at]), 0)
    });
    summary("invalid sample rate", &|column| {
        let paper = column.paper.map(|at| TABLE1_INVALID[at]);
        beside(mean(column, &|record| record.counts.invalid_rate()), paper, 4)
    });
    sheet
}

fn scene_row(results: &Results, columns: &[Column], scene: &PaperScene) -> Vec<String> {
    let records =
        columns.iter().filter_map(|column| results.of(scene.name, &column.method).map(|record| (column, record)));
    let cell =
        |(column, record): (&Column, &Record)| beside(record.errors.mae_ldr, column.paper.map(|at| scene.mae[at]), 4);
    let size = results.of(scene.name, &columns[0].method).map(|record| format!("{} x {}", record.width, record.height));
    [scene.name.to_owned()].into_iter().chain(records.map(cell)).chain(size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::testing::record;

    #[test]
    fn ours_stand_beside_the_papers_over_the_same_scenes() {
        let mut records = Vec::new();
        for (place, method) in methods().iter().enumerate() {
            records.push(record("cornell-box", method, 0.01 * (place + 1) as f64));
            // This scene lacks some methods, so it must have no row and must not enter any mean.
            if place < 3 {
                records.push(record("kitchen", method, 0.5));
            }
        }
        let markdown = sheet(&Results(records)).markdown();
        let line = |begin: &str| markdown.lines().find(|line| line.starts_with(begin)).expect("a line").to_owned();
        assert_eq!(markdown.lines().count(), 9, "{markdown}");
        assert_eq!(
            line("| cornell-box"),
            "| cornell-box | 0.0100 (0.0114) | 0.0200 (0.0062) | 0.0300 (0.0093) | 0.0400 (0.0098) | 0.0500 (0.0072) | 0.0600 \
             | 8 x 4 |"
        );
        assert!(
            line("| **MAE relative")
                .contains("| 1.00 (1.00) | 2.00 (0.54) | 3.00 (0.82) | 4.00 (0.86) | 5.00 (0.63) |"),
            "{markdown}"
        );
        assert!(line("| **time per sample (ms)").contains("62.50 (10.59)"), "{markdown}");
    }

    #[test]
    fn nothing_measured_is_an_empty_table() {
        assert_eq!(sheet(&Results::default()).markdown().lines().count(), 2);
    }
}
