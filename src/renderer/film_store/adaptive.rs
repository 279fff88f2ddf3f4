//! Adaptive sampling: after every step, tiles of the film are judged, and those that are quiet enough are left alone.

use std::sync::Arc;

use crate::Result;
use crate::film::noise::{NoiseReport, TileNoise, Tiles};
use crate::generated::constants::{TILE_PIXELS, TILE_SIDE};
use crate::generated::layout::JudgePush;
use crate::gpu::{Context, DescriptorSet, Kernel};
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::trace::slices::Slicer;
use crate::settings::Settings;
use crate::settings::schedule::PARTS;

/// Which tiles are sampled, and why.
pub(crate) struct Adaptive {
    kernel: Kernel,
    tiles: Tiles,
    sampled_pixels: u64,
    report: NoiseReport,
}

impl Adaptive {
    /// Judges by `kernel`; all tiles are sampled so far.
    pub fn new(kernel: Kernel, settings: &Settings, target: f32) -> Self {
        let window = settings.window();
        let tiles = Tiles::new(window.width, window.height, TILE_SIDE);
        Self { kernel, tiles, sampled_pixels: tiles.all_pixels(), report: NoiseReport::unknown(target) }
    }

    /// Has all tiles sampled, as at the beginning.
    pub fn restart(&mut self, pages: &[FilmPage]) -> Result<()> {
        (self.sampled_pixels, self.report) = (self.tiles.all_pixels(), NoiseReport::unknown(self.report.target));
        pages.iter().try_for_each(FilmPage::sample_all)
    }

    /// Pixels that are sampled.
    pub fn sampled_pixels(&self) -> u64 {
        self.sampled_pixels
    }

    pub fn report(&self) -> NoiseReport {
        self.report
    }

    /// A step of `usual` samples takes so many times as many: the guide is to learn from about as many paths, but no step is
    /// longer than a quarter of those before.
    pub fn lengthening(&self, samples_done: u32, usual: u32) -> u32 {
        let wanted = self.tiles.all_pixels() / self.sampled_pixels.max(1);
        let most = samples_done / usual.saturating_mul(PARTS).max(1);
        wanted.min(most.into()).max(1) as u32
    }

    /// Decides anew which tiles are sampled, by nothing but the film. The kernel is dispatched with each page's set and these of the renderer's.
    pub fn judge(
        &mut self,
        context: &Arc<Context>,
        slicer: &Slicer,
        pages: &[FilmPage],
        [geometry, radiance_grid, normalization_grid]: [&DescriptorSet; 3],
    ) -> Result<()> {
        context.submit(self.kernel.name(), |recorder| {
            for page in pages {
                let sets = [page.set(), geometry, radiance_grid, normalization_grid];
                for range in slicer.ranges(0..page.tile_count()) {
                    let push = JudgePush { first_tile: range.start };
                    let groups = [range.end - range.start, 1, 1];
                    recorder.dispatch(&self.kernel, &sets, bytemuck::bytes_of(&push), groups);
                }
            }
        })?;
        let noise: Vec<Vec<TileNoise>> = pages.iter().map(FilmPage::tile_noise).collect::<Result<_>>()?;
        let errors = self.tiles.relative_errors(&noise.concat());
        let going_on = self.tiles.going_on(&errors, self.report.target.into());
        for page in pages {
            let first = page.first_pixel() / TILE_PIXELS;
            let tiles = (0..page.tile_count()).filter(|tile| going_on[(first + tile) as usize]);
            page.sample(&tiles.collect::<Vec<_>>())?;
        }
        self.note(&errors, &going_on);
        Ok(())
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
