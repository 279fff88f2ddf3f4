//! Pictures as EXR files.
//!
//! [`write_picture`] writes these channels, each row by row from the top left:
//!
//! | channels                    | type  | what                                                                     |
//! |-----------------------------|-------|--------------------------------------------------------------------------|
//! | `R`, `G`, `B`               | float | mean radiance, linear sRGB                                               |
//! | `A`                         | float | opaque share of the pixel ([`Picture::alpha`]); colors are multiplied by it |
//! | `variance.R`, `.G`, `.B`    | float | variance of that mean                                                    |
//! | `samples.N`                 | uint  | number of samples taken                                                  |
//! | `hits.N`                    | uint  | number of samples whose camera ray hit a surface                         |
//! | `albedo.R`, `.G`, `.B`      | float | mean albedo of the first hit                                             |
//! | `normal.X`, `.Y`, `.Z`      | float | mean shading normal of the first hit, world space                        |
//! | `sums.00` to `sums.47`      | uint  | the words of [`PixelSums`], where the picture is one part of several     |
//! | `depth.Z`                   | float | mean distance from the camera to the first hit, infinite where no sample hits |
//! | `denoised.R`, `.G`, `.B`    | float | denoised radiance, where [`write_picture_with`] was given one; no reader returns it |
//!
//! The matrices of the camera are `worldToCamera` and `worldToNDC`. With [`Precision::Half`], `R`, `G`, `B`, `A`, `albedo`
//! and `denoised` are 16-bit floats. The other channels need the range and the precision of 32 bits.

use std::path::Path;

use crate::Result;
use crate::film::denoised::Denoised;
use crate::film::features::{FEATURES, RGB};
use crate::film::layers::{Values, channel_name};
use crate::film::picture::Picture;
use crate::film::strips::{Strip, Strips};
use crate::film::sums::PixelSums;
use crate::film::view::View;
use crate::image::columns::{Column, Columns, Rows, ValueAt};
use crate::image::exr::{self, Attributes, FileHeader, lacking};
use crate::image::layers::Layers;
use crate::image::rows_at_a_time;

/// Attribute of a file whose colors are half floats.
pub(super) const PRECISION: &str = "precision";

/// Precision of the colors in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit floats.
    Float,
    /// 16-bit floats. Values above 65504 become 65504, and values below 3e-8 become 0.
    Half,
}

