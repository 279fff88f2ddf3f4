//! Ablation, an experiment beyond the paper: the effect of each part of the default guide at equal time, with and
//! without emitter sampling.

use super::changes::Changes;
use super::methods::Method;
use super::paper::PaperScene;
use super::protocol::Base;
use super::record::Record;
use super::results::Results;
use super::sheet::Sheet;
use crate::settings::{
    BsdfShare, GuideSet, Learner, LightSelection, Roulette, SamplePattern, SampleWeights, Sampler, StepSchedule, Words,
};

/// Plain path tracer.
const PLAIN: Method = Method { base: Base::Defaults, ..Method::PLAIN };
/// Sampler of the paper, with default settings otherwise.
const REJECTION_MIX: Method = Method { base: Base::Defaults, ..Method::new(Sampler::RejectionMix, Learner::Sarsa) };
/// Default guide.
const PRODUCT: Method = Method { base: Base::Defaults, ..Method::new(Sampler::Product, Learner::Sarsa) };
const NONE: Changes = Changes::NONE;
/// Product sampler with every other part of the default guide switched off.
const ALONE: Method = PRODUCT.with(Changes {
    guide_set: Some(GuideSet::Diffuse),
    steps: Some(StepSchedule::Even),
    sample_weights: Some(SampleWeights::Even),
    pattern: Some(SamplePattern::Independent),
    fallback: Some(0.0),
    bsdf_share: Some(BsdfShare::Fixed),
    light_selection: Some(LightSelection::Power),
    roulette: Some(Roulette::Throughput),
    ..NONE
});

/// Rows of the table, without emitter sampling. To add a row, add a line here.
const ROWS: &[Method] = &[
    PLAIN,
    REJECTION_MIX,
    PRODUCT,
    PRODUCT.with(Changes { steps: Some(StepSchedule::Even), ..NONE }),
    PRODUCT.with(Changes { sample_weights: Some(SampleWeights::Even), ..NONE }),
    PRODUCT.with(Changes { pattern: Some(SamplePattern::Independent), ..NONE }),
    ALONE,
    PRODUCT.with(Changes { bsdf_share: Some(BsdfShare::Fixed), ..NONE }),
    PRODUCT.with(Changes { light_selection: Some(LightSelection::Power), ..NONE }),
    PRODUCT.with(Changes { roulette: Some(Roulette::Throughput), ..NONE }),
    PRODUCT.with(Changes { guide_set: Some(GuideSet::Diffuse), ..NONE }),
    PRODUCT.with(Changes { guide_set: Some(GuideSet::Authors), ..NONE }),
    Method { learner: Learner::ExpectedSarsa, ..PRODUCT },
    Method { learner: Learner::MonteCarlo, ..PRODUCT },
    PRODUCT.with(Changes { directions: Some(32), ..NONE }),
    PRODUCT.with(Changes { fallback: Some(0.0), ..NONE }),
    PRODUCT.with(Changes { grid: Some(8), ..NONE }),
];

/// Methods that the ablation compares.
pub fn methods() -> Vec<Method> {
    [false, true].into_iter().flat_map(|nee| ROWS.iter().map(move |row| Method { nee, ..*row })).collect()
}

/// Name of a row: the options that select it on the command line.
fn label(row: &Method) -> String {
    let learner = match row.learner == PRODUCT.learner {
        true => String::new(),
        false => format!(" --learner {}", row.learner.word()),
    };
    format!("{}{learner}{}", row.sampler.word(), row.changes.options())
}

/// Table of geometric means over the completely measured scenes, with or without emitter sampling.
pub fn sheet(results: &Results, nee: bool) -> Sheet {
    let mut sheet = Sheet::new([
        "method",
        "MAE relative to `bsdf`",
        "MAE relative to `product`",
        "largest MAE relative to `product`",
        "time per sample relative to `bsdf`",
    ]);
    let scenes = results.scenes(&methods());
    if scenes.is_empty() {
        return sheet;
    }
    let [plain, product] = [PLAIN, PRODUCT].map(|method| Method { nee, ..method });
    for row in ROWS {
        let method = Method { nee, ..*row };
        let ratio = |to: &Method| format!("{:.3}", results.ratio(&scenes, &method, to, error));
        let time = format!("{:.2}", results.ratio(&scenes, &method, &plain, Record::ms_per_sample));
        let cells = [ratio(&plain), ratio(&product), worst(results, &scenes, &method, &product), time];
        sheet.push([format!("`{}`", label(row))].into_iter().chain(cells));
    }
    sheet
}

