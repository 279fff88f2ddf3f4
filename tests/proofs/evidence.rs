//! Evidence for or against a claim: p-values, and statements that must hold exactly. Both are written to a folder.

use std::fmt::{Display, Write as _};
use std::fs;
use std::path::{Path, PathBuf};

use lodestar::image::{Image, ToneCurve, png};

/// Chance that the whole suite fails although everything is right.
pub const FALSE_ALARM: f64 = 1.0e-4;
/// Maximum number of p-values of the whole suite. Each claim declares its own maximum.
pub const MOST_TESTS: usize = 50_000;

/// The p-value below which a single test fails (Sidak 1967).
pub fn level() -> f64 {
    -((-FALSE_ALARM).ln_1p() / MOST_TESTS as f64).exp_m1()
}

/// Record that a failing test keeps.
pub enum Record {
    /// Observed and expected numbers of samples in every cell.
    Histogram(Vec<u64>, Vec<f64>),
    /// The picture, and the picture that it was compared with, if there is one.
    Pictures(Vec<Image>),
    Nothing,
}

/// The strongest evidence against a claim.
#[derive(Debug, Clone)]
pub struct Finding {
    pub case: String,
    /// P-value; `None` for an exact statement that does not hold.
    pub p: Option<f64>,
}

/// Results of all tests of one claim about one subject.
pub struct Evidence {
    claim: &'static str,
    folder: PathBuf,
    log: String,
    failures: Vec<String>,
    least: (f64, String),
    first_untrue: Option<String>,
    /// Number of p-values so far.
    pub tests: usize,
    /// Number of exact statements so far.
    pub statements: usize,
}

impl Evidence {
    pub fn new(claim: &'static str, subject: &str) -> Self {
        let name = |text: &str| text.replace(|c: char| !c.is_ascii_alphanumeric(), "-");
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/proofs").join(name(subject)).join(name(claim));
        let least = (1.0, String::new());
        let (log, failures) = (String::new(), Vec::new());
        Self { claim, folder, log, failures, least, first_untrue: None, tests: 0, statements: 0 }
    }

    /// Adds a statistical test. `record` is called if the test fails.
    pub fn test(&mut self, case: impl Display, p: f64, record: impl FnOnce() -> Record) {
        self.tests += 1;
        let _ = writeln!(self.log, "{p:.3e}\t{case}");
        // A p-value that is not a number counts as a failure.
        let p = if p.is_nan() { 0.0 } else { p };
        if p < self.least.0 {
            self.least = (p, case.to_string());
        }
        if p < level() {
            self.keep(&record());
            self.failures.push(format!("{case}: p = {p:.2e}"));
        }
    }

    /// Adds a statement that must hold. `otherwise` describes how it fails.
    pub fn hold(&mut self, case: impl Display, holds: bool, otherwise: impl FnOnce() -> String) {
        self.statements += 1;
        if !holds {
            let what = format!("{case}: {}", otherwise());
            let _ = writeln!(self.log, "does not hold\t{what}");
            self.first_untrue.get_or_insert_with(|| what.clone());
            self.failures.push(what);
        }
    }

    /// Whether any test or statement has failed.
    pub fn is_refuted(&self) -> bool {
        !self.failures.is_empty()
    }

    /// The least p-value.
    pub fn least(&self) -> f64 {
        self.least.0
    }

    /// The failure that refutes the claim: the smallest p-value below the level, or else the first statement that does
    /// not hold.
    pub fn finding(&self) -> Option<Finding> {
        if self.least.0 < level() {
            return Some(Finding { case: self.least.1.clone(), p: Some(self.least.0) });
        }
        self.first_untrue.clone().map(|case| Finding { case, p: None })
    }

    /// Writes all p-values. Returns the folder, which also holds the records of failures.
    pub fn write(&self) -> &Path {
        fs::create_dir_all(&self.folder).expect("a folder below target");
        fs::write(self.folder.join("p-values.tsv"), &self.log).expect("written");
        &self.folder
    }

    /// Fails if the claim is refuted.
    pub fn judge(&self) {
        let folder = self.write().display();
        println!(
            "{}: {} tests, {} statements, least p = {:.2e}",
            self.claim, self.tests, self.statements, self.least.0
        );
        assert!(self.tests + self.statements > 0, "{}: nothing was tested", self.claim);
        let first = self.failures.iter().take(5).map(String::as_str).collect::<Vec<_>>().join("\n  ");
        assert!(
            !self.is_refuted(),
            "{}: {} of {} tests fail at the level {:.1e}. All p-values, and histograms and pictures of the first failures, \
             are in {folder}. The first failures:\n  {first}",
            self.claim,
            self.failures.len(),
            self.tests + self.statements,
            level()
        );
    }

    /// Keeps the record of a failure. Only the first few are kept, because records are large.
    fn keep(&self, record: &Record) {
        const MOST_RECORDS: usize = 4;
        let number = self.failures.len();
        if number >= MOST_RECORDS {
            return;
        }
        fs::create_dir_all(&self.folder).expect("a folder below target");
        let path = |name: &str| self.folder.join(format!("failure-{number}{name}"));
        match record {
            Record::Histogram(observed, expected) => {
                let rows = observed.iter().zip(expected).map(|(o, e)| format!("{o}\t{e:.3}\n"));
                fs::write(path(".histogram.tsv"), format!("observed\texpected\n{}", rows.collect::<String>()))
                    .expect("written");
            }
            Record::Pictures(images) => {
                for (image, name) in images.iter().zip(["-found.png", "-expected.png"]) {
                    png::write(&path(name), image, ToneCurve::Srgb, 0.0).expect("written");
                }
            }
            Record::Nothing => {}
        }
    }
}

#[test]
fn the_suite_rarely_fails_by_chance() {
    let all_pass = (1.0 - level()).powi(MOST_TESTS as i32);
    assert!((all_pass - (1.0 - FALSE_ALARM)).abs() < 1.0e-9, "{all_pass}");
}

#[test]
fn evidence_is_refuted_by_what_is_improbable_only() {
    let found = |p: f64| {
        let mut evidence = Evidence::new("evidence", "itself");
        evidence.test("a test", 0.5, || Record::Nothing);
        evidence.test("another", p, || Record::Nothing);
        (evidence.is_refuted(), evidence.finding().and_then(|finding| finding.p))
    };
    assert_eq!(found(1.0e-8), (false, None));
    assert_eq!(found(1.0e-10), (true, Some(1.0e-10)));
    assert_eq!(found(f64::NAN), (true, Some(0.0)));
    let mut evidence = Evidence::new("evidence", "itself");
    evidence.test("a histogram", 0.0, || Record::Histogram(vec![7], vec![9.0]));
    assert_eq!(
        fs::read_to_string(evidence.write().join("failure-0.histogram.tsv")).expect("kept"),
        "observed\texpected\n7\t9.000\n"
    );
    let mut evidence = Evidence::new("evidence", "itself");
    evidence.hold("a statement", false, || "it is not so".into());
    assert!(
        evidence.is_refuted()
            && evidence.finding().is_some_and(|f| f.p.is_none() && f.case == "a statement: it is not so")
    );
}