impl Precision {
    /// Column of a color.
    fn column(self, value: ValueAt<'_, f32>) -> Column<'_> {
        match self {
            Self::Float => Column::Floats(value),
            Self::Half => Column::Halves(value),
        }
    }
}

/// Writes every layer of `picture` in 32 bits, with `attributes` (name and value) as text attributes named `lodestar.<name>`.
///
/// # Errors
/// [`crate::Error::Write`] where the file cannot be written.
pub fn write_picture(path: &Path, picture: &Picture, attributes: &[(String, String)]) -> Result<()> {
    write_picture_as(path, picture, attributes, Precision::Float)
}

/// Writes like [`write_picture`], with colors of the given precision.
///
/// # Errors
/// [`crate::Error::Write`] where the file cannot be written.
pub fn write_picture_as(
    path: &Path,
    picture: &Picture,
    attributes: &[(String, String)],
    precision: Precision,
) -> Result<()> {
    write_picture_with(path, picture, attributes, precision, None, &mut |_| {})
}

/// Writes like [`write_picture_as`], with a denoised layer and its attributes if one is given. Calls `tell` with the share that is
/// written, in [0, 1], again and again. No channel is copied: memory holds a few rows besides the picture.
///
/// # Errors
/// [`crate::Error::Write`] where the file cannot be written.
pub fn write_picture_with(
    path: &Path,
    picture: &Picture,
    attributes: &[(String, String)],
    precision: Precision,
    denoised: Option<&Denoised>,
    tell: &mut dyn FnMut(f64),
) -> Result<()> {
    write_strips(path, picture, attributes, precision, denoised, tell)
}

/// Writes like [`write_picture_with`] a picture that is read some rows at a time. The file has the same bytes.
///
/// # Errors
/// [`crate::Error::Write`] where the file cannot be written, and where rows cannot be read.
pub fn write_strips(
    path: &Path,
    strips: &dyn Strips,
    attributes: &[(String, String)],
    precision: Precision,
    denoised: Option<&Denoised>,
    tell: &mut dyn FnMut(f64),
) -> Result<()> {
    let [width, height] = strips.size();
    let first = strips.strip(0..1)?;
    let view = first.picture().view;
    let mut attributes = attributes.to_vec();
    if let Some(denoised) = denoised {
        denoised.add_attributes(&mut attributes);
    }
    if precision == Precision::Half {
        attributes.push((PRECISION.into(), "half".into()));
    }
    let header = FileHeader {
        attributes,
        foreign: Vec::new(),
        camera_from_world: view.map(|view| view.camera_from_world),
        film_from_world: view.map(|view| view.film_from_world),
    };
    let mut make = |rows, take: &mut dyn FnMut(&Rows<'_>)| {
        let strip = strips.strip(rows)?;
        take(&Rows {
            columns: &columns_of(&strip, first.picture(), height, precision, denoised),
            first: strip.first(),
        });
        Ok(())
    };
    // Of a picture in memory, only the blocks that are compressed are copied.
    let rows_at_a_time = if strips.whole().is_some() { 1 } else { rows_at_a_time(width) };
    let shape = columns_of(&first, first.picture(), height, precision, denoised);
    exr::write_rows(path, &shape, &header, rows_at_a_time, &mut make, tell)
}

/// Columns of a file of this height, which hold a strip. The file's window is that of its first strip.
fn columns_of<'a>(
    strip: &'a Strip<'_>,
    first: &Picture,
    height: u32,
    precision: Precision,
    denoised: Option<&'a Denoised>,
) -> Columns<'a> {
    let Picture { width, offset, full_size, .. } = *first;
    let mut columns = Columns { width, height, offset, full_size, channels: channels(strip.picture(), precision) };
    if let Some(denoised) = denoised {
        let first_pixel = strip.first() as usize * width as usize;
        denoised.add_channels(&mut columns, precision == Precision::Half, first_pixel);
    }
    columns
}

/// Reads a picture that [`write_picture`] has written, to the last bit: every layer, and the attributes as
/// [`exr::read_attributes`] returns them. Whether the picture has a background is known only if a sample has missed all surfaces.
///
/// # Errors
/// [`crate::Error::Image`] where a layer is missing; all errors of [`exr::read_layers`].
pub fn read_picture(path: &Path) -> Result<(Picture, Attributes)> {
    let (layers, header) = exr::read_layers(path)?;
    let FileHeader { attributes, camera_from_world, film_from_world, .. } = header;
    let view = camera_from_world.zip(film_from_world);
    let values = |layer, channels| values(&layers, layer, channels).ok_or_else(|| lacking(path, layer));
    let color = |layer| Ok(bytemuck::cast_slice(&values(layer, RGB)?).to_vec());
    let counts = |name: &str| Ok(layers.words(name).ok_or_else(|| lacking(path, name))?.to_vec());
    let mut picture = Picture {
        has_background: false,
        view: view.map(|(camera_from_world, film_from_world)| View { camera_from_world, film_from_world }),
        width: layers.width,
        height: layers.height,
        offset: layers.offset,
        full_size: layers.full_size,
        radiance: color("radiance")?,
        variance: color("variance")?,
        sample_count: counts("samples.N")?,
        hit_count: counts("hits.N")?,
        features: Default::default(),
        sums: sums_of(path, &layers)?,
    };
    for (to, feature) in picture.features.iter_mut().zip(&FEATURES) {
        *to = values(feature.name, feature.channels)?;
    }
    picture.has_background = has_background(&layers, &picture);
    Ok((picture, attributes))
}

