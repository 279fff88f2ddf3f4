//! Pictures and files: which layers the denoiser reads, and what is written.

use std::path::Path;

use super::{Denoiser, Features};
use crate::film::{Denoised, Picture};
use crate::image::ToneCurve;
use crate::image::canvas::{Canvas, Format};
use crate::image::columns::Column;
use crate::image::exr::{self, FileHeader};
use crate::image::layers::Layers;
use crate::{Error, Result};

impl Denoiser {
    /// Denoises a picture by its color, albedo and normal.
    ///
    /// # Errors
    /// Where [`Denoiser::denoise`] fails.
    pub fn denoise_picture(&self, picture: &Picture) -> Result<Denoised> {
        self.denoise_layer(&Features {
            width: picture.width,
            height: picture.height,
            color: &picture.radiance,
            albedo: Some(picture.albedo()),
            normal: Some(picture.normal()),
        })
    }

    fn denoise_layer(&self, features: &Features<'_>) -> Result<Denoised> {
        let from = match (features.albedo, features.normal) {
            (Some(_), Some(_)) => "color, albedo, normal",
            (Some(_), None) => "color, albedo",
            (None, _) => "color",
        };
        let pixels = self.denoise(features)?;
        Ok(Denoised { pixels, by: self.version().to_owned(), on: self.device(), from: from.into() })
    }
}

/// Picture of a file, and its denoised layer.
pub struct DenoisedFile {
    layers: Layers,
    header: FileHeader,
    denoised: Denoised,
    /// Sentences that a user should read.
    pub notes: Vec<String>,
}

impl DenoisedFile {
    /// Reads an EXR file and denoises its channels `R`, `G` and `B` by the layers `albedo` and `normal`, as far as it has them.
    ///
    /// # Errors
    /// [`Error::Read`] and [`Error::Image`] where the file is no flat picture of one part with a color, and where
    /// [`Denoiser::denoise`] fails.
    pub fn new(denoiser: &Denoiser, path: &Path) -> Result<Self> {
        let (layers, header) = exr::read_layers(path)?;
        let color = three(&layers, ["R", "G", "B"]);
        let color =
            color.ok_or_else(|| Error::image(path, "it lacks the channels R, G and B; give a color picture"))?;
        let albedo = three(&layers, ["albedo.R", "albedo.G", "albedo.B"]);
        let normal = three(&layers, ["normal.X", "normal.Y", "normal.Z"]);
        let (width, height) = (layers.width, layers.height);
        let features = Features { width, height, color: &color, albedo: albedo.as_deref(), normal: normal.as_deref() };
        let denoised = denoiser.denoise_layer(&features)?;
        let missing = match (&albedo, &normal) {
            (Some(_), Some(_)) => None,
            (Some(_), None) => Some("it has no layer normal, so it was denoised by color and albedo only"),
            (None, Some(_)) => Some("it has no layer albedo, so it was denoised by color only"),
            (None, None) => Some("it has no layers albedo and normal, so it was denoised by color only"),
        };
        let broken = color.iter().filter(|pixel| !pixel.iter().all(|value| value.is_finite())).count();
        let broken = (broken > 0).then(|| {
            let all = color.len();
            format!("{broken} of {all} pixels are infinite or not a number; the denoiser took them as black")
        });
        let notes = missing.map(str::to_owned).into_iter().chain(broken);
        let notes = notes.map(|note| format!("{}: {note}", path.display())).collect();
        Ok(Self { layers, header, denoised, notes })
    }

    /// The layer and how it was made.
    pub fn denoised(&self) -> &Denoised {
        &self.denoised
    }

    /// Writes the file whole or not at all. A `.png`, `.jpg` or `.tif` file shows the denoised layer through `tone`,
    /// brighter by `2^exposure`, and a `.hdr` file has it in linear values. Any
    /// other name is an EXR file with all channels of the file that was read, to the last bit, and the layer `denoised`. Calls `tell`
    /// with the share that is written, in [0, 1], again and again.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: &Path, tone: ToneCurve, exposure: f32, tell: &mut dyn FnMut(f64)) -> Result<()> {
        if let Some(format) = Format::of(path) {
            let canvas = Canvas::new(format, [self.layers.width, self.layers.height], tone, exposure);
            return canvas.write(path, &self.denoised.pixels, tell);
        }
        let (mut columns, mut header) = (self.layers.columns(), self.header.clone());
        let is_half = columns.channels.iter().any(|(name, column)| name == "R" && matches!(column, Column::Halves(_)));
        self.denoised.add_channels(&mut columns, is_half, 0);
        self.denoised.add_attributes(&mut header.attributes);
        exr::write_columns(path, &columns, &header, tell)
    }
}

/// Pixels of three channels; `None` where one is missing or holds integers.
fn three(layers: &Layers, names: [&str; 3]) -> Option<Vec<[f32; 3]>> {
    let [a, b, c] = names.map(|name| layers.floats(name));
    Some(a?.iter().zip(b?).zip(c?).map(|((&a, &b), &c)| [a, b, c]).collect())
}
