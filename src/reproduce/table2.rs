//! Table 2: every sampler with every learner, as means over the scenes, at equal time and at equal samples.

use super::methods::{METHODS, Method};
use super::paper::{PaperLearner, TABLE2, table2_column};
use super::record::Record;
use super::results::Results;
use super::sheet::Sheet;

/// Methods that the table compares.
pub fn methods() -> Vec<Method> {
    METHODS.iter().filter(|place| place.table2.is_some()).map(|place| place.method).collect()
}

/// Columns: the samplers, in the order of their first method.
fn columns() -> Vec<&'static str> {
    let mut columns = Vec::new();
    for column in METHODS.iter().filter_map(|place| place.table2) {
        if !columns.contains(&column) {
            columns.push(column);
        }
    }
    columns
}

/// Table of one quantity. The paper's numbers stand in parentheses.
fn sheet(
    title: &str,
    ours: &dyn Fn(&Method) -> String,
    paper: &dyn Fn(&PaperLearner, usize) -> Option<String>,
) -> Sheet {
    let mut sheet = Sheet::new([title].into_iter().chain(columns()));
    for learner in &TABLE2 {
        let cell = |column: &str| {
            let found = METHODS.iter().find(|p| p.table2 == Some(column) && p.method.learner == learner.learner)?;
            let beside = table2_column(column).and_then(|at| paper(learner, at)).map(|paper| format!(" ({paper})"));
            Some(format!("{}{}", ours(&found.method), beside.unwrap_or_default()))
        };
        let cells = columns().into_iter().map(|column| cell(column).unwrap_or_default());
        sheet.push([learner.name.to_owned()].into_iter().chain(cells));
    }
    sheet
}

/// Mean error at equal time.
pub fn mae(results: &Results) -> Sheet {
    let scenes = results.scenes(&methods());
    let ours = |method: &Method| format!("{:.4}", results.mean(&scenes, method, |record| record.errors.mae_ldr));
    sheet("MAE", &ours, &|learner, at| Some(format!("{:.4}", learner.mae[at])))
}

/// Mean time per sample.
pub fn milliseconds(results: &Results) -> Sheet {
    let scenes = results.scenes(&methods());
    let ours = |method: &Method| format!("{:.2}", results.mean(&scenes, method, Record::ms_per_sample));
    sheet("time per sample (ms)", &ours, &|learner, at| Some(format!("{:.2}", learner.ms[at])))
}

/// Mean share of samples below the surface.
pub fn invalid_rates(results: &Results) -> Sheet {
    let scenes = results.scenes(&methods());
    let ours = |method: &Method| format!("{:.4}", results.mean(&scenes, method, |record| record.counts.invalid_rate()));
    sheet("invalid sample rate", &ours, &|_, _| None)
}

/// Mean proposals per guided direction.
pub fn tries(results: &Results) -> Sheet {
    let scenes = results.scenes(&methods());
    let ours =
        |method: &Method| format!("{:.2}", results.mean(&scenes, method, |record| record.counts.tries_per_sample()));
    sheet("tries per sample", &ours, &|_, _| None)
}

/// Mean error at equal samples: on each scene the samples of its slowest method, rounded down to a step with a measured
/// error.
pub fn mae_of_equal_samples(results: &Results) -> Sheet {
    let methods = methods();
    let scenes = results.scenes(&methods);
    let ours = |method: &Method| {
        let at_equal = |record: &Record| {
            let others = methods.iter().filter_map(|other| results.of(&record.scene, other));
            let fewest = others.filter_map(|other| other.steps.iter().rev().find(|step| step.mae.is_some()));
            let fewest = fewest.map(|step| step.spp).min();
            let step = record.steps.iter().find(|step| Some(step.spp) == fewest);
            step.and_then(|step| step.mae).unwrap_or(f64::NAN)
        };
        format!("{:.4}", results.mean(&scenes, method, at_equal))
    };
    sheet("MAE", &ours, &|_, _| None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::testing::record;
    use crate::settings::{Learner, Sampler};

    fn results() -> Results {
        let mut records: Vec<_> = methods().iter().map(|method| record("kitchen", method, 0.02)).collect();
        records.extend(methods().iter().map(|method| record("staircase", method, 0.04)));
        Results(records)
    }

    #[test]
    fn means_stand_beside_the_papers() {
        let markdown = mae(&results()).markdown();
        let last = markdown.lines().last().expect("a line");
        let expected =
            "| SARSA | 0.0300 (0.0340) | 0.0300 (0.0434) | 0.0300 (0.0507) | 0.0300 (0.0317) | 0.0300 | 0.0300 |";
        assert_eq!(last, expected);
        assert!(milliseconds(&results()).markdown().contains("62.50 (76.61)"));
    }

    /// Checks a record without an error after its second step. All records have steps of 8 and 16 samples.
    #[test]
    fn equal_samples_are_those_that_all_have_reached() {
        let mut results = results();
        let slow = Method::new(Sampler::Rejection, Learner::MonteCarlo).name();
        let slow = results.0.iter_mut().filter(|record| record.method == slow);
        slow.for_each(|record| record.steps.truncate(1));
        // The error after the first step of a record is twice the error at its end.
        let markdown = mae_of_equal_samples(&results).markdown();
        assert!(markdown.contains("| SARSA | 0.0600 |"), "{markdown}");
    }
}
