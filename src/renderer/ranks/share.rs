//! Shares of the film: the tiles that each device traces.

/// Tiles of a film that one of several devices traces: every `ranks`-th tile, so that all devices meet bright and dark regions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Share {
    pub rank: u32,
    pub ranks: u32,
}

impl Share {
    /// All tiles, for a device that renders alone.
    pub const ALL: Self = Self { rank: 0, ranks: 1 };

    /// Whether the tile with this index in the film belongs to the share.
    pub fn holds(self, tile: u32) -> bool {
        tile % self.ranks == self.rank
    }

    /// Distance from a tile of the film to the share's next one.
    pub fn first_from(self, tile: u32) -> u32 {
        (self.rank + self.ranks - tile % self.ranks) % self.ranks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_belongs_to_one_share() {
        for ranks in 1..6 {
            let shares: Vec<_> = (0..ranks).map(|rank| Share { rank, ranks }).collect();
            for tile in 0..40 {
                assert_eq!(shares.iter().filter(|share| share.holds(tile)).count(), 1);
                for share in &shares {
                    let distance = share.first_from(tile);
                    assert!(distance < ranks && share.holds(tile + distance));
                }
            }
        }
    }
}
