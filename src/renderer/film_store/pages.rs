//! The film on the device, in pages that one binding can hold. Pixels lie in tile order: tiles of 8 x 8 pixels row by row, and
//! in a tile its pixels row by row. A workgroup so writes to memory that lies together.

use std::cell::Cell;
use std::ops::Range;
use std::sync::Arc;

use crate::Result;
use crate::film::features::FEATURE_CHANNELS;
use crate::film::noise::TileNoise;
use crate::film::sums::PixelSums;
use crate::film::{PIXEL_BYTES, Picture};
use crate::generated::constants::{TILE_PIXELS, TILE_SIDE};
use crate::generated::layout::{FilmFeatures, FilmRadiance, TilePlaces};
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet};
use crate::renderer::persistent::Span;
use crate::renderer::share::Share;
use crate::scene::Crop;
use crate::settings::Settings;

const _: () = assert!(TILE_PIXELS == TILE_SIDE * TILE_SIDE);

/// Some tiles of the film, with the descriptor set through which kernels see them.
pub(crate) struct FilmPage {
    first_pixel: u32,
    pixel_count: u32,
    radiance: Arc<Buffer>,
    features: Arc<Buffer>,
    adaptive: Arc<Buffer>,
    sampled_tiles: Cell<u32>,
    /// Tiles of the film that this device traces.
    share: Cell<Share>,
    set: DescriptorSet,
}

/// The buffers of a page, before its set is made.
pub(crate) struct PageBuffers {
    first_pixel: u32,
    pixel_count: u32,
    pub radiance: Arc<Buffer>,
    pub features: Arc<Buffer>,
    /// Records of tiles, then of pixels: see `glsl/include/film/halves.glsl`. Nearly empty where noise does not end tiles.
    pub adaptive: Arc<Buffer>,
}

/// Number of pixels that are read from the device at a time: 16 MiB of them.
const READ_PIXELS: u32 = 1 << 18;

/// A word-quadruple of the adaptive buffer.
type Quadruple = [u32; 4];

impl PageBuffers {
    /// Buffers for all pages of the window.
    pub fn allocate(context: &Arc<Context>, settings: &Settings) -> Result<Vec<Self>> {
        let pixels = u32::try_from(padded_pixels(settings)).map_err(|_| too_large(&settings.window()))?;
        let bindable = context.device().limits.max_storage_buffer_bytes / size_of::<FilmRadiance>() as u64;
        let most = bindable.min(u64::from(settings.film_page_pixels.unwrap_or(u32::MAX))).min(1 << 24) as u32;
        let page_pixels = (most / TILE_PIXELS).max(1) * TILE_PIXELS;
        (0..pixels)
            .step_by(page_pixels as usize)
            .map(|first| Self::new(context, settings, first, page_pixels.min(pixels - first)))
            .collect()
    }

    fn new(context: &Arc<Context>, settings: &Settings, first_pixel: u32, pixel_count: u32) -> Result<Self> {
        let buffer_of = |name: &str, elements: u32, size: usize| {
            let bytes = u64::from(elements) * size as u64;
            Buffer::blank(context, &format!("{name} from pixel {first_pixel}"), bytes, BufferKind::Storage)
        };
        let buffer = |name, size| buffer_of(name, pixel_count, size);
        let quadruples = if settings.noise.is_some() { pixel_count / TILE_PIXELS + pixel_count } else { 1 };
        Ok(Self {
            first_pixel,
            pixel_count,
            radiance: buffer("film radiance", size_of::<FilmRadiance>())?,
            features: buffer("film features", size_of::<FilmFeatures>())?,
            adaptive: buffer_of("halves of the film", quadruples, size_of::<Quadruple>())?,
        })
    }

