//! Film of a scene: size, crop and reconstruction filter.

/// Size, crop and reconstruction filter of a film.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FilmDescription {
    /// Width in pixels, > 0.
    pub width: u32,
    /// Height in pixels, > 0.
    pub height: u32,
    /// Window of the film that is rendered; `None` for the whole film.
    pub crop: Option<Crop>,
    /// Reconstruction filter.
    pub filter: ReconstructionFilter,
}

/// Window of the film, in pixels from its top left corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Crop {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// Width, > 0.
    pub width: u32,
    /// Height, > 0.
    pub height: u32,
}

impl Crop {
    /// The window scaled with the film, from its old size to a new one, so that it shows the same part of the picture.
    pub fn rescaled(self, [width, height]: [u32; 2], [new_width, new_height]: [u32; 2]) -> Self {
        let scale = |value: u32, old: u32, new: u32| (u64::from(value) * u64::from(new) / u64::from(old.max(1))) as u32;
        Self {
            x: scale(self.x, width, new_width),
            y: scale(self.y, height, new_height),
            width: scale(self.width, width, new_width).max(1),
            height: scale(self.height, height, new_height).max(1),
        }
    }
}

/// Reconstruction filter, applied by filter importance sampling. Radii are in pixels.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReconstructionFilter {
    /// Box filter: each sample counts equally within its own pixel.
    Box,
    /// Tent filter of the given radius (Mitsuba's default: 1).
    Tent {
        /// Radius at which the tent reaches zero.
        radius: f32,
    },
    /// Gaussian filter of the given standard deviation (Mitsuba's default: 0.5), cut off at four standard deviations,
    /// as in Mitsuba.
    Gaussian {
        /// Standard deviation.
        stddev: f32,
    },
}
