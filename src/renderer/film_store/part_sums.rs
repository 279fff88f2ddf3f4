//! The film of a render that is one part of several. After every step its moments are added to sums that do not depend on
//! order, and the device's film begins anew.

use std::sync::Arc;

use rayon::prelude::*;

use crate::Result;
use crate::film::Picture;
use crate::film::sums::PixelSums;
use crate::gpu::Context;
use crate::renderer::film_store::pages::{empty_picture, padded_pixels, picture_index};
use crate::renderer::sets::frame::Frame;
use crate::settings::Settings;

/// Sums of complete steps, in tile order.
pub(crate) struct PartSums(Vec<PixelSums>);

impl PartSums {
    /// Empty sums for every pixel of the film.
    pub fn new(settings: &Settings) -> Self {
        Self(vec![PixelSums::default(); padded_pixels(settings) as usize])
    }

    /// Adds the film of a step, and clears it.
    pub fn add_step(&mut self, context: &Arc<Context>, frame: &Frame) -> Result<()> {
        add_film(&mut self.0, frame)?;
        clear_film(context, frame)
    }

    /// Reads the picture so far, with the samples of a step under way.
    pub fn picture(&self, frame: &Frame, settings: &Settings) -> Result<Picture> {
        let mut sums = self.0.clone();
        add_film(&mut sums, frame)?;
        let mut picture = empty_picture(settings);
        picture.sums = vec![PixelSums::default(); picture.radiance.len()];
        for (index, pixel) in (0..).zip(&sums) {
            if let Some(at) = picture_index(index, &picture) {
                picture.set_pixel(at, &pixel.means());
                picture.sums[at] = *pixel;
            }
        }
        Ok(picture)
    }

    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0)
    }

    /// # Panics
    /// Where the bytes are more or fewer than the sums'.
    pub fn restore(&mut self, bytes: &[u8]) {
        bytemuck::cast_slice_mut(&mut self.0).copy_from_slice(bytes);
    }
}

/// Begins the film of a device anew.
pub(crate) fn clear_film(context: &Arc<Context>, frame: &Frame) -> Result<()> {
    context.submit("clearing the film", |recorder| {
        for page in frame.pages() {
            recorder.fill_zero(page.radiance());
            recorder.fill_zero(page.features());
        }
    })?;
    Ok(())
}

fn add_film(mut sums: &mut [PixelSums], frame: &Frame) -> Result<()> {
    for page in frame.pages() {
        let (radiance, features) = page.read()?;
        let (of_page, rest) = sums.split_at_mut(radiance.len());
        let moments = radiance.par_iter().zip(&features);
        of_page.par_iter_mut().zip(moments).for_each(|(sums, (radiance, features))| {
            sums.add(&PixelSums::of_moments(radiance, features));
        });
        sums = rest;
    }
    Ok(())
}