    /// The page, seen through `set`. All its tiles are sampled.
    pub fn with_set(self, set: DescriptorSet) -> Result<FilmPage> {
        let Self { first_pixel, pixel_count, radiance, features, adaptive } = self;
        let sampled_tiles = Cell::new(0);
        let share = Cell::new(Share::ALL);
        let page = FilmPage { first_pixel, pixel_count, radiance, features, adaptive, sampled_tiles, share, set };
        page.sample_all()?;
        Ok(page)
    }
}

impl FilmPage {
    /// Pixels, in tile order, before this page.
    pub fn first_pixel(&self) -> u32 {
        self.first_pixel
    }

    pub fn tile_count(&self) -> u32 {
        self.pixel_count / TILE_PIXELS
    }

    /// Number of the page's tiles that are sampled.
    pub fn sampled_tiles(&self) -> u32 {
        self.sampled_tiles.get()
    }

    /// Chooses all tiles to be sampled from now on.
    pub fn sample_all(&self) -> Result<()> {
        self.sample(&(0..self.tile_count()).collect::<Vec<_>>())
    }

    /// Leaves the tiles outside `share` to other devices, and chooses all tiles within it.
    pub fn deal(&self, share: Share) -> Result<()> {
        self.share.set(share);
        self.sample_all()
    }

    /// Places of the page's tiles that this device traces. Where noise ends tiles, a list names the tiles, and these are places in
    /// the list.
    pub fn tile_places(&self) -> TilePlaces {
        let (share, page) = match self.is_adaptive() {
            true => (Share::ALL, 0),
            false => (self.share.get(), self.first_tile()),
        };
        TilePlaces {
            own_before: share.tiles_before(page),
            first: share.first.wrapping_sub(page),
            // A share without tiles is never traced, but the kernels divide by its width.
            width: share.width.max(1),
            period: share.period,
        }
    }

    /// Tiles of the film before this page.
    fn first_tile(&self) -> u32 {
        self.first_pixel / TILE_PIXELS
    }

    /// Chooses the tiles that are sampled from now on. Tiles of other devices' shares are left out.
    pub fn sample(&self, tiles: &[u32]) -> Result<()> {
        let (share, first) = (self.share.get(), self.first_tile());
        let tiles: Vec<u32> = tiles.iter().copied().filter(|tile| share.holds(first + tile)).collect();
        self.sampled_tiles.set(tiles.len() as u32);
        if !self.is_adaptive() {
            return Ok(());
        }
        let records: Vec<Quadruple> = tiles.iter().map(|&tile| [tile, 0, 0, 0]).collect();
        self.adaptive.upload(0, &records)
    }

    /// Reads what `judge_noise` has found about each tile.
    pub fn tile_noise(&self) -> Result<Vec<TileNoise>> {
        let records: Vec<Quadruple> = self.adaptive.read(0, self.tile_count() as usize)?;
        let noise = |[_, squared_error, radiance, _]: Quadruple| TileNoise {
            squared_error: f32::from_bits(squared_error).into(),
            radiance: f32::from_bits(radiance).into(),
        };
        Ok(records.into_iter().map(noise).collect())
    }

