//! Figure 1: an inset of every method's picture after equal time, beside the reference. The inset is the same for all.

use super::methods::Method;
use super::paper::PaperScene;
use super::record::Record;
use super::results::Results;
use super::sheet::Sheet;
use super::table1;
use crate::image::{Image, tone};

/// Shorter side of the picture, as a multiple of the inset's side.
const CUT: u32 = 3;
/// Enlargement of the inset in the strip, along each side.
const ZOOM: u32 = 4;
/// Width of the white gap between insets, in pixels of the strip.
const GAP: u32 = 4;

/// Methods that the figure compares: those of Table 1.
pub fn methods() -> Vec<Method> {
    table1::methods()
}

/// Square in which a picture's displayed values differ most from the reference: its top left corner and its side.
pub fn worst_window(picture: &Image, reference: &Image) -> ([u32; 2], u32) {
    let side = (picture.width.min(picture.height) / CUT).max(1);
    let step = (side / 4).max(1) as usize;
    let error = |left: u32, top: u32| -> f64 {
        let places = (top..top + side).flat_map(|y| (left..left + side).map(move |x| (y * picture.width + x) as usize));
        places.map(|at| displayed_difference(picture.pixels[at], reference.pixels[at])).sum()
    };
    let lefts = || (0..=picture.width - side).step_by(step);
    let windows = (0..=picture.height - side).step_by(step).flat_map(|top| lefts().map(move |left| (left, top)));
    let worst = windows.max_by(|a, b| error(a.0, a.1).total_cmp(&error(b.0, b.1)));
    let (left, top) = worst.unwrap_or((0, 0));
    ([left, top], side)
}

fn displayed_difference(a: [f32; 3], b: [f32; 3]) -> f64 {
    let [a, b] = [a, b].map(|pixel| tone::paper(pixel.map(f64::from)));
    (0..3).map(|c| (a[c] - b[c]).abs()).sum()
}

/// Strip of one window of all pictures from left to right, enlarged.
pub fn strip(pictures: &[Image], corner: [u32; 2], side: u32) -> Image {
    let (tile, count) = (ZOOM * side, pictures.len() as u32);
    let (width, height) = ((tile + GAP) * count - GAP, tile);
    let pixel = |i: u32| {
        let ([x, y], picture) = ([i % width, i / width], &pictures[(i % width / (tile + GAP)) as usize]);
        let x = x % (tile + GAP);
        match x < tile {
            true => picture.pixels[((corner[1] + y / ZOOM) * picture.width + corner[0] + x / ZOOM) as usize],
            false => [f32::MAX; 3],
        }
    };
    Image { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// Table of the pictures' errors, in the order of the strips.
pub fn sheet(results: &Results) -> Sheet {
    let methods = methods();
    let names = methods.iter().map(Method::name);
    let mut sheet = Sheet::new(["scene".to_owned()].into_iter().chain(names));
    for PaperScene { name, .. } in results.scenes(&methods) {
        let records = methods.iter().filter_map(|method| results.of(name, method));
        let cell = |record: &Record| format!("{:.4}", record.errors.mae_ldr);
        sheet.push([name.to_owned()].into_iter().chain(records.map(cell)));
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(width: u32, height: u32, value: impl Fn(u32) -> f32) -> Image {
        Image { width, height, pixels: (0..width * height).map(|i| [value(i); 3]).collect() }
    }

    #[test]
    fn the_window_is_where_the_error_is() {
        let reference = gray(24, 12, |_| 0.5);
        let picture = gray(24, 12, |i| if i % 24 >= 18 && i / 24 >= 7 { 0.1 } else { 0.5 });
        let ([left, top], side) = worst_window(&picture, &reference);
        assert_eq!(side, 4);
        assert!(left >= 18 && top >= 7 && left + side <= 24 && top + side <= 12, "{left}, {top}");
    }

    #[test]
    fn insets_stand_side_by_side() {
        let pictures = [gray(8, 8, |i| i as f32), gray(8, 8, |i| -(i as f32))];
        let strip = strip(&pictures, [2, 1], 2);
        assert_eq!((strip.width, strip.height), (8 + GAP + 8, 8));
        let at = |x: u32, y: u32| strip.pixels[(y * strip.width + x) as usize][0];
        assert_eq!([at(0, 0), at(7, 7), at(8, 0), at(12, 0), at(19, 7)], [10.0, 19.0, f32::MAX, -10.0, -19.0]);
    }
}
