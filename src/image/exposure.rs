//! Exposures of pictures that are shown.

use serde::{Deserialize, Serialize};

use crate::math::srgb::luminance;

/// Luminance below which an automatic exposure brings most of a picture.
const BRIGHT: f64 = 0.8;
/// Share of the pixels that an automatic exposure brings below [`BRIGHT`].
const MOST: f64 = 0.95;
/// Largest number of stops of an automatic exposure.
const MOST_STOPS: f64 = 40.0;

/// Exposure of a picture that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Exposure {
    /// The colors times two to the power of this number.
    Stops(f32),
    /// The number of stops that brings 95 % of the pixels below 0.8.
    Auto,
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

/// Luminances by which an automatic exposure is chosen: 8 bytes a pixel.
#[derive(Debug, Clone, Default)]
pub struct Luminances {
    of_surfaces: Vec<f64>,
    /// Luminances of pixels that show no surface. They count where no others do.
    of_others: Vec<f64>,
}

impl Luminances {
    /// Adds pixels, and whether each shows a surface. Black ones do not count.
    pub fn add<'a>(&mut self, pixels: impl Iterator<Item = (&'a [f32; 3], bool)>) {
        for (pixel, shows_surface) in pixels {
            let luminance = luminance(pixel.map(f64::from));
            if luminance.is_finite() && luminance > 0.0 {
                if shows_surface { &mut self.of_surfaces } else { &mut self.of_others }.push(luminance);
            }
        }
    }
}

impl Exposure {
    /// Number of stops for a picture. Pixels that show no surface do not count, nor do black ones.
    pub fn stops(self, Luminances { of_surfaces, of_others }: Luminances) -> f32 {
        let Self::Auto = self else {
            return if let Self::Stops(stops) = self { stops } else { 0.0 };
        };
        let mut luminances = if of_surfaces.is_empty() { of_others } else { of_surfaces };
        if luminances.is_empty() {
            return 0.0;
        }
        let at = ((luminances.len() - 1) as f64 * MOST) as usize;
        let (_, bright, _) = luminances.select_nth_unstable_by(at, f64::total_cmp);
        let stops = (BRIGHT / *bright).log2().clamp(-MOST_STOPS, MOST_STOPS);
        // As it is printed, so that --exposure with that number makes the same picture.
        ((100.0 * stops).round() / 100.0) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stops(exposure: Exposure, pixels: &[[f32; 3]], shows_surface: impl Fn(usize) -> bool) -> f32 {
        let mut luminances = Luminances::default();
        luminances.add(pixels.iter().enumerate().map(|(at, pixel)| (pixel, shows_surface(at))));
        exposure.stops(luminances)
    }

    #[test]
    fn most_of_the_surfaces_become_darker_than_white() {
        // 90 pixels of 0.05, nine of 51.2, a firefly, and a background of 1000.
        let mut pixels = vec![[0.05; 3]; 90];
        pixels.extend([[51.2; 3]; 9]);
        pixels.push([f32::MAX; 3]);
        pixels.extend([[1000.0; 3]; 50]);
        assert_eq!(stops(Exposure::Auto, &pixels, |at| at < 100), -6.0);
        assert_eq!(stops(Exposure::Auto, &pixels, |at| at < 90), 4.0);
        assert_eq!(stops(Exposure::Stops(1.5), &pixels, |_| true), 1.5);
    }

    #[test]
    fn pictures_without_light_or_surfaces_have_an_exposure() {
        assert_eq!(stops(Exposure::Auto, &[[0.0; 3], [f32::NAN; 3]], |_| true), 0.0);
        assert_eq!(stops(Exposure::Auto, &[], |_| true), 0.0);
        assert_eq!(stops(Exposure::Auto, &[[0.2; 3]; 4], |_| false), 2.0);
    }

    /// Checkpoints keep an exposure as a number, as before there was an automatic one, or as nothing.
    #[test]
    fn checkpoints_keep_exposures() {
        for (exposure, text) in [(Exposure::Stops(-1.5), "-1.5"), (Exposure::Auto, "null")] {
            assert_eq!(serde_json::to_string(&exposure).unwrap(), text);
            assert_eq!(serde_json::from_str::<Exposure>(text).unwrap(), exposure);
        }
    }
}
