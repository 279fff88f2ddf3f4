//! Adaptive sampling: after every step, a tile of the film is sampled further only if it is still noisy.

use std::sync::Arc;

use crate::Result;
use crate::film::noise::{NoiseReport, TileNoise, Tiles};
use crate::generated::constants::{TILE_PIXELS, TILE_SIDE};
use crate::generated::layout::JudgePush;
use crate::gpu::{Context, Kernel};
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::sets::Sets;
use crate::renderer::trace::slices::Slicer;
use crate::settings::Settings;

/// Part of the samples taken so far beyond which no step is lengthened, as a divisor.
const LONGEST_PART: u32 = 4;

/// Which tiles are sampled, and why.
pub(crate) struct Adaptive {
    kernel: Kernel,
    tiles: Tiles,
    sampled_pixels: u64,
    /// Whether each tile of the film is sampled.
    going_on: Vec<bool>,
    report: NoiseReport,
}

impl Adaptive {
    /// Adaptive sampling whose tiles are all sampled so far. `kernel` judges how noisy they are.
    pub fn new(kernel: Kernel, settings: &Settings, target: f32) -> Self {
        let (tiles, going_on) = tiles_of(settings);
        Self { kernel, sampled_pixels: tiles.all_pixels(), tiles, going_on, report: NoiseReport::unknown(target) }
    }

    /// Begins anew, for a film of perhaps another size. All tiles are then to be chosen by [`Adaptive::restart`].
    pub fn begin_anew(&mut self, settings: &Settings) {
        (self.tiles, self.going_on) = tiles_of(settings);
    }

    /// Chooses all tiles again, as at the beginning.
    pub fn restart(&mut self, pages: &[FilmPage]) -> Result<()> {
        (self.sampled_pixels, self.report) = (self.tiles.all_pixels(), NoiseReport::unknown(self.report.target));
        self.going_on.fill(true);
        pages.iter().try_for_each(FilmPage::sample_all)
    }

    /// Pixels that are sampled.
    pub fn sampled_pixels(&self) -> u64 {
        self.sampled_pixels
    }

    pub fn report(&self) -> NoiseReport {
        self.report
    }

    /// Factor by which a step is longer than its `usual` samples. The guide so learns from about as many paths as when all
    /// tiles are sampled, but no step is lengthened beyond a quarter of all steps before.
    pub fn lengthening(&self, samples_done: u32, usual: u32) -> u32 {
        let wanted = self.tiles.all_pixels() / self.sampled_pixels.max(1);
        let most = samples_done / usual.saturating_mul(LONGEST_PART).max(1);
        wanted.min(most.into()).max(1) as u32
    }

    /// Chooses anew which tiles are sampled. The choice depends on the film alone.
    pub fn judge(&mut self, context: &Arc<Context>, slicer: &Slicer, sets: &Sets) -> Result<()> {
        let pages = sets.frame.pages();
        let sets_of_pages: Vec<_> = pages.iter().map(|page| sets.of_page(page)).collect::<Result<_>>()?;
        context.submit(self.kernel.name(), |recorder| {
            for (page, sets) in pages.iter().zip(&sets_of_pages) {
                for range in slicer.ranges(0..page.tile_count()) {
                    let push = JudgePush { first_tile: range.start };
                    let groups = [range.end - range.start, 1, 1];
                    recorder.dispatch(&self.kernel, sets, bytemuck::bytes_of(&push), groups);
                }
            }
        })?;
        let noise: Vec<Vec<TileNoise>> = pages.iter().map(FilmPage::tile_noise).collect::<Result<_>>()?;
        let errors = self.tiles.relative_errors(&noise.concat());
        let going_on = self.tiles.going_on(&errors, self.report.target.into());
        sample(pages, &going_on)?;
        self.note(&errors, &going_on);
        self.going_on = going_on;
        Ok(())
    }

    /// Whether each tile of the film is sampled, a byte each.
    pub fn going_on(&self) -> Vec<u8> {
        self.going_on.iter().map(|&goes_on| u8::from(goes_on)).collect()
    }

    /// Takes over which tiles another device has chosen, a byte each, and samples those of `pages`.
    pub fn go_on(&mut self, tiles: &[u8], pages: &[FilmPage]) -> Result<()> {
        self.going_on.iter_mut().zip(tiles).for_each(|(goes_on, &tile)| *goes_on = tile != 0);
        sample(pages, &self.going_on)
    }

    fn note(&mut self, errors: &[f64], going_on: &[bool]) {
        let sampled = (0..going_on.len()).filter(|&tile| going_on[tile]);
        self.sampled_pixels = sampled.map(|tile| u64::from(self.tiles.pixels(tile))).sum();
        let mean_square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
        self.report.largest = errors.iter().copied().max_by(f64::total_cmp);
        self.report.mean = Some(mean_square.sqrt());
        self.report.sampled_share = self.sampled_pixels as f64 / self.tiles.all_pixels() as f64;
    }
}

/// Tiles of the film, all of which are sampled.
fn tiles_of(settings: &Settings) -> (Tiles, Vec<bool>) {
    let window = settings.window();
    let count = (window.width.div_ceil(TILE_SIDE) * window.height.div_ceil(TILE_SIDE)) as usize;
    (Tiles::new(window.width, window.height, TILE_SIDE), vec![true; count])
}

/// Chooses the tiles whose entry in `going_on` is true.
fn sample(pages: &[FilmPage], going_on: &[bool]) -> Result<()> {
    for page in pages {
        let first = page.first_pixel() / TILE_PIXELS;
        let tiles = (0..page.tile_count()).filter(|tile| going_on[(first + tile) as usize]);
        page.sample(&tiles.collect::<Vec<_>>())?;
    }
    Ok(())
}
