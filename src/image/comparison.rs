//! Comparison of a picture with a reference by every measure, for people: the numbers of [`metrics`], SMAPE and FLIP.

use serde::Serialize;

use super::metrics::{self, Metrics};
use super::{Image, flip};
use crate::Result;

/// Term in the denominator of SMAPE that keeps it finite where both pictures are black.
const FLOOR: f64 = 1e-2;

/// Errors of a picture against a reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Comparison {
    /// Errors of the linear colors.
    #[serde(flatten)]
    pub metrics: Metrics,
    /// Mean of `|a - b| / (|a| + |b| + 0.01)`, `b` the reference.
    pub smape: f64,
    /// Mean of FLIP for pictures of high dynamic range, in [0, 1].
    pub flip: f64,
}

impl Comparison {
    /// Measures `image` against `reference`. Returns the errors and FLIP of every pixel.
    ///
    /// # Errors
    /// Where [`metrics::compare`] fails.
    pub fn new(image: &Image, reference: &Image) -> Result<(Self, Vec<f32>)> {
        let metrics = metrics::compare(image, reference)?;
        let map = flip::map(image, reference);
        let flip = map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len() as f64;
        Ok((Self { metrics, smape: smape(image, reference), flip }, map))
    }
}

fn smape(image: &Image, reference: &Image) -> f64 {
    let values = |image: &Image| image.pixels.as_flattened().to_vec();
    let terms = values(image).into_iter().zip(values(reference)).map(|(a, b)| {
        let (a, b) = (f64::from(a), f64::from(b));
        (a - b).abs() / (a.abs() + b.abs() + FLOOR)
    });
    terms.sum::<f64>() / (3 * image.pixels.len()) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smape_by_hand() {
        let image = |pixels: Vec<[f32; 3]>| Image { width: 2, height: 1, pixels };
        let (a, b) = (image(vec![[2.0; 3], [0.0; 3]]), image(vec![[1.0; 3], [0.0; 3]]));
        let (comparison, map) = Comparison::new(&a, &b).unwrap();
        assert!((comparison.smape - 0.5 / 3.01).abs() < 1e-12, "{comparison:?}");
        assert_eq!(comparison.metrics.mae, 0.5);
        assert!((comparison.flip - f64::from(map[0] + map[1]) / 2.0).abs() < 1e-7);
    }
}
