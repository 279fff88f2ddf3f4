//! A light before it has a record.

use crate::generated::constants;

/// Light whose probability is not known yet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// One of `LIGHT_*`.
    pub kind: u32,
    /// Primitive of an area light, first texel of a delta light, or patch of an environment.
    pub index: u32,
    /// Power in W, times the emitter's sampling weight.
    pub power: f64,
}

impl Candidate {
    /// Word of the light's record that holds both.
    pub fn kind_and_index(&self) -> u32 {
        self.kind << constants::LIGHT_KIND_SHIFT | self.index
    }

    /// The light cut into so many parts of equal power.
    pub fn in_parts(self, count: usize) -> impl Iterator<Item = Self> {
        std::iter::repeat_n(Self { power: self.power / count as f64, ..self }, count)
    }
}
