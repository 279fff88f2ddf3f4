//! Lobe of a sheen of microfibers (Zeltner, Burley and Chiang 2022): a cosine lobe under a linear transformation, as a table of words.

mod table;

use crate::generated::constants::SHEEN_ENTRIES;

const ENTRIES: usize = SHEEN_ENTRIES as usize;

/// Numbers of the lobe at an entry of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// Inverse transformation: factor of directions along the surface.
    pub stretch: f64,
    /// Inverse transformation: what a direction along the normal adds to those along the surface, toward the viewer.
    pub shift: f64,
    /// Share of light that a white sheen reflects.
    pub albedo: f64,
}

/// Entry of the table.
pub fn entry(roughness: usize, cosine: usize) -> Lobe {
    let [stretch, shift, albedo] =
        [table::STRETCHES, table::SHIFTS, table::ALBEDOS].map(|table| f64::from(table[roughness][cosine]) / 65535.0);
    Lobe { stretch, shift: -shift, albedo }
}

/// Words of the table, two for each entry: its numbers, the first in the lower half.
pub fn words() -> Vec<u32> {
    let tables = [table::STRETCHES, table::SHIFTS, table::ALBEDOS];
    let entries = (0..ENTRIES * ENTRIES).map(|at| tables.map(|table| u32::from(table[at / ENTRIES][at % ENTRIES])));
    entries.flat_map(|[stretch, shift, albedo]| [stretch | shift << 16, albedo]).collect()
}
