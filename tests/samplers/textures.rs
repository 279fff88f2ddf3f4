//! Textures of `glsl/include/texture/textures.glsl` and `texture_lookup.glsl`, against their twin.

use std::f64::consts::PI;

use glam::{DVec2, DVec4, Mat3, Vec2, Vec3};
use lodestar::encode::textures::PackedTextures;
use lodestar::math::srgb::linear_from_srgb;
use lodestar::scene::texture::{Image, Pattern, TexelFilter, Texels, Texture, WrapMode};
use lodestar::scene::texture_lookup::sample;
use support::device::Device;
use support::statistics::Numbers;
use support::twins::texture as twin;

use crate::looked_up::{TextureInput, TextureOutput, look_up, look_up_after};

/// Maximum error of the polynomial for the sRGB curve.
const CURVE_TOLERANCE: f64 = 1.0e-5;

fn bytes(width: u32, height: u32, srgb: bool, seed: u32) -> Image {
    let mut numbers = Numbers::new(seed);
    let mut byte = || (numbers.unit() * 256.0) as u8;
    let data = (0..width * height).map(|_| [byte(), byte(), byte(), byte()]).collect();
    Image { name: "bytes".into(), width, height, texels: Texels::Bytes { srgb, data } }
}

/// Image of values that half precision can hold.
fn floats(width: u32, height: u32, largest: f64, seed: u32) -> Image {
    let mut numbers = Numbers::new(seed);
    let mut value = || ((numbers.unit() * 1024.0).floor() / 1024.0 * largest) as f32;
    let data = (0..width * height).map(|_| [value(), value(), value(), 1.0]).collect();
    Image { name: "floats".into(), width, height, texels: Texels::Floats(data) }
}

fn bitmap(image: u32, filter: TexelFilter, wrap: WrapMode, to_uv: Mat3) -> Texture {
    Texture { name: "bitmap".into(), pattern: Pattern::Bitmap { image, filter, wrap }, to_uv }
}

fn modes() -> Vec<(TexelFilter, WrapMode)> {
    let filters = [TexelFilter::Bilinear, TexelFilter::Nearest];
    let wraps = [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp];
    filters.into_iter().flat_map(|filter| wraps.map(|wrap| (filter, wrap))).collect()
}

/// Coordinates over a few copies of the image. Some lie exactly on edges.
fn points(seed: u32, count: usize) -> Vec<Vec2> {
    let mut numbers = Numbers::new(seed);
    let exact = [-1.0f32, -0.5, 0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0];
    let edges = exact.iter().flat_map(|&u| exact.map(|v| Vec2::new(u, v)));
    let any = (0..count).map(|_| Vec2::new((8.0 * numbers.unit() - 3.5) as f32, (8.0 * numbers.unit() - 3.5) as f32));
    edges.chain(any).collect()
}

/// Whether a color agrees with the twin's, up to `tolerance` and the effect of rounded coordinates.
fn agrees(texture: &Texture, images: &[Image], uv: Vec2, color: DVec4, tolerance: f64) -> bool {
    let shift = 4.0e-7 * f64::from(1.0 + uv.abs().max_element());
    let expected = sample(texture, images, uv.as_dvec2());
    let shifts = [-1.0, 0.0, 1.0].into_iter().flat_map(|u| [-1.0, 0.0, 1.0].map(|v| DVec2::new(u, v)));
    let changes = shifts
        .map(|direction| (sample(texture, images, uv.as_dvec2() + shift * direction) - expected).abs().max_element());
    let allowed = tolerance * expected.abs().max_element().max(1.0) + changes.fold(0.0, f64::max);
    (expected - color).abs().max_element() <= allowed
}

/// Compares every texture with its twin at every point. `tamper` is added to u of the twin's points.
fn compare(textures: &[Texture], images: &[Image], points: &[Vec2], tamper: f32) -> Result<(), String> {
    let inputs: Vec<_> = (0..textures.len() as u32)
        .flat_map(|index| points.iter().map(move |uv| TextureInput::new(index, (*uv).into())))
        .collect();
    for (input, output) in inputs.iter().zip(look_up(textures, images, &inputs)) {
        let texture = &textures[input.index as usize];
        let uv = Vec2::from(input.uv) + Vec2::new(tamper, 0.0);
        let color = DVec4::from_array(output.color.map(f64::from));
        if !agrees(texture, images, uv, color, CURVE_TOLERANCE + 2.0e-5) {
            let expected = sample(texture, images, uv.as_dvec2());
            return Err(format!("{:?} at {uv} is {color}, not {expected}", texture.pattern));
        }
    }
    Ok(())
}

