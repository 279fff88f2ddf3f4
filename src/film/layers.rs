//! The layers of a picture, as files and pages show them.

use crate::film::features::{FEATURES, Feature, RGB};
use crate::film::picture::Picture;

/// A layer of a picture: values pixel by pixel, one for each channel.
#[derive(Debug, Clone, Copy)]
pub struct Layer<'a> {
    /// Name of the layer.
    pub name: &'static str,
    /// Names of its channels.
    pub channels: &'static [&'static str],
    /// Its values.
    pub values: Values<'a>,
    /// Whether the layer is a color, which a file may hold as half floats.
    pub is_color: bool,
}

/// Values of a layer.
#[derive(Debug, Clone, Copy)]
pub enum Values<'a> {
    /// Numbers.
    Floats(&'a [f32]),
    /// Counts.
    Counts(&'a [u32]),
}

impl<'a> Layer<'a> {
    fn of_color(name: &'static str, pixels: &'a [[f32; 3]], is_color: bool) -> Self {
        Self { name, channels: RGB, values: Values::Floats(pixels.as_flattened()), is_color }
    }

    /// Name of a channel in a file.
    pub fn channel_name(&self, channel: &str) -> String {
        channel_name(self.name, channel)
    }
}

/// Name of the layer that a file has without a prefix.
const RADIANCE: &str = "radiance";

/// Name of a layer's channel in a file.
pub(super) fn channel_name(layer: &str, channel: &str) -> String {
    if layer == RADIANCE { channel.to_owned() } else { format!("{layer}.{channel}") }
}

impl Picture {
    /// Every layer but alpha and the integer sums.
    pub fn layers(&self) -> Vec<Layer<'_>> {
        let counts = |name, counts| Layer { name, channels: &["N"], values: Values::Counts(counts), is_color: false };
        let mut layers = vec![
            Layer::of_color(RADIANCE, &self.radiance, true),
            Layer::of_color("variance", &self.variance, false),
            counts("samples", &self.sample_count),
            counts("hits", &self.hit_count),
        ];
        layers.extend(FEATURES.iter().zip(&self.features).map(|(feature, values)| {
            let &Feature { name, channels, is_color, .. } = feature;
            Layer { name, channels, values: Values::Floats(values), is_color }
        }));
        layers
    }
}
