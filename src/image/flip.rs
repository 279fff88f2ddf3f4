//! FLIP: the difference of two pictures as a viewer sees it who flips between them, for displayed pictures ("FLIP: A Difference
//! Evaluator for Alternating Images", Andersson et al. 2020) and for pictures of high dynamic range ("Visualizing Errors in
//! Rendered High Dynamic Range Images", Andersson et al. 2021).
//!
//! `tests/data/flip` holds values of the authors' program. The crate `nv-flip` is not used: it takes 8-bit pictures only, and
//! building it needs a C++ compiler.

use rayon::prelude::*;

use super::Image;

/// Pixels per degree of the viewer's field of view: a 0.7 m wide display of 3840 pixels, seen from 0.7 m.
const PIXELS_PER_DEGREE: f32 = 67.020_64;
/// Exponent and knee of the color difference (`q_c`, `p_c`, `p_t` of the paper).
const COLOR_EXPONENT: f32 = 0.7;
const COLOR_KNEE: f32 = 0.4;
const COLOR_KNEE_VALUE: f32 = 0.95;
/// Width in degrees of the filters that find edges and points (`w`), and the exponent of their difference (`q_f`).
const FEATURE_WIDTH: f32 = 0.082;
const FEATURE_EXPONENT: f32 = 0.5;
/// Amplitudes `a` and spreads `b` of the eye's filters for luminance, red against green, and blue against yellow (two Gaussians).
const LUMINANCE: [f32; 2] = [1.0, 0.0047];
const RED_GREEN: [f32; 2] = [1.0, 0.0053];
const BLUE_YELLOW: [[f32; 2]; 2] = [[34.1, 0.04], [13.5, 0.025]];
/// White of D65, and the matrices between linear sRGB and XYZ. XYZ is divided by the white.
const WHITE: [f32; 3] = [0.950_428_5, 1.0, 1.088_900_4];
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];
/// Coefficients of the tone curve ACES: `(a x² + b x + c) / (d x² + e x + f)`.
const ACES: [f32; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];
/// Display value at which the brightest and the median luminance are exposed in turn.
const EXPOSED_VALUE: f32 = 0.85;

/// FLIP of every pixel, in [0, 1], row by row from the top left. Both images are linear sRGB of any range and have one size.
/// The largest difference over a series of exposures counts, which the reference decides. Values below 0 count as 0.
pub fn map(image: &Image, reference: &Image) -> Vec<f32> {
    let mut largest = vec![0.0f32; reference.pixels.len()];
    if largest.is_empty() {
        return largest;
    }
    for exposure in exposures(reference) {
        let scale = exposure.exp2();
        let [image, reference] = [image, reference].map(|image| displayed(image, scale));
        for (largest, error) in largest.iter_mut().zip(map_displayed(&image, &reference)) {
            *largest = largest.max(error);
        }
    }
    largest
}

/// FLIP of every pixel of two images whose linear values in [0, 1] a display shows as they are.
pub fn map_displayed(image: &Image, reference: &Image) -> Vec<f32> {
    let (width, height) = (reference.width as usize, reference.height as usize);
    let [image, reference] = [image, reference].map(|image| {
        let pixels = image.pixels.par_iter().map(|&pixel| opponent(pixel)).collect::<Vec<_>>();
        Plane { width, height, pixels }
    });
    let colors = [&image, &reference].map(seen_colors);
    let features = [&image, &reference].map(features);
    let difference = |at: usize| {
        let color = color_difference(colors[0][at], colors[1][at]);
        let [edges, points] = [0, 1].map(|kind| (features[0][at][kind] - features[1][at][kind]).abs());
        let feature = (edges.max(points) / 2.0f32.sqrt()).powf(FEATURE_EXPONENT);
        color.powf(1.0 - feature)
    };
    (0..width * height).into_par_iter().map(difference).collect()
}

