//! Shares of the film: the tiles that each device traces.

use std::ops::Range;

/// Tiles of a film that one of several devices traces: in every run of `period` tiles, those from `first` on, `width` of them. So all
/// devices meet bright and dark regions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Share {
    pub first: u32,
    pub width: u32,
    pub period: u32,
}

impl Share {
    /// All tiles, for a device that renders alone.
    pub const ALL: Self = Self { first: 0, width: 1, period: 1 };

    /// The shares of devices with these weights. A device of weight 0 has no tile. At least one weight must be above 0.
    pub fn by_weights(weights: &[u32]) -> Vec<Self> {
        let period = weights.iter().sum();
        let before = weights.iter().scan(0, |end, &width| Some(std::mem::replace(end, *end + width)));
        before.zip(weights).map(|(first, &width)| Self { first, width, period }).collect()
    }

    /// Whether the tile with this index in the film belongs to the share.
    pub fn holds(self, tile: u32) -> bool {
        self.range().contains(&(tile % self.period))
    }

    /// Number of the share's tiles before this one of the film.
    pub fn tiles_before(self, tile: u32) -> u32 {
        tile / self.period * self.width + (tile % self.period).saturating_sub(self.first).min(self.width)
    }

    fn range(self) -> Range<u32> {
        self.first..self.first + self.width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_belongs_to_one_share() {
        for weights in [&[1][..], &[1, 1], &[1, 1, 1], &[3, 1], &[2, 0, 5], &[0, 1]] {
            let shares = Share::by_weights(weights);
            let mut owned = vec![0; weights.len()];
            for tile in 0..40 {
                assert_eq!(shares.iter().filter(|share| share.holds(tile)).count(), 1, "{weights:?}, tile {tile}");
                for (share, owned) in shares.iter().zip(&mut owned) {
                    assert_eq!(share.tiles_before(tile), *owned, "{weights:?}, tile {tile}");
                    *owned += u32::from(share.holds(tile));
                }
            }
        }
    }

    /// The kernels' formula (`glsl/include/film/slice.glsl`) names the share's tiles in their order.
    #[test]
    fn the_formula_of_the_kernels_names_the_tiles_of_a_share() {
        for share in Share::by_weights(&[3, 1, 4]).into_iter().chain([Share::ALL]) {
            let by_formula = (0..20).map(|own| own / share.width * share.period + own % share.width + share.first);
            let by_test = (0..).filter(|&tile| share.holds(tile)).take(20);
            assert!(by_formula.eq(by_test), "{share:?}");
        }
    }
}
