//! Pictures side by side: ours, the reference, and the signed difference.

use std::path::Path;

use lodestar::Result;
use lodestar::image::{Image, ToneCurve, png};

/// Relative difference that has full color.
const FULL_COLOR: f32 = 0.25;
/// Number of pixels between pictures.
const GAP: u32 = 4;

/// Strip of our picture, the reference and the difference: red where ours is brighter, blue where it is darker.
pub fn strip(picture: &Image, reference: &Image) -> Image {
    beside(&[picture, reference, &difference(picture, reference)])
}

fn difference(picture: &Image, reference: &Image) -> Image {
    let mean = reference.pixels.iter().flatten().sum::<f32>() / (3 * reference.pixels.len()) as f32;
    let gray = |color: &[f32; 3]| color.iter().sum::<f32>() / 3.0;
    let color = |(a, b): (&[f32; 3], &[f32; 3])| {
        let relative = (gray(a) - gray(b)) / (gray(b) + 0.05 * mean) / FULL_COLOR;
        let (over, under) = (relative.clamp(0.0, 1.0), (-relative).clamp(0.0, 1.0));
        [1.0 - under, 1.0 - over - under, 1.0 - over]
    };
    let pixels = picture.pixels.iter().zip(&reference.pixels).map(color).collect();
    Image { pixels, ..*picture }
}

fn beside(images: &[&Image]) -> Image {
    let height = images.iter().map(|image| image.height).max().unwrap_or(1);
    let width = images.iter().map(|image| image.width + GAP).sum::<u32>().max(GAP + 1) - GAP;
    let mut canvas = blank(width, height);
    let mut left = 0;
    for image in images {
        paste(&mut canvas, image, left, 0);
        left += image.width + GAP;
    }
    canvas
}

/// Sheet of strips below each other, in columns.
pub fn below(strips: &[Image], columns: usize) -> Image {
    let rows: Vec<Image> = strips.chunks(columns).map(|row| beside(&row.iter().collect::<Vec<_>>())).collect();
    let width = rows.iter().map(|row| row.width).max().unwrap_or(1);
    let height = rows.iter().map(|row| row.height + GAP).sum::<u32>().max(GAP + 1) - GAP;
    let mut canvas = blank(width, height);
    let mut top = 0;
    for row in &rows {
        paste(&mut canvas, row, 0, top);
        top += row.height + GAP;
    }
    canvas
}

fn blank(width: u32, height: u32) -> Image {
    Image { width, height, pixels: vec![[1.0; 3]; width as usize * height as usize] }
}

fn paste(canvas: &mut Image, image: &Image, left: u32, top: u32) {
    for y in 0..image.height {
        let from = (y * image.width) as usize;
        let to = ((top + y) * canvas.width + left) as usize;
        canvas.pixels[to..to + image.width as usize].copy_from_slice(&image.pixels[from..from + image.width as usize]);
    }
}

pub fn write(path: &Path, image: &Image) -> Result<()> {
    png::write(path, image, ToneCurve::Srgb, 0.0)
}
