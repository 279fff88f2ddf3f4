//! Reduction of images that are larger than devices can hold: they are halved until they fit.

use rayon::prelude::*;

use super::texel_pages::{PAGE_WORDS, place, word_count};
use super::texture::{Image, Texels};
use crate::image::tone;
use crate::math::srgb::linear_from_srgb;

/// Largest side of an image in texels. Beyond it, coordinates in single precision would visibly miss a texel's
/// neighbors.
const MAX_SIDE: u32 = 16384;

/// Halves images until each fits a page and all fit the pages. Returns the indices of those that were halved.
pub(super) fn shrink(images: &mut [Image]) -> Vec<usize> {
    let mut smaller = vec![false; images.len()];
    for (image, smaller) in images.iter_mut().zip(&mut smaller) {
        while image.width.max(image.height) > MAX_SIDE || word_count(image) > PAGE_WORDS {
            *image = halved(image);
            *smaller = true;
        }
    }
    loop {
        let counts: Vec<u64> = images.iter().map(word_count).collect();
        let largest = (0..images.len()).max_by_key(|&i| counts[i]);
        match largest {
            Some(largest) if place(&counts).is_none() => {
                images[largest] = halved(&images[largest]);
                smaller[largest] = true;
            }
            _ => break,
        }
    }
    (0..images.len()).filter(|&i| smaller[i]).collect()
}

/// Image of half as many texels along each side, rounded up. Each is the mean light of the texels that it replaces.
fn halved(image: &Image) -> Image {
    let (width, height) = (image.width.div_ceil(2), image.height.div_ceil(2));
    let texels = match &image.texels {
        Texels::Floats(data) => Texels::Floats(mean_texels(image, width, height, |index| data[index])),
        Texels::Heights(data) => {
            let texels = mean_texels(image, width, height, |index| [data[index]; 4]);
            Texels::Heights(texels.into_iter().map(|[height, ..]| height).collect())
        }
        Texels::Bytes { srgb: false, data } => {
            let texels = mean_texels(image, width, height, |index| data[index].map(f32::from));
            Texels::Bytes {
                srgb: false,
                data: texels.into_iter().map(|texel| texel.map(|c| c.round() as u8)).collect(),
            }
        }
        Texels::Bytes { srgb: true, data } => {
            let linear: Vec<f32> = (0..=255u8).map(|byte| linear_from_srgb(f64::from(byte) / 255.0) as f32).collect();
            let texels = mean_texels(image, width, height, |index| {
                let [red, green, blue, alpha] = data[index];
                let [red, green, blue] = [red, green, blue].map(|byte| linear[usize::from(byte)]);
                [red, green, blue, f32::from(alpha) / 255.0]
            });
            Texels::Bytes { srgb: true, data: texels.into_par_iter().map(encode).collect() }
        }
    };
    Image { name: image.name.clone(), width, height, texels }
}

fn encode([red, green, blue, alpha]: [f32; 4]) -> [u8; 4] {
    let byte = |value: f64| (255.0 * value).round() as u8;
    let [red, green, blue] = [red, green, blue].map(|c| byte(tone::srgb(f64::from(c))));
    [red, green, blue, byte(f64::from(alpha))]
}

fn mean_texels(image: &Image, width: u32, height: u32, texel: impl Fn(usize) -> [f32; 4] + Sync) -> Vec<[f32; 4]> {
    let [columns, rows] = [image.width, image.height].map(|side| side as usize);
    let mean = |index: usize| {
        let (x, y) = (index % width as usize * 2, index / width as usize * 2);
        let (right, below) = ((x + 1).min(columns - 1), (y + 1).min(rows - 1));
        let four = [(x, y), (right, y), (x, below), (right, below)].map(|(x, y)| texel(y * columns + x));
        std::array::from_fn(|c| four.iter().map(|texel| 0.25 * texel[c]).sum())
    };
    (0..width as usize * height as usize).into_par_iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(width: u32, height: u32, srgb: bool, data: Vec<[u8; 4]>) -> Image {
        Image { name: "a".into(), width, height, texels: Texels::Bytes { srgb, data } }
    }

    #[test]
    fn light_stays_the_same() {
        let black_and_white = vec![[0, 0, 0, 0], [255; 4], [255; 4], [0, 0, 0, 255]];
        let Texels::Bytes { data, .. } = halved(&bytes(2, 2, true, black_and_white.clone())).texels else { panic!() };
        // 255 srgb(0.5) = 187.5; alpha is linear.
        assert_eq!(data, [[188, 188, 188, 191]]);
        let Texels::Bytes { data, .. } = halved(&bytes(2, 2, false, black_and_white)).texels else { panic!() };
        assert_eq!(data, [[128, 128, 128, 191]]);
    }

    #[test]
    fn odd_sides_are_rounded_up() {
        let texels = Texels::Floats(vec![[1.0; 4], [2.0; 4], [4.0; 4], [1.0; 4], [2.0; 4], [4.0; 4]]);
        let image = halved(&Image { name: "a".into(), width: 3, height: 2, texels });
        assert_eq!((image.width, image.height), (2, 1));
        assert_eq!(image.texels, Texels::Floats(vec![[1.5; 4], [4.0; 4]]));
    }

    #[test]
    fn what_fits_is_left_alone() {
        let mut images = [bytes(3, 1, true, vec![[7; 4]; 3]), bytes(MAX_SIDE + 1, 1, true, vec![[9; 4]; 16385])];
        assert_eq!(shrink(&mut images), [1]);
        assert_eq!((images[0].width, images[1].width), (3, 8193));
        assert_eq!(shrink(&mut []), [0; 0]);
    }
}
