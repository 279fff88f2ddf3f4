//! Proof that the claims are sharp: every known fault is found by the claim that is meant to find it, and changes that
//! must not matter are not flagged. The faulty kernels are in `tests/tampered`.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use lodestar::fleet::sums::{self, AddSums, Sums};
use lodestar::settings::{DirectionMap, GuideSet, Learner, Sampler};

use support::mutated::{
    DEFORMING_FAULTS, DIMMED_TWICE, FAR_OFF, FEW_SURFACES, GRID_DIMMED_TWICE, INSTANCE_FAULTS, LOW_MAJORANTS,
    MOTION_FAULTS, OTHER_PHASE, OTHER_SIDE, SHORT_OF_LIGHT, STRAIGHT_SHADES, TILTED_BACK, TURNED_TO_HOLE,
    UNWEIGHTED_NULL, WRONG_DIRECTION,
};
use support::tier;

use crate::claims::{
    ALL, Claim, DENSITIES, DEVICES, DIRECTIONS, DOORS, EMITTERS, ENTRIES, FURNACE, PATTERNS, PICTURES, ROULETTE,
    SAMPLES, SUMS, TARGETS, TREES, UPDATES,
};
use crate::evidence::{Finding, MOST_TESTS};
use crate::rows::Scope;
use crate::subject::{Change, SHIPPED, Subject};

