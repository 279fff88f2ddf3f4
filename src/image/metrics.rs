//! Error metrics of a picture against a reference.

use serde::{Deserialize, Deserializer, Serialize};

use super::{Image, tone};
use crate::{Error, Result};

/// Term in the denominator that keeps the relative error finite where the reference is black.
const RELATIVE_FLOOR: f64 = 1e-2;
/// Share of the pixels that the trimmed error keeps. A few fireflies would dominate the plain mean.
const TRIM_KEEP: f64 = 0.999;

/// Errors of a picture against a reference, averaged over pixels and channels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// The paper's error: mean absolute difference after the tone curve [`tone::paper`].
    pub mae_ldr: f64,
    /// Mean absolute difference.
    pub mae: f64,
    /// Mean squared difference.
    pub mse: f64,
    /// Mean of `(a - b)^2 / (b^2 + 0.01)`, `b` the reference.
    pub relmse: f64,
    /// Mean of the terms of `relmse` without the largest 0.1 %.
    pub relmse_trim: f64,
    /// Mean of the picture over mean of the reference: 1 where no energy is lost or gained. Infinite or not a number
    /// where the reference is black.
    #[serde(deserialize_with = "number_or_null")]
    pub mean_ratio: f64,
}

/// Reads a number, or `null` as NaN: JSON has no number that is not finite.
fn number_or_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Measures `image` against `reference`.
///
/// # Errors
/// [`Error::Settings`] where the sizes differ or there are no pixels; [`Error::Render`] where a pixel is not finite.
pub fn compare(image: &Image, reference: &Image) -> Result<Metrics> {
    check_same_size(image, reference)?;
    let mut comparison = Comparison::new(reference);
    comparison.add(&image.pixels);
    comparison.finish()
}

/// A comparison with a reference of a picture whose pixels come some at a time. Besides the reference, it takes 8 bytes a pixel.
pub struct Comparison<'a> {
    reference: &'a Image,
    sums: Sums,
    /// Relative error of each pixel so far.
    relative: Vec<f64>,
    /// Number of pixels so far that are not finite.
    broken: usize,
}

impl<'a> Comparison<'a> {
    /// A comparison without pixels yet.
    pub fn new(reference: &'a Image) -> Self {
        let relative = Vec::with_capacity(reference.pixels.len());
        Self { reference, sums: Sums::default(), relative, broken: 0 }
    }

    /// Adds the next pixels, row by row from the top left. Those beyond the reference's last do not count.
    pub fn add(&mut self, pixels: &[[f32; 3]]) {
        self.broken += count_of_broken(pixels);
        for (a, b) in pixels.iter().zip(&self.reference.pixels[self.relative.len()..]) {
            let (a, b) = (a.map(f64::from), b.map(f64::from));
            self.sums.add(a, b);
            self.relative.push(mean3(std::array::from_fn(|c| (a[c] - b[c]).powi(2) / (b[c] * b[c] + RELATIVE_FLOOR))));
        }
    }

    /// The errors.
    ///
    /// # Errors
    /// [`Error::Render`] where a pixel is not finite, and [`Error::Settings`] where pixels are missing.
    pub fn finish(self) -> Result<Metrics> {
        let Self { reference, sums, relative, broken } = self;
        let all = reference.pixels.len();
        if relative.len() != all {
            let message = format!("{} of the picture's pixels are there, but {all} of the reference", relative.len());
            return Err(Error::Settings(format!("{message}; compare pictures of one size")));
        }
        check_finite("first", broken, all)?;
        check_finite("second", count_of_broken(&reference.pixels), all)?;
        let value_count = 3.0 * all as f64;
        Ok(Metrics {
            mae_ldr: sums.absolute_ldr / value_count,
            mae: sums.absolute / value_count,
            mse: sums.squared / value_count,
            relmse: mean(&relative),
            relmse_trim: trimmed_mean(relative),
            mean_ratio: sums.image / sums.reference,
        })
    }
}

#[derive(Default)]
struct Sums {
    absolute_ldr: f64,
    absolute: f64,
    squared: f64,
    image: f64,
    reference: f64,
}

impl Sums {
    fn add(&mut self, a: [f64; 3], b: [f64; 3]) {
        let (shown_a, shown_b) = (tone::paper(a), tone::paper(b));
        for c in 0..3 {
            self.absolute_ldr += (shown_a[c] - shown_b[c]).abs();
            self.absolute += (a[c] - b[c]).abs();
            self.squared += (a[c] - b[c]).powi(2);
            self.image += a[c];
            self.reference += b[c];
        }
    }
}

fn mean3(values: [f64; 3]) -> f64 {
    values.iter().sum::<f64>() / 3.0
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    let kept = ((values.len() as f64 * TRIM_KEEP) as usize).max(1);
    values.sort_unstable_by(f64::total_cmp);
    mean(&values[..kept])
}

fn check_same_size(image: &Image, reference: &Image) -> Result<()> {
    let [first, second] = [image, reference].map(|image| format!("{}x{}", image.width, image.height));
    if first != second {
        let message = format!("the pictures' sizes differ, {first} and {second}; compare pictures of one size");
        return Err(Error::Settings(message));
    }
    if image.pixels.is_empty() {
        return Err(Error::Settings("the pictures have no pixels; compare larger ones".into()));
    }
    Ok(())
}