fn all_modes(image: u32, to_uv: Mat3) -> Vec<Texture> {
    modes().into_iter().map(|(filter, wrap)| bitmap(image, filter, wrap, to_uv)).collect()
}

fn mapping() -> Mat3 {
    Mat3::from_cols(Vec3::new(1.3, 0.4, 0.0), Vec3::new(-0.7, 2.1, 0.0), Vec3::new(0.3, -0.2, 1.0))
}

#[test]
fn every_kind_of_texel_in_every_mode() {
    let images = [bytes(7, 5, true, 1), bytes(4, 9, false, 2), floats(6, 3, 1.0, 3), floats(5, 5, 262_144.0, 4)];
    let all: Vec<_> = (0..4).flat_map(|image| all_modes(image, Mat3::IDENTITY)).collect();
    compare(&all, &images, &points(5, 300), 0.0).unwrap();
    compare(&all, &images, &points(5, 300), 1.0e-3).expect_err("texels half a percent off must be seen");
}

#[test]
fn kinds_by_themselves() {
    let points = points(6, 200);
    for image in [bytes(7, 5, true, 1), bytes(3, 8, false, 2), floats(6, 3, 8.0, 3)] {
        for (filter, wrap) in modes() {
            for to_uv in [Mat3::IDENTITY, mapping()] {
                compare(&[bitmap(0, filter, wrap, to_uv)], std::slice::from_ref(&image), &points, 0.0).unwrap();
            }
        }
    }
}

/// Encoded bytes are mixed by their alpha before they are decoded, beside textures that are decoded first. Texels that are not
/// encoded are mixed as they are.
#[test]
fn encoded_bytes_are_mixed_first() {
    let clear = Texels::Bytes { srgb: true, data: vec![[255, 90, 0, 0], [9, 200, 255, 0], [255, 0, 90, 255]] };
    let clear = Image { name: "clear".into(), width: 3, height: 1, texels: clear };
    let images = [bytes(7, 5, true, 1), bytes(4, 9, false, 2), floats(6, 3, 8.0, 3), clear];
    let wraps = [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp];
    let textures = |filter| {
        let of_image = |image| wraps.map(|wrap| bitmap(image, filter, wrap, mapping()));
        (0..4).flat_map(of_image).collect::<Vec<_>>()
    };
    let points = points(15, 300);
    let encoded = textures(TexelFilter::Encoded);
    compare(&encoded, &images, &points, 0.0).unwrap();
    compare(&[&encoded[..], &all_modes(0, Mat3::IDENTITY)].concat(), &images, &points, 0.0).unwrap();
    compare(&encoded[..1], &images, &points, 0.0).unwrap();
    let decoded_first = textures(TexelFilter::Bilinear);
    let differ = |at: usize| {
        let color = |texture: &Texture, uv: &Vec2| sample(texture, &images, uv.as_dvec2());
        points.iter().any(|uv| (color(&encoded[at], uv) - color(&decoded_first[at], uv)).abs().max_element() > 0.2)
    };
    assert_eq!([0, 3, 6, 9].map(differ), [true, false, false, true]);
}

#[test]
fn small_images() {
    for (width, height) in [(1, 1), (2, 1), (1, 3)] {
        compare(&all_modes(0, Mat3::IDENTITY), &[bytes(width, height, true, 7)], &points(8, 300), 0.0).unwrap();
    }
}

#[test]
fn checkerboards() {
    let board = |to_uv| Texture {
        name: "board".into(),
        pattern: Pattern::Checkerboard { color0: Vec3::new(0.1, 0.2, 0.3), color1: Vec3::new(0.9, 0.5, 0.7) },
        to_uv,
    };
    let image = [bytes(7, 5, true, 1)];
    let textures = [board(Mat3::IDENTITY), board(mapping()), all_modes(0, Mat3::IDENTITY)[0].clone()];
    compare(&textures, &image, &points(9, 500), 0.0).unwrap();
    compare(&textures[..2], &[], &points(9, 500), 0.0).unwrap();
    compare(&textures, &image, &points(9, 500), 0.01).expect_err("another square must be seen");
}