/// Whether a pixel is opaque although one of its samples hit no surface.
fn has_background(layers: &Layers, picture: &Picture) -> bool {
    let Some(alpha) = layers.floats("A") else { return false };
    let mut pixels = alpha.iter().zip(picture.sample_count.iter().zip(&picture.hit_count));
    pixels.any(|(&alpha, (samples, hits))| alpha == 1.0 && hits < samples)
}

fn channels(picture: &Picture, precision: Precision) -> Vec<(String, Column<'_>)> {
    let alpha = precision.column(Box::new(|at| picture.alpha(at)));
    let mut channels = vec![("A".to_owned(), alpha)];
    for layer in picture.layers() {
        let step = layer.channels.len();
        for (number, channel) in layer.channels.iter().enumerate() {
            let column = match layer.values {
                Values::Floats(values) => {
                    let precision = if layer.is_color { precision } else { Precision::Float };
                    precision.column(Box::new(move |at| values[at * step + number]))
                }
                Values::Counts(counts) => Column::Words(Box::new(move |at| counts[at])),
            };
            channels.push((layer.channel_name(channel), column));
        }
    }
    channels.extend(sums_channels(picture));
    channels
}

fn sums_channels(picture: &Picture) -> Vec<(String, Column<'_>)> {
    let words: &[[u32; PixelSums::WORDS]] = bytemuck::cast_slice(&picture.sums);
    let column = |word: usize| (sums_name(word), Column::Words(Box::new(move |at| words[at][word])));
    if words.is_empty() { Vec::new() } else { (0..PixelSums::WORDS).map(column).collect() }
}

fn sums_name(word: usize) -> String {
    format!("sums.{word:02}")
}

/// Values of a layer, one for each channel; `None` where a channel is missing.
fn values(layers: &Layers, layer: &str, channels: &[&str]) -> Option<Vec<f32>> {
    let columns: Vec<_> =
        channels.iter().map(|channel| layers.floats(&channel_name(layer, channel))).collect::<Option<_>>()?;
    let pixels = columns.first()?.len();
    Some((0..pixels).flat_map(|at| columns.iter().map(move |column| column[at])).collect())
}

