//! Work that a fleet has each of its devices do, so that several devices render one picture.

use super::Renderer;
use crate::generated::constants::TILE_PIXELS;
use crate::generated::layout::RadianceSum;
use crate::renderer::film_store::FilmStore;
use crate::renderer::film_store::adaptive::Adaptive;
use crate::renderer::film_store::pages::padded_pixels;
use crate::renderer::film_store::part_sums::clear_film;
use crate::renderer::share::Share;
use crate::settings::Settings;
use crate::{Error, Result};

/// Contents of the parts of a device's film, tile by tile.
pub(crate) type Film = Vec<Vec<u8>>;

/// The film of a device that holds a share of it.
impl Renderer {
    /// Leaves the tiles outside `share` to other devices.
    pub(crate) fn deal(&self, share: Share) -> Result<()> {
        self.sets.frame.pages().iter().try_for_each(|page| page.deal(share))
    }

    /// Number of the film's tiles.
    pub(crate) fn tile_count(&self) -> u32 {
        (padded_pixels(&self.settings) / u64::from(TILE_PIXELS)) as u32
    }

    pub(crate) fn read_film(&self) -> Result<Film> {
        self.sets.frame.persistent().iter().map(|part| part.read()).collect()
    }

    pub(crate) fn write_film(&self, film: &Film) -> Result<()> {
        self.sets.frame.persistent().iter().zip(film).try_for_each(|(part, bytes)| part.write(bytes))
    }

    /// Begins this device's film anew, where another device adds it to sums of steps.
    pub(crate) fn clear_part(&self) -> Result<()> {
        match &self.film_store {
            FilmStore::Part(_) => clear_film(&self.context, &self.sets.frame),
            FilmStore::Plain | FilmStore::Adaptive(_) => Ok(()),
        }
    }

    /// Whether the end of a step needs the whole film.
    pub(crate) fn settles_film(&self) -> bool {
        !matches!(self.film_store, FilmStore::Plain)
    }

    /// Whether each tile of the film is sampled, a byte each. Empty where noise ends no tiles.
    pub(crate) fn tiles_going_on(&self) -> Vec<u8> {
        self.film_store.adaptive().map(Adaptive::going_on).unwrap_or_default()
    }

    /// Samples the tiles that another device has chosen.
    pub(crate) fn go_on_with(&mut self, tiles: &[u8]) -> Result<()> {
        match &mut self.film_store {
            FilmStore::Adaptive(adaptive) => adaptive.go_on(tiles, self.sets.frame.pages()),
            FilmStore::Plain | FilmStore::Part(_) => Ok(()),
        }
    }
}

/// The sums that a device has learned to learn from.
impl Renderer {
    /// Sums of learning targets, and marks of the normalizers that were asked for.
    pub(crate) fn target_sums(&self) -> Result<(Vec<RadianceSum>, Vec<u32>)> {
        let sums = self.sets.radiance_grid.target_sums();
        let marks = self.sets.normalization_grid.marks();
        let sums = sums.read(0, sums.len_bytes() as usize / size_of::<RadianceSum>())?;
        Ok((sums, marks.read(0, marks.len_bytes() as usize / size_of::<u32>())?))
    }

    /// Replaces the sums of learning targets.
    pub(crate) fn set_target_sums(&self, sums: &[RadianceSum]) -> Result<()> {
        self.sets.radiance_grid.target_sums().upload(0, sums)
    }

    /// Replaces the marks of normalizers.
    pub(crate) fn set_marks(&self, marks: &[u32]) -> Result<()> {
        self.sets.normalization_grid.marks().upload(0, marks)
    }

    /// Clears the sums of learning targets.
    pub(crate) fn clear_target_sums(&self) -> Result<()> {
        self.sets.radiance_grid.clear_sums(&self.context)
    }

    /// Whether sums of learning targets outlive a step.
    pub(crate) fn keeps_target_sums(&self) -> bool {
        self.sets.radiance_grid.keeps_sums()
    }
}

/// The device itself.
impl Renderer {
    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Largest number of bytes that the device's buffers have held.
    pub(crate) fn peak_bytes(&self) -> u64 {
        self.context.peak_allocated_bytes()
    }

    /// An error that names this device.
    pub(crate) fn named(&self, error: Error) -> Error {
        let device = self.context.device();
        error.during(&format!("device {} ({})", device.index, device.name))
    }

    /// Notes that this device's share of a batch is complete, so that so many samples per pixel are taken.
    pub(crate) fn note_samples(&mut self, samples_done: u32) {
        self.samples_done = samples_done;
    }
}