/// Any coordinate gives a texel of the image. Far from the origin, a coordinate has few digits left.
#[test]
fn any_coordinate_gives_a_texel() {
    let images = [bytes(7, 5, true, 1)];
    let far = [1.0e6, -1.0e6, 3.0e38, -3.0e38, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1.0e-40, -1.0e-40, 0.1];
    let textures = all_modes(0, Mat3::IDENTITY);
    let points: Vec<_> = far.iter().flat_map(|&u| far.map(|v| [u, v])).collect();
    let inputs: Vec<_> = (0..textures.len() as u32)
        .flat_map(|index| points.iter().map(move |&uv| TextureInput::new(index, uv)))
        .collect();
    for (input, output) in inputs.iter().zip(look_up(&textures, &images, &inputs)) {
        let finite = input.uv.iter().all(|coordinate| coordinate.is_finite());
        let inside = output.color.iter().all(|channel| (-1.0e-5..=1.0 + 1.0e-5).contains(channel));
        assert!(inside || !finite, "{input:?}: {output:?}");
    }
}

#[test]
fn the_curve_at_every_byte() {
    let data = (0..=255u8).map(|byte| [byte, 255 - byte, byte, byte]).collect();
    let ramp = Image { name: "ramp".into(), width: 256, height: 1, texels: Texels::Bytes { srgb: true, data } };
    let texture = bitmap(0, TexelFilter::Nearest, WrapMode::Clamp, Mat3::IDENTITY);
    let inputs: Vec<_> = (0..256).map(|i| TextureInput::new(0, [(i as f32 + 0.5) / 256.0, 0.5])).collect();
    for (byte, output) in look_up(&[texture], &[ramp], &inputs).into_iter().enumerate() {
        let expected = linear_from_srgb(byte as f64 / 255.0);
        assert!((f64::from(output.color[0]) - expected).abs() < CURVE_TOLERANCE, "{byte}: {}", output.color[0]);
        let reversed = linear_from_srgb((255 - byte) as f64 / 255.0);
        assert!((f64::from(output.color[1]) - reversed).abs() < CURVE_TOLERANCE, "{byte}: {}", output.color[1]);
        assert!((f64::from(output.color[3]) - byte as f64 / 255.0).abs() < 1.0e-6);
    }
}

/// Between the bytes the curve is as exact as at them.
#[test]
fn the_curve_between_bytes() {
    let texels = Texels::Bytes { srgb: true, data: vec![[0, 0, 0, 255], [255; 4]] };
    let ramp = Image { name: "ramp".into(), width: 2, height: 1, texels };
    let texture = bitmap(0, TexelFilter::Encoded, WrapMode::Clamp, Mat3::IDENTITY);
    let shares: Vec<f64> = (0..=10_000).map(|i| f64::from(i) / 10_000.0).collect();
    let inputs: Vec<_> = shares.iter().map(|x| TextureInput::new(0, [(0.25 + 0.5 * x) as f32, 0.5])).collect();
    for (share, output) in shares.iter().zip(look_up(&[texture], &[ramp], &inputs)) {
        let difference = f64::from(output.color[0]) - linear_from_srgb(*share);
        assert!(difference.abs() < CURVE_TOLERANCE, "{share}: {difference}");
    }
}

fn gradients_agree(tamper: f64) -> bool {
    let images = [bytes(7, 5, true, 1), floats(6, 9, 4.0, 3)];
    let mut textures: Vec<_> = (0..2).flat_map(|image| all_modes(image, Mat3::IDENTITY)).collect();
    textures.extend((0..2).flat_map(|image| all_modes(image, mapping())));
    // Points lie off the lines between texels, where slopes jump.
    let mut numbers = Numbers::new(10);
    let points: Vec<_> = (0..300).map(|_| [(), ()].map(|()| (6.0 * numbers.unit() - 2.5) as f32)).collect();
    let inputs: Vec<_> = (0..textures.len() as u32)
        .flat_map(|index| points.iter().map(move |&uv| TextureInput::new(index, uv)))
        .collect();
    let outputs = look_up(&textures, &images, &inputs);
    let wrong = inputs.iter().zip(&outputs).filter(|(input, output)| {
        let texture = &textures[input.index as usize];
        let uv = DVec2::from_array(input.uv.map(f64::from));
        let gradient = DVec2::from_array(output.gradient.map(f64::from));
        let near = |shift: DVec2| {
            let expected = (1.0 + tamper) * twin::gradient(texture, &images, uv + 1.0e-6 * shift);
            (expected - gradient).length() < 1.0e-3 * expected.length().max(1.0)
        };
        ![DVec2::ZERO, DVec2::ONE, DVec2::NEG_ONE, DVec2::X, DVec2::Y].into_iter().any(near)
    });
    wrong.count() == 0
}

