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

/// Window of a film, as people ask for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Window {
    /// In pixels.
    Pixels(Crop),
    /// Left edge, upper edge, width and height as shares of the film.
    Shares([f64; 4]),
}

impl Window {
    /// The window in pixels of a film of this size. Edges are rounded to pixels, so windows that touch share none, unless one is narrower than a pixel.
    pub fn within(self, [width, height]: [u32; 2]) -> Crop {
        let [left, top, share_of_width, share_of_height] = match self {
            Self::Pixels(crop) => return crop,
            Self::Shares(shares) => shares,
        };
        let edges = |first: f64, share: f64, side: u32| {
            let edge = |at: f64| (at * f64::from(side)).round().min(f64::from(side)) as u32;
            let first_pixel = edge(first).min(side - 1);
            (first_pixel, edge(first + share).saturating_sub(first_pixel).max(1))
        };
        let ((x, width), (y, height)) = (edges(left, share_of_width, width), edges(top, share_of_height, height));
        Crop { x, y, width, height }
    }
}

#[test]
fn shares_of_a_film_are_rounded_to_pixels() {
    let crop = |shares, size| {
        let Crop { x, y, width, height } = Window::Shares(shares).within(size);
        [x, y, width, height]
    };
    assert_eq!(crop([0.25, 0.25, 0.5, 0.5], [64, 32]), [16, 8, 32, 16]);
    assert_eq!(crop([0.0, 0.0, 1.0, 1.0], [7, 5]), [0, 0, 7, 5]);
    // Halves of an odd side touch, and the smallest window has a pixel.
    assert_eq!((crop([0.0, 0.0, 0.5, 1.0], [7, 1])[2], crop([0.5, 0.0, 0.5, 1.0], [7, 1])[0]), (4, 4));
    assert_eq!(crop([0.999, 0.999, 0.001, 0.001], [10, 10]), [9, 9, 1, 1]);
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