    /// Memory of the halves of the pixels' samples.
    pub fn halves(&self) -> Span<'_> {
        let first = u64::from(self.tile_count()) * size_of::<Quadruple>() as u64;
        Span { buffer: &self.adaptive, bytes: first..self.adaptive.len_bytes() }
    }

    /// Whether noise ends tiles.
    pub fn is_adaptive(&self) -> bool {
        self.adaptive.len_bytes() > size_of::<Quadruple>() as u64
    }

    /// Set through which kernels see the page's buffers, which [`write_zeros`](Self::write_zeros) makes ready.
    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }

    /// Writes the zeros of an empty film, where no kernel has seen the page yet.
    pub fn write_zeros(&self) -> Result<()> {
        [&self.radiance, &self.features, &self.adaptive].into_iter().try_for_each(|buffer| buffer.write_zeros())
    }

    pub fn radiance(&self) -> &Buffer {
        &self.radiance
    }

    pub fn features(&self) -> &Buffer {
        &self.features
    }

    /// Writes the pixels with these indices where they belong in the picture, which begins with the window's row `first_row`. Some are
    /// read at a time, so that memory never holds them twice.
    pub fn read_into(
        &self,
        picture: &mut Picture,
        settings: &Settings,
        indices: &Range<u32>,
        first_row: u32,
    ) -> Result<()> {
        // Most neighbors have as many samples as each other. Nothing was sampled at first, which has no variance.
        let (mut samples, mut variance_scale) = (0, 0.0);
        for pixels in runs(self.within(indices)) {
            let (radiance, features) = (self.radiance_of(&pixels)?, self.features_of(&pixels)?);
            for (index, (radiance, features)) in (self.first_pixel + pixels.start..).zip(radiance.iter().zip(&features))
            {
                if let Some(at) = picture_index(index, picture, first_row) {
                    if radiance.sample_count != samples {
                        samples = radiance.sample_count;
                        variance_scale = settings.weight_sums(samples).variance_scale() as f32;
                    }
                    picture.set_moments(at, radiance, features, variance_scale);
                }
            }
        }
        Ok(())
    }

    /// Number of samples of all pixels of the window of this width and height.
    pub fn samples(&self, window: [u32; 2]) -> Result<u64> {
        let mut sum = 0;
        for pixels in runs(0..self.pixel_count) {
            let radiance = self.radiance_of(&pixels)?;
            let inside = (self.first_pixel + pixels.start..).zip(&radiance).filter(|&(index, _)| {
                let (x, y) = tile_order_pixel(index, window[0]);
                x < window[0] && y < window[1]
            });
            sum += inside.map(|(_, radiance)| u64::from(radiance.sample_count)).sum::<u64>();
        }
        Ok(sum)
    }

    /// The page's pixels among those with these indices, counted from its first one.
    fn within(&self, indices: &Range<u32>) -> Range<u32> {
        let place = |index: u32| index.saturating_sub(self.first_pixel).min(self.pixel_count);
        place(indices.start)..place(indices.end)
    }

    fn radiance_of(&self, pixels: &Range<u32>) -> Result<Vec<FilmRadiance>> {
        self.radiance.read(u64::from(pixels.start) * size_of::<FilmRadiance>() as u64, pixels.len())
    }

    fn features_of(&self, pixels: &Range<u32>) -> Result<Vec<FilmFeatures>> {
        self.features.read(u64::from(pixels.start) * size_of::<FilmFeatures>() as u64, pixels.len())
    }

    /// Reads the moments of the pixels with these indices, in tile order.
    pub fn read(&self, indices: &Range<u32>) -> Result<(Vec<FilmRadiance>, Vec<FilmFeatures>)> {
        let pixels = self.within(indices);
        Ok((self.radiance_of(&pixels)?, self.features_of(&pixels)?))
    }
}

/// Ranges of pixels that are read at a time.
fn runs(pixels: Range<u32>) -> impl Iterator<Item = Range<u32>> {
    let end = pixels.end;
    pixels.step_by(READ_PIXELS as usize).map(move |first| first..end.min(first + READ_PIXELS))
}

/// Index in the picture, which begins with the window's row `first_row`, of the pixel with an index in tile order; none beyond the
/// picture's border.
pub(crate) fn picture_index(index: u32, picture: &Picture, first_row: u32) -> Option<usize> {
    let (x, y) = tile_order_pixel(index, picture.width);
    let y = y.checked_sub(first_row)?;
    (x < picture.width && y < picture.height).then(|| y as usize * picture.width as usize + x as usize)
}

/// Indices, in tile order, of the tiles that hold these rows of the window.
pub(crate) fn indices_of(rows: &Range<u32>, settings: &Settings) -> Range<u32> {
    let of_row_of_tiles = u64::from(settings.window().width.div_ceil(TILE_SIDE)) * u64::from(TILE_PIXELS);
    // A film has at most 2^32 pixels, and its last index is below that.
    let index = |row_of_tiles: u32| u32::try_from(u64::from(row_of_tiles) * of_row_of_tiles).unwrap_or(u32::MAX);
    index(rows.start / TILE_SIDE)..index(rows.end.div_ceil(TILE_SIDE))
}

