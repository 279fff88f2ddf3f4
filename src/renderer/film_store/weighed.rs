//! The film of a render whose steps are weighed by their measured variance: whole blocks of steps are taken over from the device
//! with their weights, and its moments begin anew.

use crate::Result;
use crate::film::Picture;
use crate::film::measured_weights::{MeasuredWeights, WeighedPixel, half_of_pixel, variances_of_halves};
use crate::renderer::film_store::pages::picture_index;
use crate::renderer::sets::frame::Frame;
use crate::settings::Settings;

/// The blocks so far; pixels are in tile order.
pub(crate) struct WeighedFilm {
    weights: MeasuredWeights,
    pixels: Vec<WeighedPixel>,
    /// Has each half's own variance decide its weights: a fault.
    own_weights: bool,
}

impl WeighedFilm {
    /// None yet, for every pixel of the film.
    pub fn new(frame: &Frame, settings: &Settings) -> Self {
        let count = frame.pages().iter().map(|page| page.pixel_count() as usize).sum();
        let pixels = vec![WeighedPixel::default(); count];
        Self { weights: MeasuredWeights::default(), pixels, own_weights: settings.own_weights }
    }

    /// Samples per pixel that the device's moments no longer hold.
    pub fn samples(&self) -> u32 {
        self.weights.samples()
    }

    /// After a step of so many samples: takes over what is in the film since the last block, where that makes another.
    pub fn take(&mut self, frame: &Frame, samples: u32) -> Result<()> {
        let Some(samples) = self.weights.add_step(samples) else { return Ok(()) };
        let film = frame.radiance()?;
        // What does not vary yet cannot be weighed: a larger block will be.
        let Some([first, second]) = variances_of_halves(&film, samples) else { return Ok(()) };
        let variances = if self.own_weights { [first, second] } else { [second, first] };
        let shares = self.weights.add_block(variances);
        for (index, (pixel, block)) in self.pixels.iter_mut().zip(&film).enumerate() {
            *pixel = pixel.with(block, samples, shares[half_of_pixel(index)]);
        }
        frame.restart_moments(&film)
    }

    /// Writes radiance and variance, also of a block under way, to the picture of the film.
    pub fn write_to(&self, picture: &mut Picture, frame: &Frame) -> Result<()> {
        for (index, (pixel, rest)) in self.pixels.iter().zip(&frame.radiance()?).enumerate() {
            if let Some(at) = picture_index(index as u32, picture) {
                let samples = rest.sample_count - self.samples();
                let share = self.weights.share_of_rest(half_of_pixel(index), samples);
                let pixel = pixel.with(rest, samples, share);
                (picture.radiance[at], picture.variance[at]) = (pixel.mean, pixel.variance);
            }
        }
        Ok(())
    }

    pub fn bytes(&self) -> Vec<u8> {
        [bytemuck::bytes_of(&self.weights), bytemuck::cast_slice(&self.pixels)].concat()
    }

    /// # Panics
    /// Where the bytes are not as many.
    pub fn restore(&mut self, bytes: &[u8]) {
        let (weights, pixels) = bytes.split_at(size_of::<MeasuredWeights>());
        bytemuck::bytes_of_mut(&mut self.weights).copy_from_slice(weights);
        bytemuck::cast_slice_mut(&mut self.pixels).copy_from_slice(pixels);
    }
}
