//! Gathering the film: the tiles of all devices are copied into the film of the first one.

use std::ops::Range;

use crate::Result;
use crate::film::Picture;
use crate::fleet::Fleet;
use crate::fleet::command::{Command, lead};
use crate::renderer::Renderer;
use crate::renderer::share::Share;
use crate::renderer::shared::Film;

impl Fleet {
    /// Reads the film of all devices back.
    ///
    /// # Errors
    /// Where a device is lost.
    pub fn picture(&self) -> Result<Picture> {
        self.gathered()?.picture()
    }

    /// The first device, with the film of all of them.
    ///
    /// # Errors
    /// Where a device is lost.
    pub(crate) fn gathered(&self) -> Result<&Renderer> {
        lead(self.team.as_deref(), || Command::Film, || self.gather_film())?;
        Ok(&self.first)
    }

    /// Number of samples that all pixels of the film have together.
    ///
    /// # Errors
    /// Where a device is lost.
    pub fn samples_in_film(&self) -> Result<u64> {
        self.gathered()?.samples_in_film()
    }

    /// Copies the tiles of all devices of all ranks into the film of the first device of the first rank.
    pub(super) fn gather_film(&self) -> Result<()> {
        if self.is_alone() { Ok(()) } else { self.gather_clock.time(|| self.copy_tiles()) }
    }

    fn copy_tiles(&self) -> Result<()> {
        let film = self.film_of_devices();
        let Some(team) = &self.team else { return self.first.write_film(&film?) };
        if !team.leads() {
            let tiles = film.map(|film| self.packed(&film, self.shares()));
            return team.meet(tiles, &|| false, |_| Ok(Vec::new())).map(drop);
        }
        let (mut film, own) = match film {
            Ok(film) => (film, Ok(Vec::new())),
            Err(error) => (Film::new(), Err(error)),
        };
        let take = |reports: Vec<Vec<u8>>| {
            for (rank, tiles) in reports.iter().enumerate().skip(1) {
                self.unpack(&mut film, &self.dealt[team.devices(rank)], tiles);
            }
            self.first.write_film(&film)?;
            Ok(Vec::new())
        };
        team.meet(own, &|| false, take).map(drop)
    }

    /// The film of the first device of this process, with the tiles of its other devices.
    fn film_of_devices(&self) -> Result<Film> {
        let mut film = self.first.read_film()?;
        for (&share, other) in self.shares().iter().skip(1).zip(&self.others) {
            let theirs = other.read_film().map_err(|error| other.named(error))?;
            for (part, theirs) in film.iter_mut().zip(&theirs) {
                for bytes in self.tiles(part.len(), share) {
                    part[bytes.clone()].copy_from_slice(&theirs[bytes]);
                }
            }
        }
        Ok(film)
    }

    /// Bytes of the tiles of `shares`, part by part.
    fn packed(&self, film: &Film, shares: &[Share]) -> Vec<u8> {
        let mut packed = Vec::new();
        for part in film {
            for bytes in shares.iter().flat_map(|&share| self.tiles(part.len(), share)) {
                packed.extend_from_slice(&part[bytes]);
            }
        }
        packed
    }

    /// Copies tiles that [`Fleet::packed`] has packed into a film.
    fn unpack(&self, film: &mut Film, shares: &[Share], mut packed: &[u8]) {
        for part in film {
            let length = part.len();
            for bytes in shares.iter().flat_map(|&share| self.tiles(length, share)) {
                // A rank of the same program has as many bytes.
                let (tile, rest) = packed.split_at(bytes.len().min(packed.len()));
                part[bytes.start..bytes.start + tile.len()].copy_from_slice(tile);
                packed = rest;
            }
        }
    }

    /// Ranges of the bytes of a share's tiles, in a part of the film with so many bytes.
    fn tiles(&self, part_bytes: usize, share: Share) -> impl Iterator<Item = Range<usize>> + use<> {
        let tiles = self.first.tile_count();
        let bytes = part_bytes / tiles as usize;
        let own = (0..tiles).filter(move |&tile| share.holds(tile));
        own.map(move |tile| tile as usize * bytes..(tile as usize + 1) * bytes)
    }
}
