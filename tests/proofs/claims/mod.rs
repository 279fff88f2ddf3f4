//! The claims, one file each. Each claim can be tested for any subject and any part of the table.

pub mod densities;
pub mod devices;
pub mod directions;
pub mod doors;
pub mod emitters;
pub mod entries;
pub mod furnace;
pub mod patterns;
pub mod pictures;
pub mod roulette;
pub mod samples;
pub mod sums;
pub mod targets;
pub mod trees;
pub mod updates;

use crate::evidence::Evidence;
use crate::rows::Scope;
use crate::subject::{SHIPPED, Subject};

/// One claim.
#[derive(Clone, Copy)]
pub struct Claim {
    pub name: &'static str,
    test: fn(&Subject, Scope, &mut Evidence),
    /// Maximum number of p-values of this claim, in the full form.
    pub most_tests: usize,
}

pub const SAMPLES: Claim = Claim { name: "samples", test: samples::test, most_tests: 8000 };
pub const DENSITIES: Claim = Claim { name: "densities", test: densities::test, most_tests: 0 };
pub const DIRECTIONS: Claim = Claim { name: "directions", test: directions::test, most_tests: 5000 };
pub const SUMS: Claim = Claim { name: "sums", test: sums::test, most_tests: 100 };
pub const UPDATES: Claim = Claim { name: "updates", test: updates::test, most_tests: 0 };
pub const ENTRIES: Claim = Claim { name: "entries", test: entries::test, most_tests: 0 };
pub const DOORS: Claim = Claim { name: "doors", test: doors::test, most_tests: 0 };
pub const TREES: Claim = Claim { name: "trees", test: trees::test, most_tests: 0 };
pub const TARGETS: Claim = Claim { name: "targets", test: targets::test, most_tests: 1000 };
pub const FURNACE: Claim = Claim { name: "furnace", test: furnace::test, most_tests: 500 };
pub const PICTURES: Claim = Claim { name: "pictures", test: pictures::test, most_tests: 500 };
pub const PATTERNS: Claim = Claim { name: "patterns", test: patterns::test, most_tests: 100 };
pub const ROULETTE: Claim = Claim { name: "roulette", test: roulette::test, most_tests: 100 };
pub const EMITTERS: Claim = Claim { name: "emitters", test: emitters::test, most_tests: 500 };
pub const DEVICES: Claim = Claim { name: "devices", test: devices::test, most_tests: 0 };

pub const ALL: [Claim; 15] = [
    SAMPLES, DENSITIES, DIRECTIONS, SUMS, UPDATES, ENTRIES, DOORS, TREES, TARGETS, FURNACE, PICTURES, PATTERNS,
    ROULETTE, EMITTERS, DEVICES,
];

impl Claim {
    pub fn examine(&self, subject: &Subject, scope: Scope) -> Evidence {
        let mut evidence = Evidence::new(self.name, subject.name);
        (self.test)(subject, scope, &mut evidence);
        assert!(evidence.tests <= self.most_tests, "{}: {} tests are more than it may have", self.name, evidence.tests);
        evidence
    }
}

fn prove(claim: Claim) {
    claim.examine(&SHIPPED, Scope::of_this_run()).judge();
}

#[test]
fn samples() {
    prove(SAMPLES);
}

#[test]
fn densities() {
    prove(DENSITIES);
}

#[test]
fn directions() {
    prove(DIRECTIONS);
}

#[test]
fn sums() {
    prove(SUMS);
}

#[test]
fn updates() {
    prove(UPDATES);
}

#[test]
fn entries() {
    prove(ENTRIES);
}

#[test]
fn doors() {
    prove(DOORS);
}

#[test]
fn trees() {
    prove(TREES);
}

#[test]
fn targets() {
    prove(TARGETS);
}

#[test]
fn furnace() {
    prove(FURNACE);
}

#[test]
fn pictures() {
    prove(PICTURES);
}

#[test]
fn patterns() {
    prove(PATTERNS);
}

#[test]
fn roulette() {
    prove(ROULETTE);
}

#[test]
fn emitters() {
    prove(EMITTERS);
}

#[test]
fn devices() {
    prove(DEVICES);
}
