//! Printing of the table, in Markdown.

use support::bench::digits::three_digits;

use crate::mitsuba::Mitsuba;
use crate::store::{Baseline, Line};

/// Prints all quantities beside the stored ones.
pub fn print(now: &Baseline, stored: Option<&Baseline>, mitsuba: &Mitsuba) {
    println!("beside: {}", mitsuba.description);
    println!("medians of {} rounds; ratios are of speeds: above 1 is faster now, or faster than Mitsuba\n", now.rounds);
    println!("| quantity | unit | value | spread | baseline | ratio | corrected | Mitsuba | ratio |");
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|");
    let lines = stored.map(Baseline::lines).unwrap_or_default();
    for line in &now.quantities {
        println!("{}", row(line, lines.get(line.name.as_str()).copied()));
    }
    let gone = lines.keys().filter(|name| !now.quantities.iter().any(|line| line.name == **name)).count();
    if gone > 0 {
        println!("\n{gone} quantities of the baseline were not measured");
    }
}

fn row(line: &Line, stored: Option<&Line>) -> String {
    let spread = || Some(100.0 * (line.most? - line.least?) / line.value?);
    let cells = [
        line.name.clone(),
        line.unit.clone(),
        number(line.value),
        spread().map_or_else(none, |percent| format!("{percent:.0} %")),
        number(stored.and_then(|stored| stored.value)),
        ratio(stored.and_then(|stored| line.speed_ratio(stored))),
        ratio(stored.and_then(|stored| line.corrected_ratio(stored))),
        number(line.mitsuba),
        ratio(line.relative_to_mitsuba),
    ];
    format!("| {} |", cells.join(" | "))
}

fn none() -> String {
    "-".into()
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(none, three_digits)
}

fn ratio(value: Option<f64>) -> String {
    value.map_or_else(none, |value| format!("{value:.2}"))
}
