//! Figure 7: the share of rays that hit emitters as learning proceeds (a), and error, hit rate and number of samples
//! for a fixed share e of uniform directions (b and c).

use super::methods::{Method, SHARES};
use super::paper::TABLE2;
use super::plot::{Axis, Plot, Series};
use super::record::Record;
use super::results::Results;
use super::sheet::Sheet;
use crate::settings::{Learner, Sampler};

/// Methods of Figure 7a.
const OVER_STEPS: [Method; 3] = [
    Method::PLAIN,
    Method::new(Sampler::Rejection, Learner::Sarsa),
    Method::new(Sampler::RejectionMix, Learner::Sarsa),
];

/// Methods of Figures 7b and 7c for one learner: `rejection-mix` with each share.
fn sweep(learner: Learner) -> impl Iterator<Item = (f32, Method)> {
    SHARES.into_iter().map(move |share| (share, Method::new(Sampler::RejectionMix, learner).with_share(share)))
}

/// Methods that the figure compares.
pub fn methods() -> Vec<Method> {
    let swept = TABLE2.iter().flat_map(|row| sweep(row.learner)).map(|(_, method)| method);
    OVER_STEPS.into_iter().chain(swept).collect()
}

/// Plots of the completely measured scenes, with their file names.
pub fn plots(results: &Results) -> Vec<(String, Plot)> {
    let scenes = results.scenes(&methods());
    scenes.iter().flat_map(|scene| of_scene(results, scene.name)).collect()
}

fn of_scene(results: &Results, scene: &str) -> Vec<(String, Plot)> {
    let share = Axis::logarithmic("fixed share e of uniform directions");
    let plot = |name: &str, title: &str, x, y, series| {
        (format!("figure7{name}-{scene}.svg"), Plot { title: format!("{scene}: {title}"), x, y, series })
    };
    let swept = |number: &dyn Fn(&Record) -> f64| by_share(results, scene, number);
    let rates = Axis::linear("share of rays that hit emitters");
    vec![
        plot("a", "rays that hit emitters", Axis::linear("samples per pixel"), rates, over_steps(results, scene)),
        plot("b", "error at equal time", share, Axis::linear("MAE"), swept(&|record| record.errors.mae_ldr)),
        plot("c-hits", "rays that hit emitters", share, rates, swept(&|record| record.counts.light_hit_rate())),
        plot("c-samples", "samples", share, Axis::linear("samples per pixel"), swept(&|record| f64::from(record.spp))),
    ]
}

fn over_steps(results: &Results, scene: &str) -> Vec<Series> {
    let found = OVER_STEPS.iter().filter_map(|method| Some((method, results.of(scene, method)?)));
    let points = |record: &Record| record.steps.iter().map(|step| [f64::from(step.spp), step.light_hit_rate]).collect();
    found.map(|(method, record)| Series { name: method.name(), points: points(record) }).collect()
}

/// Series for a plot over the share: one line per learner, and a horizontal line for a plain path tracer.
fn by_share(results: &Results, scene: &str, number: &dyn Fn(&Record) -> f64) -> Vec<Series> {
    let learners = TABLE2.iter().map(|row| {
        let points = sweep(row.learner).filter_map(|(share, method)| {
            let record = results.of(scene, &method)?;
            Some([f64::from(share), number(record)])
        });
        Series { name: row.name.into(), points: points.collect() }
    });
    let plain = results.of(scene, &Method::PLAIN).map(|record| Series {
        name: Method::PLAIN.name(),
        points: [SHARES[0], 1.0].map(|share| [f64::from(share), number(record)]).into(),
    });
    plain.into_iter().chain(learners).collect()
}

/// Table for Figure 7a: the light-hit rate of every step.
pub fn steps_sheet(results: &Results) -> Sheet {
    let mut sheet = Sheet::new(["scene", "method", "spp", "seconds", "light_hit_rate"]);
    for scene in results.scenes(&OVER_STEPS) {
        for record in OVER_STEPS.iter().filter_map(|method| results.of(scene.name, method)) {
            for step in &record.steps {
                let numbers = [step.spp.to_string(), step.seconds.to_string(), step.light_hit_rate.to_string()];
                sheet.push([record.scene.clone(), record.method.clone()].into_iter().chain(numbers));
            }
        }
    }
    sheet
}

/// Table for Figures 7b and 7c.
pub fn shares_sheet(results: &Results) -> Sheet {
    let mut sheet = Sheet::new(["scene", "learner", "share", "mae_ldr", "light_hit_rate", "spp"]);
    for scene in results.scenes(&methods()) {
        for row in &TABLE2 {
            let found =
                sweep(row.learner).filter_map(|(share, method)| Some((share, results.of(scene.name, &method)?)));
            for (share, record) in found {
                let numbers = [record.errors.mae_ldr, record.counts.light_hit_rate(), f64::from(record.spp)];
                let cells = [scene.name.to_owned(), row.name.to_owned(), share.to_string()];
                sheet.push(cells.into_iter().chain(numbers.map(|number| number.to_string())));
            }
        }
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::testing::record;

    #[test]
    fn every_scene_has_its_plots() {
        let results = Results(methods().iter().map(|method| record("kitchen", method, 0.02)).collect());
        let plots = plots(&results);
        let names: Vec<_> = plots.iter().map(|(name, _)| &name[..]).collect();
        let expected = ["a", "b", "c-hits", "c-samples"].map(|part| format!("figure7{part}-kitchen.svg"));
        assert_eq!(names, expected);
        // Plot a has three methods over two steps. The other plots have a horizontal line and three learners over all
        // shares.
        let lengths = |at: usize| plots[at].1.series.iter().map(|series| series.points.len()).collect::<Vec<_>>();
        assert_eq!((lengths(0), lengths(1)), (vec![2; 3], vec![2, 7, 7, 7]));
        assert_eq!(steps_sheet(&results).csv().lines().count(), 1 + 3 * 2);
        assert_eq!(shares_sheet(&results).csv().lines().count(), 1 + 3 * 7);
    }
}
