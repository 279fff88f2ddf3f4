//! How far a picture is from a reference.

use serde::Serialize;

use super::{Image, tone};
use crate::{Error, Result};

/// Keeps the relative error finite where the reference is black.
const RELATIVE_FLOOR: f64 = 1e-2;
/// Share of the pixels that the trimmed error keeps: a few fireflies would decide the plain mean.
const TRIM_KEEP: f64 = 0.999;

/// Errors of a picture against a reference, averaged over pixels and channels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Metrics {
    /// The paper's error: mean absolute difference of what [`tone::paper`] shows.
    pub mae_ldr: f64,
    /// Mean absolute difference.
    pub mae: f64,
    /// Mean squared difference.
    pub mse: f64,
    /// Mean of `(a - b)^2 / (b^2 + 0.01)`, `b` the reference.
    pub relmse: f64,
    /// The same without the worst 0.1 % of the pixels.
    pub relmse_trim: f64,
    /// Mean of the picture over mean of the reference: 1 where no energy is lost or made up. Infinite or not a number
    /// where the reference is black.
    pub mean_ratio: f64,
}

/// Measures `image` against `reference`.
pub fn compare(image: &Image, reference: &Image) -> Result<Metrics> {
    check_same_size(image, reference)?;
    check_finite("first", image)?;
    check_finite("second", reference)?;
    let pairs = || image.pixels.iter().zip(&reference.pixels).map(|(a, b)| (a.map(f64::from), b.map(f64::from)));
    let (mut sums, mut relative) = (Sums::default(), Vec::with_capacity(image.pixels.len()));
    for (a, b) in pairs() {
        sums.add(a, b);
        relative.push(mean3(std::array::from_fn(|c| (a[c] - b[c]).powi(2) / (b[c] * b[c] + RELATIVE_FLOOR))));
    }
    let value_count = 3.0 * image.pixels.len() as f64;
    Ok(Metrics {
        mae_ldr: sums.absolute_ldr / value_count,
        mae: sums.absolute / value_count,
        mse: sums.squared / value_count,
        relmse: mean(&relative),
        relmse_trim: trimmed_mean(relative),
        mean_ratio: sums.image / sums.reference,
    })
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
    let sizes = [image, reference].map(|i| format!("{}x{}", i.width, i.height));
    if sizes[0] != sizes[1] {
        let message = "compare pictures of one size, or render the second one's window with --crop";
        return Err(Error::Settings(format!("the pictures' sizes differ, {} and {}; {message}", sizes[0], sizes[1])));
    }
    if image.pixels.is_empty() {
        return Err(Error::Settings("the pictures have no pixels; compare larger ones".into()));
    }
    Ok(())
}

fn check_finite(which: &str, image: &Image) -> Result<()> {
    let count = image.pixels.iter().filter(|pixel| !pixel.iter().all(|value| value.is_finite())).count();
    if count == 0 {
        return Ok(());
    }
    let total = image.pixels.len();
    Err(Error::Render(format!(
        "the {which} picture has {count} of {total} pixels that are infinite or not a number; render it again"
    )))
}
