//! The layer that a denoiser adds to a picture's file. A picture in memory, a merged picture and a checkpoint have none.

use crate::image::columns::{Column, Columns, ValueAt};

/// Attribute with the denoiser's name and version.
const BY: &str = "denoised_by";
/// Attribute with the device that denoised.
const ON: &str = "denoised_on";
/// Attribute with the layers that the denoiser read.
const FROM: &str = "denoised_from";
/// Attributes of a denoised layer. They say nothing about the samples.
pub(super) const ATTRIBUTES: [&str; 3] = [BY, ON, FROM];
/// Channels of the layer.
const CHANNELS: [&str; 3] = ["denoised.R", "denoised.G", "denoised.B"];

/// Radiance without its noise, and how it was made.
#[derive(Debug, Clone, PartialEq)]
pub struct Denoised {
    /// Denoised radiance, linear sRGB, row by row from the top left.
    pub pixels: Vec<[f32; 3]>,
    /// Name and version of the denoiser.
    pub by: String,
    /// Device that denoised.
    pub on: String,
    /// Layers that the denoiser read, such as `color, albedo, normal`.
    pub from: String,
}

impl Denoised {
    /// Puts the layer's channels in the place of those of an earlier one. They are half floats or floats. The columns begin with the pixel
    /// `first` of the picture.
    pub fn add_channels<'a>(&'a self, columns: &mut Columns<'a>, is_half: bool, first: usize) {
        columns.channels.retain(|(name, _)| !name.starts_with("denoised."));
        let channel = |(c, name): (usize, &&str)| {
            let value: ValueAt<'a, f32> = Box::new(move |at| self.pixels[first + at][c]);
            ((*name).to_owned(), if is_half { Column::Halves(value) } else { Column::Floats(value) })
        };
        columns.channels.extend(CHANNELS.iter().enumerate().map(channel));
    }

    /// Adds the layer's attributes in place of those of an earlier one.
    pub fn add_attributes(&self, attributes: &mut Vec<(String, String)>) {
        attributes.retain(|(name, _)| !ATTRIBUTES.contains(&&name[..]));
        let all = [(BY, &self.by), (ON, &self.on), (FROM, &self.from)];
        attributes.extend(all.map(|(name, value)| (name.to_owned(), value.clone())));
    }
}
