//! Right pictures of the scenes, from `references.tsv`.

use std::collections::HashMap;

use flate2::Crc;

use crate::table::{self, Case, Reference};
use crate::verdict::{BLOCKS, Blocks};

/// Blocks of Mitsuba's pictures by the scene's name.
pub struct References(HashMap<String, Blocks>);

/// Checksum of a scene's text, as `make.py` writes it.
fn checksum(text: &str) -> String {
    let mut crc = Crc::new();
    crc.update(text.as_bytes());
    format!("{:08x}", crc.sum())
}

impl References {
    /// Reads all rows. A row whose scene has another text is an error.
    pub fn read() -> Self {
        let checksums: HashMap<String, String> =
            table::all().into_iter().map(|case| (case.name, checksum(&case.xml))).collect();
        let row = |line: &str| {
            let cells: Vec<&str> = line.split('\t').collect();
            let known = checksums.get(cells[0]).is_some_and(|own| own == cells[1]);
            assert!(known, "the row of {} in references.tsv is of another scene; run make.py again", cells[0]);
            (cells[0].to_owned(), blocks(&cells[2..]))
        };
        Self(include_str!("references.tsv").lines().map(row).collect())
    }

    /// The right picture of a scene.
    pub fn of(&self, case: &Case) -> Blocks {
        let name = match case.reference {
            Reference::Uniform(color) => return Blocks::uniform(color),
            Reference::Like(name) => name,
            Reference::Mitsuba => &case.name,
        };
        self.0.get(name).unwrap_or_else(|| panic!("references.tsv has no row {name}; run make.py")).clone()
    }
}

/// Blocks of the cells of a row: mean and standard error of each channel of each block.
fn blocks(cells: &[&str]) -> Blocks {
    assert_eq!(cells.len(), BLOCKS * 6, "the cells of a row");
    let mut blocks = Blocks::uniform([0.0; 3]);
    for (at, pair) in cells.chunks_exact(2).enumerate() {
        let [mean, error] = [pair[0], pair[1]].map(|cell| cell.parse::<f64>().expect("a number"));
        blocks.mean[at / 3][at % 3] = mean;
        blocks.variance[at / 3][at % 3] = error * error;
    }
    blocks
}