/// Integer sums of every pixel; empty where the picture is a whole one.
fn sums_of(path: &Path, layers: &Layers) -> Result<Vec<PixelSums>> {
    if layers.words(&sums_name(0)).is_none() {
        return Ok(Vec::new());
    }
    let word = |at: usize| layers.words(&sums_name(at)).ok_or_else(|| lacking(path, &sums_name(at)));
    let channels: Vec<_> = (0..PixelSums::WORDS).map(word).collect::<Result<_>>()?;
    let pixel =
        |at: usize| bytemuck::cast::<[u32; PixelSums::WORDS], PixelSums>(std::array::from_fn(|c| channels[c][at]));
    Ok((0..channels[0].len()).map(pixel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::features::{ALBEDO, DEPTH, NORMAL};
    use crate::film::strips::each;
    use crate::image::layers::Samples;

    use std::path::PathBuf;

    use glam::Mat4;

    const WIDTH: u32 = 7;
    const HEIGHT: u32 = 5;

    /// Pixel values that differ in every pixel and layer: `layer + pixel / 64 + channel / 1024`, exact in binary.
    fn pixels(layer: f32) -> Vec<[f32; 3]> {
        let pixel = |i: u32| std::array::from_fn(|c| layer + i as f32 / 64.0 + c as f32 / 1024.0);
        (0..WIDTH * HEIGHT).map(pixel).collect()
    }

    fn picture() -> Picture {
        let mut depth: Vec<_> = pixels(5.0).iter().map(|pixel| pixel[0]).collect();
        depth[3] = f32::INFINITY;
        let mut features = Picture::empty(WIDTH, HEIGHT, [0; 2], [WIDTH, HEIGHT]).features;
        let [albedo, normal] = [3.0, -4.0].map(|layer| pixels(layer).as_flattened().to_vec());
        (features[ALBEDO], features[NORMAL], features[DEPTH]) = (albedo, normal, depth);
        Picture {
            width: WIDTH,
            height: HEIGHT,
            offset: [3, 2],
            full_size: [20, 10],
            radiance: pixels(1.0),
            variance: pixels(2.0),
            sample_count: (0..WIDTH * HEIGHT).map(|i| i + 16_777_217).collect(),
            hit_count: (0..WIDTH * HEIGHT).map(|i| i + 8_388_609).collect(),
            features,
            sums: vec![],
            has_background: true,
            view: Some(View { camera_from_world: Mat4::IDENTITY, film_from_world: Mat4::from_rotation_y(0.1) }),
        }
    }

    fn folder() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        (folder, path)
    }

    #[test]
    fn every_layer_comes_back() {
        let (_folder, path) = folder();
        let picture = picture();
        write_picture(&path, &picture, &[]).unwrap();
        assert_eq!(exr::read_rgb(&path).unwrap(), picture.image());
        for (name, expected) in
            [("variance", &picture.variance[..]), ("albedo", picture.albedo()), ("normal", picture.normal())]
        {
            assert_eq!(exr::read_layer(&path, name).unwrap().pixels, expected, "{name}");
        }
        let depth = exr::read_layer(&path, "depth").unwrap().pixels;
        assert_eq!(depth, picture.depth().iter().map(|&depth| [depth; 3]).collect::<Vec<_>>());
    }

    #[test]
    fn alpha_is_the_share_of_hits_unless_there_is_a_background() {
        let (_folder, path) = folder();
        let mut picture = Picture { has_background: false, ..picture() };
        (picture.sample_count[0], picture.hit_count[0]) = (8, 6);
        (picture.sample_count[1], picture.hit_count[1]) = (0, 0);
        for (has_background, expected) in [(false, [0.75, 0.0]), (true, [1.0, 0.0])] {
            picture.has_background = has_background;
            write_picture(&path, &picture, &[]).unwrap();
            let (layers, _) = exr::read_layers(&path).unwrap();
            assert_eq!(layers.floats("A").unwrap()[..2], expected);
            assert_eq!(read_picture(&path).unwrap().0, picture);
        }
    }

    #[test]
    fn halves_keep_the_numbers_that_need_more() {
        let (_folder, path) = folder();
        let mut picture = picture();
        picture.radiance[0] = [0.1, 1.0e6, 1.0e-10];
        write_picture_as(&path, &picture, &[], Precision::Half).unwrap();
        let (half, attributes) = read_picture(&path).unwrap();
        assert_eq!(attributes, [(PRECISION.to_owned(), "half".to_owned())]);
        assert_eq!(half.radiance[0][1..], [exr::LARGEST_HALF, 0.0]);
        assert!(half.radiance[0][0] != 0.1 && (half.radiance[0][0] / 0.1 - 1.0).abs() < 1.0 / 2048.0);
        assert_eq!((half.normal(), half.depth()), (picture.normal(), picture.depth()));
        let Picture { variance, sample_count, hit_count, .. } = half;
        assert_eq!((variance, sample_count, hit_count), (picture.variance, picture.sample_count, picture.hit_count));
    }

    #[test]
    fn a_picture_comes_back_whole() {
        let (_folder, path) = folder();
        let attributes = [("seed".to_owned(), "7".to_owned())];
        write_picture(&path, &picture(), &attributes).unwrap();
        assert_eq!(read_picture(&path).unwrap(), (picture(), attributes.to_vec()));
        let word = |at: u32| at.wrapping_mul(0x9e37_79b9);
        let words: Vec<_> = (0..WIDTH * HEIGHT * PixelSums::WORDS as u32).map(word).collect();
        let part = Picture { sums: bytemuck::pod_collect_to_vec(&words), ..picture() };
        write_picture(&path, &part, &attributes).unwrap();
        assert_eq!(read_picture(&path).unwrap().0, part);
        let channels = RGB.iter().map(|name| ((*name).to_owned(), Samples::Floats(vec![0.5, 2.0]))).collect();
        let color = Layers { width: 2, height: 1, offset: [0, 0], full_size: [2, 1], channels };
        exr::write_layers(&path, &color, &FileHeader::default()).unwrap();
        let error = read_picture(&path).unwrap_err().to_string();
        assert!(error.contains("a.exr: it lacks variance"), "{error}");
    }

    /// A picture that gives copies of the rows that are asked for, as a device does.
    struct InRows(Picture, std::cell::Cell<u32>);

    impl Strips for InRows {
        fn size(&self) -> [u32; 2] {
            self.0.size()
        }

        fn strip(&self, rows: std::ops::Range<u32>) -> Result<Strip<'_>> {
            let (whole, width) = (&self.0, self.0.width as usize);
            self.1.set(self.1.get().max(rows.end - rows.start));
            let pixels = rows.start as usize * width..rows.end as usize * width;
            let [x, y] = whole.offset;
            let mut strip = Picture {
                height: rows.end - rows.start,
                offset: [x, y + rows.start],
                radiance: whole.radiance[pixels.clone()].to_vec(),
                variance: whole.variance[pixels.clone()].to_vec(),
                sample_count: whole.sample_count[pixels.clone()].to_vec(),
                hit_count: whole.hit_count[pixels.clone()].to_vec(),
                ..whole.clone()
            };
            for (values, feature) in strip.features.iter_mut().zip(&FEATURES) {
                let count = feature.channels.len();
                *values = values[count * pixels.start..count * pixels.end].to_vec();
            }
            Ok(Strip::From(rows.start, Box::new(strip)))
        }
    }

    /// 700 rows of 400 pixels are more than are read at a time, and their end cuts a block of 16 rows.
    #[test]
    fn rows_make_the_file_of_the_whole() {
        let (folder, path) = folder();
        let (width, height) = (400, 700);
        let mut picture = Picture::empty(width, height, [3, 2], [500, 800]);
        for at in 0..picture.radiance.len() {
            let value = (at as f32).sin();
            (picture.radiance[at], picture.variance[at]) = ([value, value * 2.0, 0.5], [value * value; 3]);
            (picture.sample_count[at], picture.hit_count[at]) = (at as u32, at as u32 / 2);
            picture.features[NORMAL][3 * at + 1] = -value;
        }
        let denoised = Denoised { pixels: picture.variance.clone(), by: "a".into(), on: "b".into(), from: "c".into() };
        let rows = InRows(picture.clone(), std::cell::Cell::new(0));
        let in_rows = folder.path().join("rows.exr");
        for (denoised, precision) in [(None, Precision::Half), (Some(&denoised), Precision::Float)] {
            write_picture_with(&path, &picture, &[], precision, denoised, &mut |_| {}).unwrap();
            let mut shares = Vec::new();
            write_strips(&in_rows, &rows, &[], precision, denoised, &mut |share| shares.push(share)).unwrap();
            assert!(exr::read_layers(&in_rows).unwrap() == exr::read_layers(&path).unwrap());
            assert!(shares.is_sorted() && shares.len() > 40 && shares.last() == Some(&1.0));
        }
        assert_eq!(rows.1.get(), rows_at_a_time(width));
        assert!(rows_at_a_time(width) < height);
        let counts = crate::film::strips::SampleCounts::of(&rows).unwrap();
        assert_eq!((counts.pixels, counts.empty, counts.most), (280_000, 1, 279_999));
        let mut colors = Vec::new();
        each(&rows, &mut |strip| colors.extend_from_slice(&strip.picture.radiance[strip.within.clone()])).unwrap();
        assert_eq!(colors, picture.radiance);
    }
}