/// Exposures in stops, from the one that shows the brightest pixel to the one that shows the median, about one stop apart.
fn exposures(reference: &Image) -> Vec<f32> {
    let luminance =
        |pixel: &[f32; 3]| 0.2126 * pixel[0].max(0.0) + 0.7152 * pixel[1].max(0.0) + 0.0722 * pixel[2].max(0.0);
    let mut all: Vec<f32> = reference.pixels.iter().map(luminance).collect();
    all.sort_unstable_by(f32::total_cmp);
    let brightest = all[all.len() - 1];
    let middle = (all.len() / 2).max(1);
    let mut median = 0.5 * (all[middle - 1] + all[middle.min(all.len() - 1)]);
    if brightest <= 0.0 {
        return vec![0.0];
    }
    if median <= 0.0 {
        // More than half of the picture is black. Then the median of the rest decides.
        let lit = &all[all.partition_point(|&value| value <= 0.0)..];
        median = lit[lit.len() / 2];
    }
    let [a, b, c] = [0, 1, 2].map(|i| ACES[i] - EXPOSED_VALUE * ACES[i + 3]);
    let half = -0.5 * b / a;
    let exposed = half + (half * half - c / a).sqrt();
    let [start, stop] = [brightest, median].map(|value| (exposed / value).log2());
    let count = ((stop - start).ceil() as usize).max(2);
    let step = (stop - start) / (count - 1) as f32;
    (0..count).map(|at| start + step * at as f32).collect()
}

/// Linear values in [0, 1] that a display shows of `image`, brighter by `scale`.
fn displayed(image: &Image, scale: f32) -> Image {
    let [a, b, c, d, e, f] = ACES;
    let shown = |value: f32| {
        // Infinity would give no number; 1e15 is white too.
        let x = (value * scale).clamp(0.0, 1.0e15);
        ((a * x * x + b * x + c) / (d * x * x + e * x + f)).clamp(0.0, 1.0)
    };
    Image { pixels: image.pixels.par_iter().map(|pixel| pixel.map(shown)).collect(), ..*image }
}

