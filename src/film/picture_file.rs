//! Pictures as EXR files.
//!
//! [`write_picture`] writes these channels, each row by row from the top left:
//!
//! | channels                    | type  | what                                                                     |
//! |-----------------------------|-------|--------------------------------------------------------------------------|
//! | `R`, `G`, `B`               | float | mean radiance, linear sRGB                                               |
//! | `variance.R`, `.G`, `.B`    | float | variance of that mean                                                    |
//! | `samples.N`                 | uint  | number of samples taken                                                  |
//! | `hits.N`                    | uint  | number of samples whose camera ray hit a surface                         |
//! | `albedo.R`, `.G`, `.B`      | float | mean albedo of the first hit                                             |
//! | `normal.X`, `.Y`, `.Z`      | float | mean shading normal of the first hit, world space                        |
//! | `sums.00` to `sums.47`      | uint  | the words of [`PixelSums`], where the picture is one part of several     |
//! | `depth.Z`                   | float | mean distance from the camera to the first hit, infinite where none does |

use std::path::Path;

use crate::Result;
use crate::film::picture::Picture;
use crate::film::sums::PixelSums;
use crate::image::exr::{self, Attributes, lacking};
use crate::image::layers::{Layers, Samples};

/// Names of a color's channels.
const RGB: [&str; 3] = ["R", "G", "B"];
/// Names of a vector's channels.
const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// Writes every layer of `picture`, with `attributes` (name and value) as text attributes named `lodestar.<name>`.
///
/// # Errors
/// [`crate::Error::Write`] where the file cannot be written.
pub fn write_picture(path: &Path, picture: &Picture, attributes: &[(String, String)]) -> Result<()> {
    let Picture { width, height, offset, full_size, .. } = *picture;
    exr::write_layers(path, Layers { width, height, offset, full_size, channels: channels(picture) }, attributes)
}

/// Reads a picture that [`write_picture`] has written, to the last bit: every layer, and the attributes as
/// [`exr::read_attributes`] returns them.
///
/// # Errors
/// [`crate::Error::Image`] where a layer is missing; all errors of [`exr::read_layers`].
pub fn read_picture(path: &Path) -> Result<(Picture, Attributes)> {
    let (layers, attributes) = exr::read_layers(path)?;
    let three =
        |prefix: &str, names: [&str; 3], what: &str| three(&layers, prefix, names).ok_or_else(|| lacking(path, what));
    let counts = |name: &str| Ok(layers.words(name).ok_or_else(|| lacking(path, name))?.to_vec());
    let picture = Picture {
        width: layers.width,
        height: layers.height,
        offset: layers.offset,
        full_size: layers.full_size,
        radiance: three("", RGB, "radiance")?,
        variance: three("variance.", RGB, "variance")?,
        sample_count: counts("samples.N")?,
        hit_count: counts("hits.N")?,
        albedo: three("albedo.", RGB, "albedo")?,
        normal: three("normal.", XYZ, "normal")?,
        depth: layers.floats("depth.Z").ok_or_else(|| lacking(path, "depth"))?.to_vec(),
        sums: sums_of(path, &layers)?,
    };
    Ok((picture, attributes))
}

fn channels(picture: &Picture) -> Vec<(String, Samples)> {
    let layers = [
        ("", RGB, &picture.radiance),
        ("variance.", RGB, &picture.variance),
        ("albedo.", RGB, &picture.albedo),
        ("normal.", XYZ, &picture.normal),
    ];
    let mut channels = Vec::new();
    for (prefix, names, pixels) in layers {
        for (component, name) in names.into_iter().enumerate() {
            let samples = pixels.iter().map(|pixel| pixel[component]).collect();
            channels.push((format!("{prefix}{name}"), Samples::Floats(samples)));
        }
    }
    channels.push(("samples.N".into(), Samples::Words(picture.sample_count.clone())));
    channels.push(("hits.N".into(), Samples::Words(picture.hit_count.clone())));
    channels.push(("depth.Z".into(), Samples::Floats(picture.depth.clone())));
    channels.extend(sums_channels(picture));
    channels
}

fn sums_channels(picture: &Picture) -> Vec<(String, Samples)> {
    let words: &[[u32; PixelSums::WORDS]] = bytemuck::cast_slice(&picture.sums);
    let word = |at: usize| (sums_name(at), Samples::Words(words.iter().map(|words| words[at]).collect()));
    if words.is_empty() { Vec::new() } else { (0..PixelSums::WORDS).map(word).collect() }
}

fn sums_name(word: usize) -> String {
    format!("sums.{word:02}")
}

/// Pixels of three channels; `None` where one is missing.
fn three(layers: &Layers, prefix: &str, names: [&str; 3]) -> Option<Vec<[f32; 3]>> {
    let [a, b, c] = names.map(|name| layers.floats(&format!("{prefix}{name}")));
    Some(a?.iter().zip(b?).zip(c?).map(|((&a, &b), &c)| [a, b, c]).collect())
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

    use std::path::PathBuf;

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
        Picture {
            width: WIDTH,
            height: HEIGHT,
            offset: [3, 2],
            full_size: [20, 10],
            radiance: pixels(1.0),
            variance: pixels(2.0),
            sample_count: (0..WIDTH * HEIGHT).map(|i| i + 16_777_217).collect(),
            hit_count: (0..WIDTH * HEIGHT).map(|i| i + 8_388_609).collect(),
            albedo: pixels(3.0),
            normal: pixels(-4.0),
            depth,
            sums: vec![],
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
            [("variance", &picture.variance), ("albedo", &picture.albedo), ("normal", &picture.normal)]
        {
            assert_eq!(&exr::read_layer(&path, name).unwrap().pixels, expected, "{name}");
        }
        let depth = exr::read_layer(&path, "depth").unwrap().pixels;
        assert_eq!(depth, picture.depth.iter().map(|&depth| [depth; 3]).collect::<Vec<_>>());
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
        let channels = RGB.map(|name| (name.to_owned(), Samples::Floats(vec![0.5, 2.0]))).to_vec();
        let color = Layers { width: 2, height: 1, offset: [0, 0], full_size: [2, 1], channels };
        exr::write_layers(&path, color, &[]).unwrap();
        let error = read_picture(&path).unwrap_err().to_string();
        assert!(error.contains("a.exr: it lacks variance"), "{error}");
    }
}