/// A fault, the claim that must find it, and the row of the table that is tested.
struct Fault(Subject, Claim, &'static str);

const MIX: &str = "rejection-mix";
const PRODUCT: &str = "product";
const OWN_CELLS: &str = "product-own-cells";
const QUADTREE: &str = "quadtree";

const fn kernels(name: &'static str, claim: Claim, row: &'static str) -> Fault {
    Fault(Subject::mutated(name), claim, row)
}

/// Forgets another device's sums.
const LOSE: AddSums = |_, _| {};

/// Adds another device's sums twice.
fn add_twice(total: &mut Sums, sums: &Sums) {
    sums::add(total, sums);
    sums::add(total, sums);
}

const FAULTS: &[Fault] = &[
    kernels("memo keyed by a visitor's normal", DENSITIES, MIX),
    kernels("maximum over bin centers", SAMPLES, MIX),
    kernels("clipped acceptance", SAMPLES, MIX),
    kernels("off-by-one bin", SAMPLES, MIX),
    kernels("missing cosine", SAMPLES, MIX),
    kernels("missing uniform share in the density", SAMPLES, MIX),
    kernels("fallback not in the density", DENSITIES, MIX),
    kernels("proposals of a pair alike", SAMPLES, MIX),
    kernels("horizon of the representative normal", DENSITIES, MIX),
    kernels("inversion forgets the uniform share", DENSITIES, "hemisphere-inversion"),
    kernels("neighbor of the drawn part", SAMPLES, PRODUCT),
    kernels("descent counted whole", DENSITIES, PRODUCT),
    kernels("share of the cosine not in the density", DIRECTIONS, PRODUCT),
    kernels("another BSDF share than the cell's", PICTURES, PRODUCT),
    kernels("another share of a whole function in the density", DIRECTIONS, PRODUCT),
    kernels("the guide's share of principled surfaces not in the density", DIRECTIONS, PRODUCT),
    kernels("a smooth metal guided as a rough one in the density", DIRECTIONS, MIX),
    kernels("bright samples with a smaller weight", PICTURES, OWN_CELLS),
    kernels("lobe counted whole", DIRECTIONS, MIX),
    kernels("a sheen that gains energy", DIRECTIONS, MIX),
    kernels("a film that turns no phase", DIRECTIONS, MIX),
    kernels("a lobe of hair with another width around the fiber", DIRECTIONS, MIX),
    kernels("samples of hair with another width around the fiber", DIRECTIONS, MIX),
    kernels("samples of a measured material that are all alike", DIRECTIONS, MIX),
    kernels("stale normalizer", ENTRIES, MIX),
    kernels("swapped halves of a sum", UPDATES, MIX),
    kernels("lost carry", SUMS, MIX),
    kernels("targets rounded down", SUMS, MIX),
    kernels("learning rate without decay", UPDATES, MIX),
    kernels("target without attenuation", TARGETS, MIX),
    kernels("roulette scales the bootstrap target", TARGETS, MIX),
    kernels("returns without survival", TARGETS, MIX),
    kernels("learning takes surfaces to be 5 % brighter", TARGETS, MIX),
    kernels("learning takes surfaces to be twice as bright", TARGETS, MIX),
    kernels("targets that are no numbers", DOORS, MIX),
    kernels("missing survival weight", ROULETTE, "bsdf"),
    kernels("roulette by a used random number", ROULETTE, "bsdf"),
    kernels("survivors of roulette with too small a weight", FURNACE, OWN_CELLS),
    kernels("survivors of roulette give nothing up", ROULETTE, PRODUCT),
    kernels("ended paths bring less than survivors give up", ROULETTE, PRODUCT),
    kernels("points of a set not scrambled", PATTERNS, "bsdf"),
    kernels("a digit of points on the film lost", PATTERNS, "bsdf"),
    kernels("digits of points of a tile lost", PATTERNS, "bsdf"),
    kernels("rest of a random number not stretched", PICTURES, QUADTREE),
    kernels("left and right of a square exchanged", TREES, QUADTREE),
    kernels("halves of a leaf in one tree", TREES, QUADTREE),
    kernels("density 0 for the weights", EMITTERS, MIX),
    kernels("emitters counted twice", EMITTERS, MIX),
    kernels("missing Jacobian", EMITTERS, MIX),
    kernels("weights blind to the guide", EMITTERS, MIX),
    kernels("light counted whole however it is found", EMITTERS, MIX),
    kernels("holes that shadow rays do not pass", EMITTERS, MIX),
    kernels("light that passes each surface twice", EMITTERS, MIX),
    kernels("the density at the last hole", EMITTERS, MIX),
    kernels("light that refraction does not weaken", EMITTERS, MIX),
    kernels("refracted light counted twice", EMITTERS, MIX),
    kernels("light selection counts the light that it has drawn", EMITTERS, PRODUCT),
    kernels("a light that is hit has the density within its group", EMITTERS, PRODUCT),
    kernels("densities 5 % off", FURNACE, MIX),
    kernels("densities 25 % off", FURNACE, MIX),
    Fault(Subject::adding("one device's sums are lost", LOSE), DEVICES, PRODUCT),
    Fault(Subject::adding("sums are added twice", add_twice), DEVICES, QUADTREE),
];

/// A change that must not matter, and the claims that it touches.
struct Harmless(Subject, &'static [Claim]);

const RENDERS: &[Claim] = &[FURNACE, PICTURES];

const fn other_settings(name: &'static str, change: Change) -> Harmless {
    Harmless(Subject::changed(name, change), RENDERS)
}

const HARMLESS: &[Harmless] = &[
    Harmless(
        Subject { name: "another seed", seed: 5000, ..SHIPPED },
        &[SAMPLES, DIRECTIONS, SUMS, UPDATES, FURNACE, PICTURES],
    ),
    Harmless(Subject { name: "yet another seed", seed: 9_999_999, ..SHIPPED }, &[SAMPLES, SUMS, TARGETS, ROULETTE]),
    Harmless(Subject { name: "workgroups of 32", group: 32, ..SHIPPED }, &[SAMPLES, DENSITIES, DIRECTIONS]),
    Harmless(Subject { name: "workgroups of 128", group: 128, ..SHIPPED }, &[SAMPLES, DENSITIES]),
    other_settings("slices of 1 ms", |s| s.slice_milliseconds = Some(1.0)),
    other_settings("slices of 500 ms", |s| s.slice_milliseconds = Some(500.0)),
    other_settings("film pages of 256 pixels", |s| s.film_page_pixels = Some(256)),
    other_settings("reads of storage buffers", |s| s.storage_reads = true),
    other_settings("3 samples a dispatch", |s| s.samples_per_dispatch = 3),
    other_settings("16 samples a step", |s| s.spp_per_step = 16),
    other_settings("5 cells a side", |s| s.grid = Some(5)),
    other_settings("12 directions a side", |s| s.directions = 12),
    other_settings("6 normals a side", |s| s.normals = 6),
    other_settings("old targets kept", |s| s.decay = 1.0),
    other_settings("4 tries", |s| s.max_tries = 4),
    other_settings("a quarter uniform", |s| s.min_uniform = 0.25),
    other_settings("the cylindrical map", |s| s.map = DirectionMap::Cylindrical),
    other_settings("the authors' guide set", |s| s.guide_set = GuideSet::Authors),
    Harmless(Subject::mutated("cells in another order"), RENDERS),
    Harmless(Subject::mutated("normalizers summed backwards"), &[SAMPLES, DENSITIES, ENTRIES, FURNACE]),
    Harmless(Subject::mutated("workgroups in another order"), RENDERS),
    Harmless(Subject::mutated("other random blocks"), &[SAMPLES, FURNACE, PICTURES]),
    Harmless(Subject::mutated("another multiplier of leftover bits"), &[TARGETS, FURNACE]),
    Harmless(Subject::mutated("digits flipped whatever comes before"), &[PATTERNS]),
    Harmless(
        Subject {
            change: |s| (s.sampler, s.learner) = (Sampler::Quadtree, Learner::MonteCarlo),
            ..Subject::mutated("coarser squares of directions")
        },
        RENDERS,
    ),
    Harmless(Subject::mutated("roulette ends more paths"), &[ROULETTE, TARGETS]),
    Harmless(Subject::mutated("another window of roulette"), &[ROULETTE, TARGETS, FURNACE]),
    Harmless(Subject::mutated("the balance heuristic"), &[EMITTERS, FURNACE]),
];

/// Writes a table below `target/proofs`.
fn write_table(file: &str, heading: &str, rows: &[String]) {
    let table = format!("{heading}\n{}\n", rows.join("\n"));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/proofs");
    fs::create_dir_all(&folder).expect("a folder below target");
    fs::write(folder.join(file), &table).expect("written");
    println!("{table}");
}

/// Faults that this run looks for: those whose name contains LODESTAR_FAULT, or all.
fn faults() -> Vec<&'static Fault> {
    let wanted = std::env::var("LODESTAR_FAULT").unwrap_or_default();
    FAULTS.iter().filter(|Fault(subject, ..)| subject.name.contains(&wanted)).collect()
}

/// Findings about each fault. Two faults are looked for at the same time, because the twins run on one thread.
fn findings(faults: &[&Fault]) -> Vec<Option<Finding>> {
    let next = AtomicUsize::new(0);
    let examine = |Fault(subject, claim, row): &Fault| {
        let evidence = claim.examine(subject, Scope::only(row));
        evidence.write();
        println!("{}: {:?}", subject.name, evidence.finding());
        evidence.finding()
    };
    let examine_some = || {
        let mut found = Vec::new();
        while let Some((number, fault)) = faults.iter().enumerate().nth(next.fetch_add(1, Ordering::Relaxed)) {
            found.push((number, examine(fault)));
        }
        found
    };
    let mut found = thread::scope(|scope| {
        let other = scope.spawn(examine_some);
        let own = examine_some();
        [own, other.join().expect("no panic")].concat()
    });
    found.sort_by_key(|&(number, _)| number);
    found.into_iter().map(|(_, finding)| finding).collect()
}

/// The claim that is meant to find a fault finds it, for every fault. CI runs this test of the long tier every time.
#[test]
fn every_fault_is_caught() {
    if tier::is_skipped("the twins of tests/render and tests/samplers") {
        return;
    }
    let mut rows = Vec::new();
    let mut missed = Vec::new();
    let faults = faults();
    for (Fault(subject, claim, _), finding) in faults.iter().zip(findings(&faults)) {
        let Some(finding) = finding else {
            missed.push(subject.name);
            continue;
        };
        let what = finding.case.split([',', ':']).next().unwrap_or_default();
        let p = finding.p.map_or("exact".into(), |p| if p > 0.0 { format!("{p:.0e}") } else { "< 1e-300".into() });
        rows.push(format!("| {} | {} | {what} | {p} |", subject.name, claim.name));
    }
    assert!(missed.is_empty(), "not caught: {missed:?}");
    assert!(!rows.is_empty() && (faults.len() < FAULTS.len() || rows.len() >= 22));
    write_table("faults.md", "| fault | claim | test | p |\n|---|---|---|---|", &rows);
}

#[test]
fn no_harmless_change_is_flagged() {
    if tier::is_skipped("the claims themselves, which are tested without a change") {
        return;
    }
    let mut rows = Vec::new();
    let mut flagged = Vec::new();
    let mut tests: usize = ALL.iter().map(|claim| claim.most_tests).sum();
    for Harmless(subject, claims) in HARMLESS {
        let mut least = 1.0_f64;
        for claim in *claims {
            let evidence = claim.examine(subject, Scope::only(MIX));
            evidence.write();
            tests += evidence.tests;
            least = least.min(evidence.least());
            println!("{}, {}: least p = {:.1e} of {}", subject.name, claim.name, evidence.least(), evidence.tests);
            if let Some(finding) = evidence.finding() {
                flagged.push(format!("{} by {}: {finding:?}", subject.name, claim.name));
            }
        }
        let claims = claims.iter().map(|claim| claim.name).collect::<Vec<_>>().join(", ");
        rows.push(format!("| {} | {claims} | {least:.0e} |", subject.name));
    }
    assert!(flagged.is_empty(), "flagged: {flagged:#?}");
    assert!(rows.len() >= 20);
    assert!(tests <= MOST_TESTS, "{tests} tests are more than the level allows for");
    write_table("harmless.md", "| change | claims | least p |\n|---|---|---|", &rows);
}

/// Faults that `tests/render/media.rs` and `tests/render/grids.rs` find.
const OF_MEDIA: [&str; 6] = [DIMMED_TWICE, OTHER_SIDE, OTHER_PHASE, GRID_DIMMED_TWICE, LOW_MAJORANTS, UNWEIGHTED_NULL];

/// Every mutation is used: a mutation that no test uses would prove nothing. `SHORT_OF_LIGHT` and `FAR_OFF` show what another
/// renderer does, `FEW_SURFACES` reaches a bound, `TILTED_BACK` is found in `tests/render/relief.rs`, `TURNED_TO_HOLE` in
/// `tests/render/facing.rs`, `WRONG_DIRECTION` and `STRAIGHT_SHADES` in `tests/render/passages.rs`, and the faults of media and of instances need such scenes; they have tests of their own.
#[test]
fn every_mutation_is_a_fault_or_harmless() {
    let used = FAULTS.iter().map(|fault| &fault.0).chain(HARMLESS.iter().map(|harmless| &harmless.0));
    let elsewhere =
        [SHORT_OF_LIGHT, FAR_OFF, FEW_SURFACES, STRAIGHT_SHADES, TILTED_BACK, TURNED_TO_HOLE, WRONG_DIRECTION]
            .into_iter()
            .chain(OF_MEDIA)
            .chain(INSTANCE_FAULTS)
            .chain(MOTION_FAULTS)
            .chain(DEFORMING_FAULTS);
    let used: Vec<_> = used.filter_map(|subject| subject.mutation).chain(elsewhere).collect();
    let unused: Vec<_> = tampered::MUTATIONS.iter().map(|m| m.name).filter(|name| !used.contains(name)).collect();
    assert!(unused.is_empty(), "{unused:?}");
}
