//! Light of media by their temperature: the spectrum of a black body whose largest value is 1.

use super::colors;
use crate::scene::spectrum;

/// pbrt's lowest temperature in kelvin of a medium that glows.
const COLDEST: f64 = 100.0;
/// Temperature from which on the color of a black body changes no more.
const HOTTEST: f64 = 1.0e6;
const STEPS: usize = 2048;

/// Colors of black bodies, by the logarithm of their temperature.
pub(super) struct Glow {
    colors: Vec<[f64; 3]>,
}

impl Glow {
    pub fn new() -> Self {
        let color = |step: usize| {
            let temperature = COLDEST * (HOTTEST / COLDEST).powf(step as f64 / STEPS as f64);
            let points = colors::planck(temperature);
            // Wien's law, in nm.
            let peak = colors::planck_at(temperature, 2.897_771_955e6 / temperature);
            let color = spectrum::of_light(&points);
            color.map(|channel| if peak > 0.0 { (channel / peak).max(0.0) } else { 0.0 })
        };
        Self { colors: (0..=STEPS).map(color).collect() }
    }

    /// Radiance at a temperature, in linear sRGB.
    pub fn at(&self, temperature: f64) -> [f64; 3] {
        if temperature.is_nan() || temperature <= COLDEST {
            return [0.0; 3];
        }
        let place = (temperature.min(HOTTEST) / COLDEST).ln() / (HOTTEST / COLDEST).ln() * STEPS as f64;
        let step = (place as usize).min(STEPS - 1);
        let share = place - step as f64;
        let (one, other) = (self.colors[step], self.colors[step + 1]);
        std::array::from_fn(|channel| one[channel] + share * (other[channel] - one[channel]))
    }
}