/// Largest ratio of a method's error to another's over the scenes, with the name of that scene.
fn worst(results: &Results, scenes: &[PaperScene], method: &Method, to: &Method) -> String {
    let ratios = scenes.iter().map(|scene| (results.ratio(&[*scene], method, to, error), scene.name));
    let largest = ratios.max_by(|a, b| a.0.total_cmp(&b.0));
    largest.map(|(ratio, scene)| format!("{ratio:.3} ({scene})")).unwrap_or_default()
}

/// Measurements behind both tables, one line per scene and row.
pub fn measurements(results: &Results) -> Sheet {
    let mut sheet = Sheet::new(["scene", "nee", "method", "mae_ldr", "mse", "spp", "ms_per_sample"]);
    for scene in results.scenes(&methods()) {
        for method in methods() {
            let Some(record) = results.of(scene.name, &method) else { continue };
            let nee = if method.nee { "on" } else { "off" };
            let numbers = [error(record), record.errors.mse, f64::from(record.spp), record.ms_per_sample()];
            let cells = [scene.name.to_owned(), nee.into(), label(&method)];
            sheet.push(cells.into_iter().chain(numbers.map(|number| number.to_string())));
        }
    }
    sheet
}

fn error(record: &Record) -> f64 {
    record.errors.mae_ldr
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::testing::record;
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};
    use crate::settings::Settings;

    fn defaults() -> Settings {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        // The paper's paths have at most 16 edges.
        Settings::for_film(&film, &IntegratorDescription { max_depth: Some(16), ..Default::default() })
    }

    #[test]
    fn the_product_row_is_what_renders_have_by_default() {
        let with_emitters = Method { nee: true, ..PRODUCT };
        assert_eq!(with_emitters.settings(defaults(), [8, 8]), defaults());
        assert_eq!(PRODUCT.settings(defaults(), [8, 8]), Settings { nee: false, ..defaults() });
    }

    /// Checks that a row renders with exactly the settings in its name, and otherwise with the defaults.
    #[test]
    fn rows_change_what_they_name() {
        let default = PRODUCT.settings(defaults(), [8, 8]).named();
        for row in ROWS {
            let label = label(row);
            let mut words = label.split(' ');
            let mut expected = default.clone();
            let mut set = |name: &str, value: &str| {
                let found = expected.iter_mut().find(|setting| setting.0 == name).expect("a setting");
                assert!(found.1 != value || name == "sampler", "{label}: the default has {name} {value}");
                found.1 = value.into();
            };
            set("sampler", words.next().expect("a sampler"));
            while let (Some(option), Some(value)) = (words.next(), words.next()) {
                // JSON writes a float with a decimal point.
                let value = if option == "--fallback" { format!("{value}.0") } else { value.into() };
                set(&option.trim_start_matches("--").replace('-', "_"), &value);
            }
            assert_eq!(row.settings(defaults(), [8, 8]).named(), expected, "{label}");
        }
    }

    #[test]
    fn rows_stand_beside_a_plain_path_tracer_and_the_default() {
        let mut records = Vec::new();
        for method in methods() {
            let mae = if method == (Method { nee: true, ..PRODUCT }) { 0.04 } else { 0.02 };
            records.push(record("kitchen", &method, mae));
            records.push(record("staircase", &method, if method.sampler == Sampler::Bsdf { 0.16 } else { 0.02 }));
            // This scene lacks some methods, so it must not enter any mean.
            if !method.nee {
                records.push(record("bathroom", &method, 0.5));
            }
        }
        let results = Results(records);
        let line = |nee: bool, begin: &str| {
            let markdown = sheet(&results, nee).markdown();
            let found = markdown.lines().find(|line| line.starts_with(begin)).map(str::to_owned);
            found.unwrap_or_else(|| panic!("{markdown} lacks {begin}"))
        };
        assert_eq!(line(false, "| `bsdf`"), "| `bsdf` | 1.000 | 2.828 | 8.000 (staircase) | 1.00 |");
        assert_eq!(line(true, "| `product` "), "| `product` | 0.500 | 1.000 | 1.000 (staircase) | 1.00 |");
        assert!(line(true, "| `product --steps even`").contains("| 0.707 | 1.000 (staircase) |"));
        assert!(line(true, "| `product --grid 8`").contains("| 0.707 |"));
        let csv = measurements(&results).csv();
        assert_eq!(csv.lines().count(), 1 + 2 * 2 * ROWS.len());
        assert!(csv.contains("\nkitchen,on,product,0.04,0.04,16,62.5\n"), "{csv}");
        assert!(csv.contains("\nstaircase,off,product --learner monte-carlo,0.02,"), "{csv}");
    }

    #[test]
    fn nothing_measured_is_an_empty_table() {
        assert_eq!(sheet(&Results::default(), true).markdown().lines().count(), 2);
    }
}
