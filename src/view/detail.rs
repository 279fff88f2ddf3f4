//! Size of pictures while a camera moves, and length of steps while it rests, from the time that the last ones took.

use std::time::Duration;

use crate::settings::Settings;

/// Time that a small picture should take, in seconds. Ten of them fit a second, with the time on their way to the page.
const SMALL: f64 = 0.07;
/// Time that a step of a camera at rest should take, in seconds.
const STEP: f64 = 0.7;
/// Divisors of both sides of a small picture, and the place of the one for a scene whose speed is unknown.
const DIVISORS: [f64; 8] = [1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];
const FIRST: usize = 4;
/// Least length of the longer side of a small picture, in pixels.
const LEAST_SIDE: f64 = 64.0;
/// Times of a small picture, as multiples of the wanted one, between which its size stays.
const STAYS: [f64; 2] = [0.35, 1.4];

/// What the last pictures tell about the next one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Detail {
    /// Place of the divisor.
    at: usize,
    /// Seconds that a sample of a pixel of the picture at rest takes; `None` before the first step.
    per_sample: Option<f64>,
}

impl Default for Detail {
    fn default() -> Self {
        Self { at: FIRST, per_sample: None }
    }
}

impl Detail {
    /// Size of a small picture, where a picture at rest has this one.
    pub fn small(&self, size: [u32; 2]) -> [u32; 2] {
        let most = (f64::from(size[0].max(size[1])) / LEAST_SIDE).max(1.0);
        size.map(|side| ((f64::from(side) / DIVISORS[self.at].min(most)).round() as u32).max(1))
    }

    /// Notes how long a small picture took. The next one has another size if that was much too long or too short.
    pub fn took(&mut self, elapsed: Duration) {
        let share = elapsed.as_secs_f64() / SMALL;
        if (STAYS[0]..=STAYS[1]).contains(&share) {
            return;
        }
        // Time goes with the number of pixels, at most.
        let wanted = DIVISORS[self.at] * share.max(1.0e-3).sqrt();
        let fits = DIVISORS.iter().position(|&divisor| divisor >= 0.97 * wanted);
        self.at = fits.unwrap_or(DIVISORS.len() - 1);
    }

    /// Samples per pixel of the next step of a camera at rest, of which the schedule has `most`.
    pub fn samples(&self, settings: &Settings, most: u32) -> u32 {
        let fit = self.per_sample.map_or(1.0, |seconds| STEP / (seconds * pixels(settings)));
        (fit as u32).clamp(1, most.max(1))
    }

    /// Notes how long a step of a camera at rest took.
    pub fn took_samples(&mut self, settings: &Settings, samples: u32, elapsed: Duration) {
        self.per_sample = Some(elapsed.as_secs_f64().max(1.0e-6) / (f64::from(samples.max(1)) * pixels(settings)));
    }
}

fn pixels(settings: &Settings) -> f64 {
    let window = settings.window();
    f64::from(window.width) * f64::from(window.height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};

    fn settings([width, height]: [u32; 2]) -> Settings {
        let film = FilmDescription { width, height, crop: None, filter: ReconstructionFilter::Box };
        Settings::for_film(&film, &IntegratorDescription::default())
    }

    /// On devices of any speed, small pictures soon take the wanted time, or are as large or as small as they get, and stay so.
    #[test]
    fn small_pictures_take_the_wanted_time() {
        const SIZE: [u32; 2] = [480, 270];
        for per_pixel in [1.0e-8, 1.0e-6, 3.0e-6, 1.0e-5, 1.0e-3] {
            let mut detail = Detail::default();
            let mut sizes = Vec::new();
            for _ in 0..6 {
                let size = detail.small(SIZE);
                let seconds = per_pixel * f64::from(size[0]) * f64::from(size[1]);
                detail.took(Duration::from_secs_f64(seconds));
                sizes.push((size, seconds));
            }
            let (size, seconds) = sizes[5];
            let fits = seconds < SMALL * STAYS[1] && seconds > SMALL * STAYS[0] / 3.0;
            assert!(fits || size == SIZE || size == [64, 36], "{per_pixel}: {sizes:?}");
            assert_eq!(sizes[4].0, size, "{per_pixel}: {sizes:?}");
        }
    }

    #[test]
    fn steps_at_rest_take_the_wanted_time() {
        let settings = settings([100, 50]);
        let mut detail = Detail::default();
        assert_eq!(detail.samples(&settings, 8), 1);
        detail.took_samples(&settings, 1, Duration::from_secs(1));
        assert_eq!(detail.samples(&settings, 8), 1);
        detail.took_samples(&settings, 2, Duration::from_millis(400));
        assert_eq!((detail.samples(&settings, 8), detail.samples(&settings, 2)), (3, 2));
    }
}