/// Values of each pixel, row by row.
struct Plane {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

/// Convolves along rows, or along columns. Pixels beyond the edge have the values of the edge. `term` adds a pixel, `tap` pixels
/// from the center, to the sum.
fn convolve<const IN: usize, const OUT: usize>(
    pixels: &[[f32; IN]],
    [width, height]: [usize; 2],
    radius: usize,
    by_columns: bool,
    term: impl Fn(&mut [f32; OUT], usize, &[f32; IN]) + Sync,
) -> Vec<[f32; OUT]> {
    let pixel = |at: usize| {
        let (x, y) = (at % width, at / width);
        let mut sum = [0.0; OUT];
        for tap in 0..=2 * radius {
            let moved = |from: usize, size: usize| (from + tap).saturating_sub(radius).min(size - 1);
            let from = if by_columns { moved(y, height) * width + x } else { y * width + moved(x, width) };
            term(&mut sum, tap, &pixels[from]);
        }
        sum
    };
    (0..width * height).into_par_iter().with_min_len(1024).map(pixel).collect()
}

/// Weights of a symmetric filter from its left end to its right end.
fn weights(radius: usize, weight: impl Fn(f32) -> f32) -> Vec<f32> {
    (0..=2 * radius).map(|tap| weight(tap as f32 - radius as f32)).collect()
}

/// Colors in L*a*b* with chroma adapted to the luminance (Hunt), after the eye's blur.
fn seen_colors(plane: &Plane) -> Vec<[f32; 3]> {
    use std::f32::consts::PI;
    let widest = BLUE_YELLOW[0][1];
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as usize;
    let gaussian = |[a, b]: [f32; 2], is_root: bool| {
        let amplitude = a * (PI / b).sqrt();
        let amplitude = if is_root { amplitude.sqrt() } else { amplitude };
        weights(radius, |x| amplitude * (-PI * PI * (x / PIXELS_PER_DEGREE).powi(2) / b).exp())
    };
    let normalized = |filter: Vec<f32>, sum: f32| filter.into_iter().map(|weight| weight / sum).collect::<Vec<_>>();
    let [y, cx] = [LUMINANCE, RED_GREEN].map(|filter| {
        let filter = gaussian(filter, false);
        let sum = filter.iter().sum();
        normalized(filter, sum)
    });
    // A sum of two Gaussians is no product of two filters, so each has its own, with the root of its amplitude.
    let cz = BLUE_YELLOW.map(|filter| gaussian(filter, true));
    let norm = cz.each_ref().map(|filter| filter.iter().sum::<f32>());
    let norm = (norm[0] * norm[0] + norm[1] * norm[1]).sqrt();
    let [cz1, cz2] = cz.map(|filter| normalized(filter, norm));
    let size = [plane.width, plane.height];
    let rows = convolve(&plane.pixels, size, radius, false, |sum: &mut [f32; 4], tap, pixel: &[f32; 3]| {
        sum[0] += y[tap] * pixel[0];
        sum[1] += cx[tap] * pixel[1];
        sum[2] += cz1[tap] * pixel[2];
        sum[3] += cz2[tap] * pixel[2];
    });
    let blurred = convolve(&rows, size, radius, true, |sum: &mut [f32; 4], tap, row: &[f32; 4]| {
        sum[0] += y[tap] * row[0];
        sum[1] += cx[tap] * row[1];
        sum[2] += cz1[tap] * row[2];
        sum[3] += cz2[tap] * row[3];
    });
    let seen =
        |[y, cx, cz1, cz2]: [f32; 4]| adapted_lab(rgb_of_opponent([y, cx, cz1 + cz2]).map(|c| c.clamp(0.0, 1.0)));
    blurred.into_par_iter().map(seen).collect()
}

/// Strength of edges and of points in the luminance.
fn features(plane: &Plane) -> Vec<[f32; 2]> {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as usize;
    let gaussian = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
    // Positive weights add up to 1 and negative ones to -1; the Gaussian has no negative ones.
    let normalized = |filter: Vec<f32>| {
        let sum = |sign: f32| filter.iter().map(|weight| (sign * weight).max(0.0)).sum::<f32>();
        let (positive, negative) = (sum(1.0), sum(-1.0));
        filter
            .iter()
            .map(|&weight| weight / if weight > 0.0 { positive } else { negative.max(f32::MIN_POSITIVE) })
            .collect::<Vec<_>>()
    };
    let smooth = normalized(weights(radius, gaussian));
    let edge = normalized(weights(radius, |x| -x * gaussian(x)));
    let point = normalized(weights(radius, |x| (x * x / (deviation * deviation) - 1.0) * gaussian(x)));
    let size = [plane.width, plane.height];
    let rows = convolve(&plane.pixels, size, radius, false, |sum: &mut [f32; 3], tap, pixel: &[f32; 3]| {
        let luminance = (pixel[0] + 16.0) / 116.0;
        sum[0] += edge[tap] * luminance;
        sum[1] += point[tap] * luminance;
        sum[2] += smooth[tap] * luminance;
    });
    let both = convolve(&rows, size, radius, true, |sum: &mut [f32; 4], tap, row: &[f32; 3]| {
        sum[0] += smooth[tap] * row[0];
        sum[1] += edge[tap] * row[2];
        sum[2] += smooth[tap] * row[1];
        sum[3] += point[tap] * row[2];
    });
    both.into_iter().map(|[ex, ey, px, py]| [ex.hypot(ey), px.hypot(py)]).collect()
}

/// Color difference in [0, 1] of two adapted L*a*b* colors: the HyAB distance, with large distances compressed.
fn color_difference(a: [f32; 3], b: [f32; 3]) -> f32 {
    let difference = hyab(a, b).powf(COLOR_EXPONENT);
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(adapted_lab);
    let largest = hyab(green, blue).powf(COLOR_EXPONENT);
    let knee = COLOR_KNEE * largest;
    match difference < knee {
        true => difference * COLOR_KNEE_VALUE / knee,
        false => COLOR_KNEE_VALUE + (difference - knee) / (largest - knee) * (1.0 - COLOR_KNEE_VALUE),
    }
}

fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

fn product(matrix: &[[f32; 3]; 3], vector: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

/// XYZ over the white, of a linear color.
fn relative_xyz(color: [f32; 3]) -> [f32; 3] {
    let xyz = product(&XYZ_FROM_RGB, color);
    std::array::from_fn(|i| xyz[i] / WHITE[i])
}

/// Luminance, red against green, and blue against yellow, of a linear color (YCxCz).
fn opponent(color: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(color);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear color of opponent values.
fn rgb_of_opponent([luminance, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (luminance + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    product(&RGB_FROM_XYZ, std::array::from_fn(|i| relative[i] * WHITE[i]))
}

/// L*a*b* of a linear color, with chroma in proportion to the luminance.
fn adapted_lab(color: [f32; 3]) -> [f32; 3] {
    let delta = 6.0f32 / 29.0;
    let curve = |t: f32| if t > delta.powi(3) { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 };
    let [x, y, z] = relative_xyz(color).map(curve);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::image::tone;

    const WIDTH: u32 = 48;
    const HEIGHT: u32 = 32;

    fn picture(value: impl Fn(u32, u32, u32) -> f32) -> Image {
        let pixel = |at: u32| std::array::from_fn(|c| value(at % WIDTH, at / WIDTH, c as u32));
        Image { width: WIDTH, height: HEIGHT, pixels: (0..WIDTH * HEIGHT).map(pixel).collect() }
    }

    /// Picture `reference` of `tests/data/flip/make.py`.
    fn reference_value(x: u32, y: u32, c: u32) -> f32 {
        let steps = ((x / 8 + 2 * (y / 8) + c) % 5) as f32 / 8.0 + 1.0 / 64.0;
        let dot = if x % 7 == 3 && y % 6 == 2 { 0.5 } else { 0.0 };
        let square = if (31..36).contains(&x) && (21..26).contains(&y) { 32.0 } else { 0.0 };
        steps + dot + square
    }

    /// Picture `image` of `tests/data/flip/make.py`.
    fn image_value(x: u32, y: u32, c: u32) -> f32 {
        let noise = 1.0 + (((x * 7 + y * 13 + c * 5) % 32) as f32 / 16.0 - 1.0) / 4.0;
        let dot = if x % 14 == 3 && y % 6 == 2 { -0.25 } else { 0.0 };
        reference_value(x, y, c) * noise + dot
    }

    /// Linear value of a display value: the inverse of [`tone::srgb`].
    fn linear(display: f32) -> f32 {
        if display <= 0.040_45 { display / 12.92 } else { ((display + 0.055) / 1.055).powf(2.4) }
    }

    fn mean(map: &[f32]) -> f64 {
        map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len() as f64
    }

    /// The values of the authors' program; see `tests/data/flip/make.py`.
    #[test]
    fn agrees_with_the_authors_program() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/flip/values.json");
        let expected: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let half = |value: fn(u32, u32, u32) -> f32| {
            // Through the sRGB curve and back, as the authors' program reads it.
            picture(|x, y, c| linear(tone::srgb(f64::from((value(x, y, c) / 2.0).min(1.0))) as f32))
        };
        let maps = [
            ("displayed", map_displayed(&half(image_value), &half(reference_value))),
            ("hdr", map(&picture(image_value), &picture(reference_value))),
        ];
        for (kind, map) in maps {
            let close = |value: f64, expected: &serde_json::Value, what: &str| {
                let expected = expected.as_f64().unwrap();
                assert!((value - expected).abs() < 2.0e-5, "{kind}, {what}: {value} is not {expected}");
            };
            close(mean(&map), &expected[kind]["mean"], "mean");
            let some = (0..HEIGHT).step_by(4).flat_map(|y| (0..WIDTH).step_by(5).map(move |x| y * WIDTH + x));
            let values = expected[kind]["map"].as_array().unwrap();
            assert_eq!(values.len(), 80);
            for (at, expected) in some.zip(values) {
                close(f64::from(map[at as usize]), expected, &format!("pixel {at}"));
            }
        }
        let exposures = exposures(&picture(reference_value));
        let [start, stop, count] = [0, 1, 2].map(|at| expected["hdr"]["exposures"][at].as_f64().unwrap());
        assert_eq!(exposures.len() as f64, count);
        assert!((f64::from(exposures[0]) - start).abs() < 1e-4);
        assert!((f64::from(exposures[exposures.len() - 1]) - stop).abs() < 1e-4);
    }

    /// Values that break the logarithm of an exposure or a power: black pictures, one pixel, and values out of range.
    #[test]
    fn every_picture_has_a_number() {
        let one = |value: f32| Image { width: 1, height: 1, pixels: vec![[value; 3]] };
        let mut mostly_black = picture(|_, _, _| 0.0);
        mostly_black.pixels[5] = [3.0; 3];
        let bright = picture(|x, _, _| if x > 20 { 1.0e30 } else { -1.0 });
        for (a, b) in [
            (one(0.0), one(0.0)),
            (one(2.0), one(0.5)),
            (one(1.0), one(0.0)),
            (picture(image_value), mostly_black.clone()),
            (mostly_black, picture(image_value)),
            (picture(image_value), bright),
        ] {
            let map = map(&a, &b);
            assert!(map.iter().all(|value| (0.0..=1.0).contains(value)), "{map:?}");
            assert_eq!(a == b, mean(&map) == 0.0);
        }
        assert!(
            map(&Image { width: 0, height: 0, pixels: vec![] }, &Image { width: 0, height: 0, pixels: vec![] })
                .is_empty()
        );
    }
}
