//! Planes: one layer of a picture, as the page draws it.

use std::ops::Range;

use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::film::Picture;
use crate::film::layers::Values;
use crate::image::layers::{Layers, Samples};

/// Layer of a rendered picture that the page does not show.
const HITS: &str = "hits";
/// Largest value that is sent. A half float holds at most 65504.
const LARGEST: f32 = 32_768.0;
/// Prefix of layers that only programs read.
const SUMS: &str = "sums";

/// Values of a layer, pixel by pixel: one for each channel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plane {
    /// Names of the channels, such as `R`.
    pub channels: Vec<String>,
    pub values: Vec<f32>,
}

impl Plane {
    fn new<'a>(channels: impl IntoIterator<Item = &'a str>, values: Vec<f32>) -> Self {
        Self { channels: channels.into_iter().map(str::to_owned).collect(), values }
    }

    /// Plane of a color.
    pub fn of_color(pixels: &[[f32; 3]]) -> Self {
        Self::new(["R", "G", "B"], pixels.as_flattened().to_vec())
    }

    /// The pixels `range`. Pixels that do not exist are left out.
    pub fn part(&self, range: Range<usize>) -> Self {
        let count = self.channels.len();
        let values = self.values.get(count * range.start..count * range.end).unwrap_or_default();
        Self { channels: self.channels.clone(), values: values.to_vec() }
    }

    /// Mean of the finite values.
    pub fn mean(&self) -> f64 {
        let finite = self.values.iter().filter(|value| value.is_finite());
        let (sum, count) = finite.fold((0.0, 0_u64), |(sum, count), &value| (sum + f64::from(value), count + 1));
        sum / count.max(1) as f64
    }

    /// Half floats, and the factor that makes them the values. The factor is a power of two.
    pub fn halves(&self) -> (Vec<u8>, f32) {
        let largest = self.values.iter().filter(|value| value.is_finite()).fold(0.0, |most: f32, v| most.max(v.abs()));
        // Radiance of the usual range keeps its values, other layers use the whole range of half floats.
        let factor = match largest {
            0.0 => 1.0,
            largest if (1.0e-2..=LARGEST).contains(&largest) => 1.0,
            largest => (largest / LARGEST).log2().ceil().exp2(),
        };
        let mut halves = vec![f16::ZERO; self.values.len()];
        match factor {
            1.0 => halves.convert_from_f32_slice(&self.values),
            _ => halves.convert_from_f32_slice(&self.values.iter().map(|value| value / factor).collect::<Vec<_>>()),
        }
        let words: Vec<u16> = halves.reinterpret_cast().iter().map(|word: &u16| word.to_le()).collect();
        (bytemuck::cast_slice(&words).to_vec(), factor)
    }
}

/// Names of a rendered picture's layers.
pub(super) fn names_of_picture(picture: &Picture) -> Vec<String> {
    picture.layers().iter().map(|layer| layer.name.to_owned()).filter(|name| name != HITS).collect()
}

/// The layer `name` of the pixels `range` of a rendered picture.
pub(super) fn of_picture(picture: &Picture, name: &str, range: Range<usize>) -> Option<Plane> {
    let layer = picture.layers().into_iter().find(|layer| layer.name == name && name != HITS)?;
    let count = layer.channels.len();
    let range = count * range.start..count * range.end;
    let values = match layer.values {
        Values::Floats(values) => values.get(range).unwrap_or_default().to_vec(),
        Values::Counts(counts) => counts.get(range).unwrap_or_default().iter().map(|&count| count as f32).collect(),
    };
    Some(Plane::new(layer.channels.iter().copied(), values))
}

/// Layer of a channel, and the channel's name within it.
fn split(channel: &str) -> (&str, &str) {
    channel.rsplit_once('.').unwrap_or(("radiance", channel))
}

/// Names of a file's layers. The color comes first, the others follow in the file's order.
pub(super) fn names(layers: &Layers) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (channel, _) in &layers.channels {
        let (layer, _) = split(channel);
        if layer != SUMS && !names.iter().any(|name| name == layer) {
            names.push(layer.to_owned());
        }
    }
    names.sort_by_key(|name| name != "radiance");
    names
}

