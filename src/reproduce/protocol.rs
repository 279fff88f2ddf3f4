//! Protocol of the paper's measurements: no emitter sampling, at most 16 edges, Russian roulette after 8 edges, a box
//! filter, independent samples, steps of equal length, and the paper's grids. Pictures are so small that a plain path
//! tracer reaches about a thousand samples per pixel.

use crate::image::Image;
use crate::scene::ReconstructionFilter;
use crate::settings::{GuideSet, Roulette, SamplePattern, SampleWeights, Settings, StepSchedule};
use crate::{Error, Result};

const MAX_DEPTH: u32 = 16;
const RR_DEPTH: u32 = 8;
/// Cells along each axis of the grid.
pub const GRID: u32 = 8;
/// Direction bins along each side of the map.
pub const DIRECTIONS: u32 = 16;
/// Samples per pixel that the method `bsdf` should reach.
const TARGET_SPP: f64 = 1000.0;
/// Minimum side of a picture, in pixels.
const LEAST_SIDE: u32 = 32;

/// Settings that a method starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// Settings of the paper's tables.
    Paper,
    /// Default settings of a render of the scene. Depths and filter are the paper's.
    Defaults,
}

/// Settings of all methods with this base, for a scene with these defaults. A method's own changes are not included.
pub fn settings(base: Base, defaults: Settings, [width, height]: [u32; 2]) -> Settings {
    let (filter, max_depth, rr_depth) = (ReconstructionFilter::Box, MAX_DEPTH, RR_DEPTH);
    let common = Settings { width, height, crop: None, filter, max_depth, rr_depth, nee: false, ..defaults };
    match base {
        Base::Defaults => common,
        Base::Paper => Settings {
            pattern: SamplePattern::Independent,
            guide_set: GuideSet::Diffuse,
            steps: StepSchedule::Even,
            sample_weights: Some(SampleWeights::Even),
            grid: Some(GRID),
            fallback: Some(0.0),
            directions: DIRECTIONS,
            bsdf_share: None,
            light_selection: None,
            roulette: Some(Roulette::Throughput),
            ..common
        },
    }
}

/// Factors by which a reference can be averaged down to whole pixels, ascending.
pub fn factors([width, height]: [u32; 2]) -> Vec<u32> {
    (1..=width.min(height)).filter(|&factor| width.is_multiple_of(factor) && height.is_multiple_of(factor)).collect()
}

/// Factor for pictures of `scale` times the reference's size.
///
/// # Errors
/// Fails if the reference cannot be averaged down to that size.
pub fn factor_of_scale(size: [u32; 2], scale: f32) -> Result<u32> {
    let factors = factors(size);
    let is_meant = |factor: &&u32| (scale * **factor as f32 - 1.0).abs() < 1.0e-3;
    factors.iter().find(is_meant).copied().ok_or_else(|| {
        let scales: Vec<_> = factors.iter().map(|&factor| format!("{:.4}", 1.0 / factor as f32)).collect();
        let [width, height] = size;
        Error::Settings(format!(
            "--scale {scale}: a reference of {width} x {height} pixels can be averaged down to {}",
            scales.join(", ")
        ))
    })
}

/// Factor with which a plain path tracer reaches a thousand samples per pixel within `budget` seconds, given its time
/// per path.
pub fn factor_for(size: [u32; 2], seconds_per_path: f64, budget: f64) -> u32 {
    let spp = |factor: u32| {
        let pixels = f64::from(size[0] / factor) * f64::from(size[1] / factor);
        budget / (seconds_per_path * pixels)
    };
    let allowed =
        factors(size).into_iter().filter(|&factor| factor == 1 || size[0].min(size[1]) / factor >= LEAST_SIDE);
    let allowed: Vec<_> = allowed.collect();
    let enough = allowed.iter().find(|&&factor| spp(factor) >= TARGET_SPP);
    enough.or(allowed.last()).copied().unwrap_or(1)
}

/// Picture whose pixels are means of `factor` x `factor` pixels of the reference. This is exact for a box filter. The
/// factor must divide both sides.
pub fn average_down(reference: &Image, factor: u32) -> Image {
    let [width, height] = [reference.width / factor, reference.height / factor];
    let mean = |i: u32| {
        let (left, top) = (i % width * factor, i / width * factor);
        let mut sum = [0.0_f64; 3];
        for at in (0..factor * factor).map(|j| (top + j / factor) * reference.width + left + j % factor) {
            let pixel = reference.pixels[at as usize];
            sum = std::array::from_fn(|c| sum[c] + f64::from(pixel[c]));
        }
        sum.map(|sum| (sum / f64::from(factor * factor)) as f32)
    };
    Image { width, height, pixels: (0..width * height).map(mean).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_pixels_are_averaged() {
        assert_eq!(factors([320, 180]), [1, 2, 4, 5, 10, 20]);
        assert_eq!(factor_of_scale([320, 180], 0.25).expect("a factor"), 4);
        let error = factor_of_scale([320, 180], 0.3).expect_err("a refusal").to_string();
        assert!(error.contains("320 x 180") && error.contains("0.2500, 0.2000"), "{error}");
    }

    #[test]
    fn pictures_are_as_large_as_the_budget_allows() {
        // The picture has 57,600 pixels. In 10 s, at a microsecond per path, 10^4 pixels get their thousand samples.
        assert_eq!(factor_for([320, 180], 1.0e-6, 57.7), 1);
        assert_eq!(factor_for([320, 180], 1.0e-6, 57.5), 2);
        assert_eq!(factor_for([320, 180], 1.0e-6, 14.0), 4);
        // The factor leaves a side of 36 pixels, however long a path takes. A small reference keeps its size.
        assert_eq!(factor_for([320, 180], 1.0, 1.0), 5);
        assert_eq!(factor_for([20, 20], 1.0, 1.0), 1);
    }

    #[test]
    fn means_are_of_the_right_pixels() {
        let pixels = (0..24).map(|i| [i as f32, 1.0, -(i as f32)]).collect();
        let small = average_down(&Image { width: 6, height: 4, pixels }, 2);
        assert_eq!((small.width, small.height), (3, 2));
        // The means of the pixels 2, 3, 8 and 9, and of the pixels 16, 17, 22 and 23.
        assert_eq!((small.pixels[1], small.pixels[5]), ([5.5, 1.0, -5.5], [19.5, 1.0, -19.5]));
    }
}