fn count_of_broken(pixels: &[[f32; 3]]) -> usize {
    pixels.iter().filter(|pixel| !pixel.iter().all(|value| value.is_finite())).count()
}

fn check_finite(which: &str, broken: usize, total: usize) -> Result<()> {
    if broken == 0 {
        return Ok(());
    }
    Err(Error::Render(format!(
        "the {which} picture has {broken} of {total} pixels that are infinite or not a number; render it again"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: u32 = 64;
    const HEIGHT: u32 = 32;

    fn image(value: impl Fn(u32, u32, u32) -> f32) -> Image {
        let pixel = |i: u32| std::array::from_fn(|c| value(i % WIDTH, i / WIDTH, c as u32));
        Image { width: WIDTH, height: HEIGHT, pixels: (0..WIDTH * HEIGHT).map(pixel).collect() }
    }

    /// `((7 x + 13 y + 5 c) mod 32) / 16 - 1/8`, with a firefly and a negative value; all exact in binary.
    fn first() -> Image {
        let mut image = image(|x, y, c| ((x * 7 + y * 13 + c * 5) % 32) as f32 / 16.0 - 0.125);
        image.pixels[(5 * WIDTH + 7) as usize] = [1000.0; 3];
        image.pixels[(9 * WIDTH + 1) as usize][0] = -50.0;
        image
    }

    /// `((11 x + 3 y + 9 c) mod 29) / 8`.
    fn second() -> Image {
        image(|x, y, c| ((x * 11 + y * 3 + c * 9) % 29) as f32 / 8.0)
    }

    fn assert_close(value: f64, expected: f64) {
        assert!((value / expected - 1.0).abs() < 1e-9, "{value} is not {expected}");
    }

    /// The expected numbers come from an independent implementation of the formulas in numpy.
    #[test]
    fn agrees_with_an_independent_implementation() {
        let metrics = compare(&first(), &second()).unwrap();
        assert_close(metrics.mae_ldr, 0.358_326_667_766_677_9);
        assert_close(metrics.mae, 1.715_627_034_505_208_3);
        assert_close(metrics.mse, 489.241_782_506_306_95);
        assert_close(metrics.relmse, 483.958_270_971_162);
        assert_close(metrics.relmse_trim, 5.477_645_549_117_699);
        assert_close(metrics.mean_ratio, 0.756_124_928_779_897_9);
    }

    /// Rows that come one after the other give the bits of a whole picture.
    #[test]
    fn pixels_may_come_some_at_a_time() {
        let (first, second) = (first(), second());
        let mut comparison = Comparison::new(&second);
        first.pixels.chunks(100).for_each(|pixels| comparison.add(pixels));
        assert_eq!(comparison.finish().unwrap(), compare(&first, &second).unwrap());
        let mut comparison = Comparison::new(&second);
        comparison.add(&first.pixels[1..]);
        assert!(comparison.finish().is_err());
    }

    #[test]
    fn one_pixel_by_hand() {
        let gray = |value| Image { width: 1, height: 1, pixels: vec![[value; 3]] };
        let metrics = compare(&gray(2.0), &gray(1.0)).unwrap();
        // (2 / (1 + 2/1.5))^(1/2.2) - (1 / (1 + 1/1.5))^(1/2.2)
        assert_close(metrics.mae_ldr, (6.0f64 / 7.0).powf(1.0 / 2.2) - 0.6f64.powf(1.0 / 2.2));
        assert_close(metrics.mae, 1.0);
        assert_close(metrics.mse, 1.0);
        assert_close(metrics.relmse, 1.0 / 1.01);
        assert_close(metrics.relmse_trim, 1.0 / 1.01);
        assert_close(metrics.mean_ratio, 2.0);
    }

    #[test]
    fn equal_pictures_have_no_error() {
        let metrics = compare(&second(), &second()).unwrap();
        let errors = [metrics.mae_ldr, metrics.mae, metrics.mse, metrics.relmse, metrics.relmse_trim];
        assert_eq!(errors, [0.0; 5]);
        assert_eq!(metrics.mean_ratio, 1.0);
    }

    #[test]
    fn keys_are_those_scripts_rely_on() {
        let metrics = serde_json::to_value(compare(&first(), &second()).unwrap()).unwrap();
        let keys: Vec<_> = metrics.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(keys, ["mae", "mae_ldr", "mean_ratio", "mse", "relmse", "relmse_trim"]);
    }

    #[test]
    fn refuses_what_cannot_be_compared() {
        let narrow = second().crop([0, 0], 5, 4).unwrap();
        let error = compare(&narrow, &second()).unwrap_err().to_string();
        assert!(error.contains("5x4") && error.contains("64x32"), "{error}");
        let mut broken = second();
        broken.pixels[3][1] = f32::NAN;
        broken.pixels[4] = [f32::INFINITY; 3];
        let error = compare(&second(), &broken).unwrap_err().to_string();
        assert!(error.contains("second picture has 2 of 2048 pixels"), "{error}");
        let empty = Image { width: 0, height: 0, pixels: vec![] };
        assert!(compare(&empty, &empty).is_err());
    }
}
