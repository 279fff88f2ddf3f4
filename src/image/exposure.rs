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

impl Exposure {
    /// Number of stops for a picture. Pixels that show no surface do not count, nor do black ones.
    pub fn stops(self, pixels: &[[f32; 3]], shows_surface: impl Fn(usize) -> bool) -> f32 {
        let Self::Auto = self else {
            return if let Self::Stops(stops) = self { stops } else { 0.0 };
        };
        let of = |counts: &dyn Fn(usize) -> bool| -> Vec<f64> {
            let pixels = pixels.iter().enumerate().filter(|(at, _)| counts(*at));
            let luminances = pixels.map(|(_, pixel)| luminance(pixel.map(f64::from)));
            luminances.filter(|luminance| luminance.is_finite() && *luminance > 0.0).collect()
        };
        let mut luminances = of(&shows_surface);
        if luminances.is_empty() {
            luminances = of(&|_| true);
        }
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

    #[test]
    fn most_of_the_surfaces_become_darker_than_white() {
        // 90 pixels of 0.05, nine of 51.2, a firefly, and a background of 1000.
        let mut pixels = vec![[0.05; 3]; 90];
        pixels.extend([[51.2; 3]; 9]);
        pixels.push([f32::MAX; 3]);
        pixels.extend([[1000.0; 3]; 50]);
        assert_eq!(Exposure::Auto.stops(&pixels, |at| at < 100), -6.0);
        assert_eq!(Exposure::Auto.stops(&pixels, |at| at < 90), 4.0);
        assert_eq!(Exposure::Stops(1.5).stops(&pixels, |_| true), 1.5);
    }

    #[test]
    fn pictures_without_light_or_surfaces_have_an_exposure() {
        assert_eq!(Exposure::Auto.stops(&[[0.0; 3], [f32::NAN; 3]], |_| true), 0.0);
        assert_eq!(Exposure::Auto.stops(&[], |_| true), 0.0);
        assert_eq!(Exposure::Auto.stops(&[[0.2; 3]; 4], |_| false), 2.0);
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
