//! [`FEATURES`], the table of the features of the first hit: what a row says is how a feature is averaged on the way, merged, written,
//! read and shown. A new one is a row here, and its values in GLSL
//! (`glsl/include/film/features.glsl` and `shade_vertex`).

use crate::generated::layout::FilmFeatures;

/// A feature of the surfaces that camera rays hit first.
#[derive(Debug)]
pub struct Feature {
    /// Name of the layer. A channel of a file is named `name.channel`.
    pub name: &'static str,
    /// Names of its channels.
    pub channels: &'static [&'static str],
    /// Samples over which a pixel's mean runs.
    pub mean: MeanOver,
    /// Whether the layer is a color, which a file may hold as half floats.
    pub is_color: bool,
    /// Its means on the device, a value for each channel.
    pub of_film: fn(&FilmFeatures) -> &[f32],
}

/// Samples over which a mean runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeanOver {
    /// All samples; a miss counts as 0.
    Samples,
    /// Samples that hit a surface. Without any the mean is infinite.
    Hits,
}

impl MeanOver {
    /// Mean over no samples.
    pub(super) fn of_nothing(self) -> f32 {
        match self {
            Self::Samples => 0.0,
            Self::Hits => f32::INFINITY,
        }
    }
}

/// Names of a color's channels.
pub(super) const RGB: &[&str] = &["R", "G", "B"];
/// Names of a vector's channels.
const XYZ: &[&str] = &["X", "Y", "Z"];

/// Every feature, in the order in which a picture holds them.
pub static FEATURES: [Feature; 3] = [
    Feature { name: "albedo", channels: RGB, mean: MeanOver::Samples, is_color: true, of_film: |film| &film.albedo },
    Feature { name: "normal", channels: XYZ, mean: MeanOver::Samples, is_color: false, of_film: |film| &film.normal },
    Feature {
        name: "depth",
        channels: &["Z"],
        mean: MeanOver::Hits,
        is_color: false,
        of_film: |film| std::slice::from_ref(&film.depth),
    },
];

/// Place of a feature in [`FEATURES`].
const fn place_of(name: &str) -> usize {
    let mut at = 0;
    while at < FEATURES.len() {
        let (found, name) = (FEATURES[at].name.as_bytes(), name.as_bytes());
        let mut same = 0;
        while same < found.len() && same < name.len() && found[same] == name[same] {
            same += 1;
        }
        if same == found.len() && same == name.len() {
            return at;
        }
        at += 1;
    }
    panic!("FEATURES has no such row")
}

/// Place of the albedo in [`FEATURES`].
pub const ALBEDO: usize = place_of("albedo");
/// Place of the shading normal in [`FEATURES`].
pub const NORMAL: usize = place_of("normal");
/// Place of the depth in [`FEATURES`].
pub const DEPTH: usize = place_of("depth");

/// Number of channels of the features whose means run over `mean`.
pub(super) const fn channels_over(mean: MeanOver) -> usize {
    let (mut at, mut channels) = (0, 0);
    while at < FEATURES.len() {
        if FEATURES[at].mean as u8 == mean as u8 {
            channels += FEATURES[at].channels.len();
        }
        at += 1;
    }
    channels
}

/// Number of channels of all features.
pub(crate) const FEATURE_CHANNELS: usize = channels_over(MeanOver::Samples) + channels_over(MeanOver::Hits);