/// The layer `name` of the pixels `range` of a file: the channels R, G, B or X, Y, Z, or the first channel.
pub(super) fn of_layers(layers: &Layers, name: &str, range: Range<usize>) -> Option<Plane> {
    let of_layer: Vec<_> = layers.channels.iter().filter(|(channel, _)| split(channel).0 == name).collect();
    let find = |wanted: &str| of_layer.iter().find(|(channel, _)| split(channel).1 == wanted).copied();
    let three = |names: [&str; 3]| names.into_iter().map(find).collect::<Option<Vec<_>>>();
    let chosen = three(["R", "G", "B"]).or_else(|| three(["X", "Y", "Z"]));
    let chosen = chosen.unwrap_or_else(|| of_layer.iter().copied().take(1).collect());
    let columns: Vec<Vec<f32>> = chosen.iter().map(|(_, samples)| floats(samples, range.clone())).collect();
    let pixels = columns.first()?.len();
    let values = (0..pixels).flat_map(|at| columns.iter().map(move |column| column[at])).collect();
    Some(Plane::new(chosen.iter().map(|(channel, _)| split(channel).1), values))
}

fn floats(samples: &Samples, range: Range<usize>) -> Vec<f32> {
    match samples {
        Samples::Floats(floats) | Samples::Halves(floats) => floats.get(range).unwrap_or_default().to_vec(),
        Samples::Words(words) => words.get(range).unwrap_or_default().iter().map(|&word| word as f32).collect(),
    }
}

/// Root of the mean variance over the mean radiance.
pub(super) fn noise(radiance: &Plane, variance: &Plane) -> Option<f64> {
    let mean = radiance.mean();
    let noise = variance.mean().sqrt() / mean;
    (mean > 0.0 && noise.is_finite()).then_some(noise)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], factor: f32) -> Vec<f32> {
        let half = |bytes: &[u8]| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
        bytes.chunks_exact(2).map(|bytes| half(bytes) * factor).collect()
    }

    #[test]
    fn halves_keep_values_of_every_size() {
        for scale in [1.0e-9, 0.25, 1.0e8] {
            let values = vec![scale, -0.5 * scale, 1.0e-3 * scale, 0.0];
            let (bytes, factor) = Plane::new(["Z"], values.clone()).halves();
            for (value, read) in values.iter().zip(read(&bytes, factor)) {
                assert!((value - read).abs() <= value.abs() * 1.0e-3, "{value} is not {read}");
            }
        }
        let (bytes, factor) = Plane::new(["Z"], vec![f32::INFINITY, 1.0, f32::NAN]).halves();
        let [infinite, one, nan] = read(&bytes, factor)[..] else { panic!("three values") };
        assert!(infinite == f32::INFINITY && one == 1.0 && nan.is_nan());
    }

    #[test]
    fn layers_of_files_are_found_by_their_channels() {
        let channel = |name: &str, value: f32| (name.to_owned(), Samples::Floats(vec![value, -value]));
        let mut channels: Vec<_> = [
            ("A", 9.0),
            ("B", 3.0),
            ("G", 2.0),
            ("R", 1.0),
            ("depth.Z", 7.0),
            ("denoised.B", 6.0),
            ("denoised.G", 5.0),
        ]
        .map(|(name, value)| channel(name, value))
        .to_vec();
        channels.push(channel("denoised.R", 4.0));
        channels.push(("samples.N".into(), Samples::Words(vec![8, 16])));
        channels.push(("sums.00".into(), Samples::Words(vec![1, 1])));
        let layers = Layers { width: 2, height: 1, offset: [0, 0], full_size: [2, 1], channels };
        assert_eq!(names(&layers), ["radiance", "depth", "denoised", "samples"]);
        let pixel = |name: &str, at| of_layers(&layers, name, at..at + 1).unwrap().values;
        assert_eq!(pixel("radiance", 1), [-1.0, -2.0, -3.0]);
        assert_eq!(pixel("denoised", 0), [4.0, 5.0, 6.0]);
        assert_eq!((pixel("depth", 0), pixel("samples", 1)), (vec![7.0], vec![16.0]));
        assert_eq!(of_layers(&layers, "glow", 0..2), None);
    }

    #[test]
    fn noise_is_relative() {
        let plane = |value: f32| Plane::new(["R", "G", "B"], vec![value; 12]);
        assert!((noise(&plane(0.5), &plane(0.01)).unwrap() - 0.2).abs() < 1.0e-6);
        assert_eq!(noise(&plane(0.0), &plane(0.01)), None);
    }
}
