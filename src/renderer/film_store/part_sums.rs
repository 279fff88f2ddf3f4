//! The film of a render that is one part of several. After every step its moments are added to sums that do not depend on
//! order, and the device's film begins anew.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::Result;
use crate::film::Picture;
use crate::film::sums::PixelSums;
use crate::gpu::Context;
use crate::renderer::film_store::pages::{empty_picture, indices_of, padded_pixels, picture_index};
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
        add_film(&mut self.0, frame, &(0..u32::MAX))?;
        clear_film(context, frame)
    }

    /// Reads rows of the picture so far, with the samples of a step under way.
    pub fn picture(&self, frame: &Frame, settings: &Settings, rows: &Range<u32>) -> Result<Picture> {
        let indices = indices_of(rows, settings);
        let mut sums = self.0[indices.start as usize..indices.end as usize].to_vec();
        add_film(&mut sums, frame, &indices)?;
        let mut picture = empty_picture(settings, rows);
        picture.sums = vec![PixelSums::default(); picture.radiance.len()];
        for (index, pixel) in indices.zip(&sums) {
            if let Some(at) = picture_index(index, &picture, rows.start) {
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
        let buffers = frame.pages().iter().flat_map(|page| [page.radiance(), page.features()]);
        buffers.filter(|buffer| !buffer.is_blank()).for_each(|buffer| recorder.fill_zero(buffer));
    })?;
    Ok(())
}

/// Adds the pixels with these indices, to which the sums belong.
fn add_film(mut sums: &mut [PixelSums], frame: &Frame, indices: &Range<u32>) -> Result<()> {
    for page in frame.pages() {
        let (radiance, features) = page.read(indices)?;
        let (of_page, rest) = sums.split_at_mut(radiance.len());
        let moments = radiance.par_iter().zip(&features);
        of_page.par_iter_mut().zip(moments).for_each(|(sums, (radiance, features))| {
            sums.add(&PixelSums::of_moments(radiance, features));
        });
        sums = rest;
    }
    Ok(())
}