#[test]
fn gradients() {
    assert!(gradients_agree(0.0));
    assert!(!gradients_agree(0.01), "a percent must be seen");
}

/// Largest difference between a slope and its twin's, where the heights `offset + 0.02 sin(8 pi u)` stand in `width` texels.
fn slope_difference(width: u32, offset: f32, texels: impl Fn(Vec<f32>) -> Texels) -> f64 {
    let height = |i: u32| f64::from(offset) + 0.02 * (8.0 * PI * (f64::from(i) + 0.5) / f64::from(width)).sin();
    let heights: Vec<f32> = (0..width).map(|i| height(i) as f32).collect();
    let exact = Image { name: "heights".into(), width, height: 1, texels: Texels::Heights(heights.clone()) };
    let image = Image { texels: texels(heights), ..exact.clone() };
    let texture = bitmap(0, TexelFilter::Bilinear, WrapMode::Repeat, Mat3::IDENTITY);
    let inputs: Vec<_> =
        (0..width).map(|i| TextureInput::new(0, [((f64::from(i) + 0.75) / f64::from(width)) as f32, 0.5])).collect();
    let outputs = look_up(std::slice::from_ref(&texture), &[image], &inputs);
    let difference = |(input, output): (&TextureInput, &TextureOutput)| {
        let uv = DVec2::from_array(input.uv.map(f64::from));
        let slope = twin::gradient(&texture, std::slice::from_ref(&exact), uv);
        (DVec2::from_array(output.gradient.map(f64::from)) - slope).length()
    };
    inputs.iter().zip(&outputs).map(difference).fold(0.0, f64::max)
}

/// Slopes of heights are exact but for a rounding of the difference. As halves, the heights lose them.
#[test]
fn slopes_between_many_texels() {
    for width in [256, 1024, 2048, 4096] {
        for offset in [0.0, 0.75, 3.0, 100.0] {
            let found = slope_difference(width, offset, Texels::Heights);
            assert!(found < 1.0e-5, "{width} texels, offset {offset}: {found}");
        }
    }
    let as_floats = |heights: Vec<f32>| Texels::Floats(heights.into_iter().map(|h| [h, h, h, 1.0]).collect());
    assert!(slope_difference(2048, 0.75, as_floats) > 0.2, "halves must be seen");
}

/// Several pages: an image that fills a page leaves other images to the next pages.
#[test]
fn pages() {
    let side = 4096;
    let images = [bytes(side, 2 * side - 1, true, 11), bytes(7, 5, true, 1), bytes(side, 2 * side - 1, true, 12)];
    let textures: Vec<_> =
        (0..3).map(|image| bitmap(image, TexelFilter::Bilinear, WrapMode::Repeat, Mat3::IDENTITY)).collect();
    let packed = PackedTextures::new(&textures, &images, &[], vec![0; 100]).0;
    assert_eq!(packed.words.pages().len(), 3, "{:?}", packed.records);
    if Device::new().has_room("pages", packed.words.longest_page() * 4, 4) {
        compare(&textures, &images, &points(13, 2000), 0.0).unwrap();
    }
}

/// Tables lie before the images, so images move.
#[test]
fn tables_move_images() {
    let images = [bytes(7, 5, true, 1)];
    let textures = all_modes(0, Mat3::IDENTITY);
    let inputs: Vec<_> = points(14, 100).into_iter().map(|uv| TextureInput::new(0, uv.into())).collect();
    let plain = look_up(&textures, &images, &inputs);
    let moved = look_up_after(&textures, &images, &inputs, (0..77).collect());
    assert!(plain.iter().zip(&moved).all(|(a, b)| a.color == b.color));
}