/// Twin of the GLSL function of the same name.
fn tile_order_pixel(index: u32, width: u32) -> (u32, u32) {
    let tiles_per_row = width.div_ceil(TILE_SIDE);
    let (tile, within) = (index / TILE_PIXELS, index % TILE_PIXELS);
    let (x, y) = (tile % tiles_per_row, tile / tiles_per_row);
    (x * TILE_SIDE + within % TILE_SIDE, y * TILE_SIDE + within / TILE_SIDE)
}

/// A picture without samples of these rows of the window.
pub(crate) fn empty_picture(settings: &Settings, rows: &Range<u32>) -> Picture {
    let Crop { x, y, width, .. } = settings.window();
    Picture::empty(width, rows.end - rows.start, [x, y + rows.start], [settings.width, settings.height])
}

/// Bytes that a pixel takes on the host when it is read back.
const HOST_PIXEL_BYTES: u64 = 36 + 4 * FEATURE_CHANNELS as u64;
/// Bytes on the host that a pixel of a part of a picture takes besides: its sums, in tile order, and those of a picture that is
/// read back, in both orders.
const PART_PIXEL_BYTES: u64 = 3 * size_of::<PixelSums>() as u64;

/// Bytes of the film on the device.
pub(crate) fn film_bytes(settings: &Settings) -> u64 {
    let of_half = if settings.noise.is_some() { size_of::<Quadruple>() as u64 } else { 0 };
    padded_pixels(settings).saturating_mul(PIXEL_BYTES + of_half)
}

/// Pixels of the largest film of which the host keeps a whole copy where the device's memory is the host's own. Larger ones are read
/// some rows at a time, and have no safety copy.
const MOST_WHOLE_PIXELS: u64 = 1 << 22;

/// Whether a whole copy of the film of these settings lies in the host's memory while it is rendered.
pub(crate) fn has_copies(settings: &Settings, is_cpu: bool) -> bool {
    !is_cpu || padded_pixels(settings) <= MOST_WHOLE_PIXELS
}

/// Bytes that reading it back takes of the host. A safety copy is dropped when the next one is there.
pub(crate) fn host_film_bytes(settings: &Settings, is_cpu: bool, needs_whole: bool) -> u64 {
    let pixels = padded_pixels(settings);
    let of_part = if settings.sample_offset.is_some() { PART_PIXEL_BYTES } else { 0 };
    let pixels_held = match (has_copies(settings, is_cpu), needs_whole) {
        (true, _) => pixels.saturating_mul(2),
        (false, true) => pixels,
        (false, false) => READ_PIXELS.into(),
    };
    pixels_held.saturating_mul(HOST_PIXEL_BYTES).saturating_add(pixels.saturating_mul(of_part))
}

/// Pixels of the whole tiles that cover the window.
pub(crate) fn padded_pixels(settings: &Settings) -> u64 {
    let window = settings.window();
    u64::from(window.width.div_ceil(TILE_SIDE)) * u64::from(window.height.div_ceil(TILE_SIDE)) * u64::from(TILE_PIXELS)
}

fn too_large(window: &Crop) -> crate::Error {
    crate::Error::Settings(format!(
        "a film of {} x {} pixels has more than 2^32 of them: render it in parts with --crop",
        window.width, window.height
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tile_order_visits_every_pixel_once() {
        let (width, height) = (19, 10);
        let tiles = 3 * 2;
        let mut seen = vec![0; width * height];
        for index in 0..tiles * TILE_PIXELS {
            let (x, y) = tile_order_pixel(index, width as u32);
            if (x as usize) < width && (y as usize) < height {
                seen[y as usize * width + x as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&times| times == 1));
    }
}
