//! Textures.

use glam::{DVec2, DVec4, Vec2};
use image::{ImageFormat, Rgba, RgbaImage};
use lodestar::scene::texture_lookup::sample;
use lodestar::scene::{Bsdf, Scene};

use super::{bsdf, load_in, surface, world};
use crate::Folder;

/// Square that fills the unit square of texture coordinates.
const SQUARE: &str = "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0  1 1 0 ]";

/// File of an image of two by two texels: red and green above, blue and white below.
fn png(texels: [[u8; 4]; 4]) -> Vec<u8> {
    let image = RgbaImage::from_fn(2, 2, |x, y| Rgba(texels[(2 * y + x) as usize]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

pub(super) const COLORS: [[u8; 4]; 4] = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];

pub(super) fn folder(texture: &str, texels: [[u8; 4]; 4]) -> Folder {
    let folder = Folder::new(&[("scene.pbrt", &format!("Camera \"perspective\" WorldBegin\n{texture}\n{SQUARE}"))]);
    folder.write("a.png", &png(texels));
    folder
}

fn textured(texture: &str, texels: [[u8; 4]; 4]) -> Scene {
    load_in(&folder(texture, texels)).unwrap_or_else(|error| panic!("{texture}: {error}"))
}

/// Color of a diffuse surface at coordinates of pbrt's.
fn color(scene: &Scene, at: [f64; 2]) -> [f64; 3] {
    let Bsdf::Diffuse { reflectance } = bsdf(scene) else { panic!("diffuse") };
    let texture = &scene.textures[reflectance.texture.unwrap() as usize];
    (sample(texture, &scene.images, DVec2::from(at)) * reflectance.value.as_dvec3().extend(1.0)).truncate().to_array()
}

fn close(found: [f64; 3], expected: [f64; 3]) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-3), "{found:?} is not {expected:?}");
}

pub(super) const DIFFUSE: &str = "Material \"diffuse\" \"texture reflectance\" \"t\"";

fn image_map(parameters: &str) -> String {
    format!(
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"string filter\" \"point\" {parameters}\n{DIFFUSE}"
    )
}

/// pbrt's v runs from the bottom of the image, also where it is scaled and moved.
#[test]
fn images_stand_upright() {
    let scene = textured(&image_map(""), COLORS);
    assert_eq!(scene.primitives[0].uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE]);
    for (at, expected) in [([0.2, 0.8], [1.0, 0.0, 0.0]), ([0.8, 0.8], [0.0, 1.0, 0.0]), ([0.2, 0.2], [0.0, 0.0, 1.0])]
    {
        close(color(&scene, at), expected);
    }
    let moved = textured(&image_map("\"float uscale\" 0.5 \"float udelta\" 0.5 \"float vdelta\" 0.25"), COLORS);
    // (0.2, 0.6) becomes (0.6, 0.85).
    close(color(&moved, [0.2, 0.6]), [0.0, 1.0, 0.0]);
}

#[test]
fn encodings_factors_and_inversion() {
    let gray = [[128, 128, 128, 255]; 4];
    let linear: f64 = 128.0 / 255.0;
    let srgb = ((linear + 0.055) / 1.055).powf(2.4);
    for (parameters, expected) in [
        ("", srgb),
        ("\"string encoding\" \"linear\"", linear),
        ("\"string encoding\" \"gamma 3\"", linear.powi(3)),
        ("\"float scale\" 0.5", 0.5 * srgb),
        ("\"bool invert\" true", 1.0 - srgb),
        ("\"bool invert\" true \"float scale\" 2", 1.0 - 2.0 * srgb),
    ] {
        close(color(&textured(&image_map(parameters), gray), [0.3, 0.3]), [expected; 3]);
    }
    let repeated = textured(&image_map(""), COLORS);
    close(color(&repeated, [1.2, 1.8]), [1.0, 0.0, 0.0]);
    let clamped = textured(&image_map("\"string wrap\" \"clamp\""), COLORS);
    close(color(&clamped, [-3.0, 1.8]), [1.0, 0.0, 0.0]);
}

#[test]
fn scaled_and_mixed_textures() {
    let image = "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"string filter\" \"point\"";
    let number = "Texture \"n\" \"float\" \"imagemap\" \"string filename\" \"a.png\" \"string filter\" \"point\"";
    let scene = |texture: &str| textured(&format!("{image}\n{number}\n{texture}\n{DIFFUSE}"), COLORS);
    let scaled = scene("Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"i\" \"float scale\" 0.25");
    close(color(&scaled, [0.8, 0.2]), [0.25; 3]);
    // The number of red is the mean of its channels.
    let product = scene("Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"i\" \"texture scale\" \"n\"");
    close(color(&product, [0.2, 0.8]), [1.0 / 3.0, 0.0, 0.0]);
    let mixed = scene(
        "Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"i\" \"rgb tex2\" [ 0 0.5 1 ] \"float amount\" 0.25",
    );
    close(color(&mixed, [0.2, 0.8]), [0.75, 0.125, 0.25]);
    let by_image = scene(
        "Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [ 1 1 1 ] \"rgb tex2\" [ 0 0 0 ] \"texture amount\" \"n\"",
    );
    close(color(&by_image, [0.2, 0.8]), [2.0 / 3.0; 3]);
    let constant = scene(
        "Texture \"c\" \"spectrum\" \"constant\" \"rgb value\" [ 0.2 0.4 0.6 ] Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"float scale\" 0.5",
    );
    let Bsdf::Diffuse { reflectance } = bsdf(&constant) else { panic!("diffuse") };
    assert!(reflectance.texture.is_none() && (reflectance.value.z - 0.3).abs() < 1e-6);
}

/// The first color lies where the whole parts of both coordinates have an even sum, also where the texture is a number.
#[test]
fn checkerboards() {
    let scale = "\"float uscale\" 4 \"float vscale\" 2";
    let board = format!(
        "Texture \"t\" \"spectrum\" \"checkerboard\" {scale} \"rgb tex1\" [ 1 0 0 ] \"rgb tex2\" [ 0 0 1 ]\n{DIFFUSE}"
    );
    let scene = textured(&board, COLORS);
    for (at, is_first) in
        [([0.1, 0.1], true), ([0.3, 0.1], false), ([0.3, 0.7], true), ([0.6, 0.7], false), ([-0.1, 0.1], false)]
    {
        close(color(&scene, at), if is_first { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] });
    }
    let number = format!(
        "Texture \"a\" \"float\" \"checkerboard\" {scale} \"float tex1\" 0.75 \"float tex2\" 0.25\nAttribute \"shape\" \"texture alpha\" \"a\""
    );
    let scene = textured(&number, COLORS);
    let opacity = surface(&scene).opacity;
    let at =
        |at: [f64; 2]| sample(&scene.textures[opacity.texture.unwrap() as usize], &scene.images, DVec2::from(at)).x;
    // The reader of descriptions exchanges the colors of numbers, so that they are looked up as they stand.
    assert!((at([0.1, 0.1]) - 0.75).abs() < 1e-6 && (at([0.3, 0.1]) - 0.25).abs() < 1e-6);
}

/// A PNG image's alpha channel is its number, decoded as its colors are.
#[test]
fn alpha_of_images() {
    let texels = [[255, 0, 0, 255], [255, 0, 0, 0], [255, 0, 0, 128], [0; 4]];
    let number = "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.png\" \"string filter\" \"point\"";
    let scene = textured(&format!("{number}\nAttribute \"shape\" \"texture alpha\" \"a\""), texels);
    let opacity = surface(&scene).opacity;
    let at = |at: [f64; 2]| -> DVec4 {
        sample(&scene.textures[opacity.texture.unwrap() as usize], &scene.images, DVec2::from(at))
    };
    let half = ((128.0 / 255.0 + 0.055) / 1.055f64).powf(2.4);
    for (place, expected) in [([0.2, 0.8], 1.0), ([0.8, 0.8], 0.0), ([0.2, 0.2], half), ([0.8, 0.2], 0.0)] {
        close(at(place).truncate().to_array(), [expected; 3]);
    }
}

#[test]
fn roughness_normals_and_displacement() {
    let gray = [[128, 128, 128, 255]; 4];
    let number = "Texture \"r\" \"float\" \"imagemap\" \"string filename\" \"a.png\" \"string encoding\" \"linear\"";
    let scene = textured(&format!("{number}\nMaterial \"conductor\" \"texture roughness\" \"r\""), gray);
    let Bsdf::RoughConductor { microfacets, .. } = bsdf(&scene) else { panic!("rough") };
    let texture = &scene.textures[microfacets.alpha_u.texture.unwrap() as usize];
    let alpha = sample(texture, &scene.images, DVec2::splat(0.5)).x;
    assert!((alpha - (128.0f64 / 255.0).sqrt()).abs() < 1e-4, "{alpha}");
    let scene = textured("Material \"diffuse\" \"string normalmap\" \"a.png\"", gray);
    assert!(surface(&scene).relief.is_some() && surface(&scene).two_sided);
    let scene = textured(&format!("{number}\nMaterial \"diffuse\" \"texture displacement\" \"r\""), gray);
    assert!(matches!(surface(&scene).relief, Some(lodestar::scene::bsdf::Relief::Bump { .. })));
    let coated = textured(&format!("{number}\nMaterial \"coateddiffuse\" \"texture roughness\" \"r\""), gray);
    assert!(
        matches!(bsdf(&coated), Bsdf::RoughPlastic { alpha, .. } if (alpha - (128.0f32 / 255.0).sqrt()).abs() < 1e-3)
    );
    assert!(coated.warnings.join("\n").contains("the texture's mean is used"));
}

/// A long chain of textures gives one sentence, not an overflow of the stack.
#[test]
fn chains_of_textures_are_bounded() {
    let chain = |length: usize| {
        let link = |from: usize| {
            let name = if from == 1 { "t".to_owned() } else { (from - 1).to_string() };
            format!("Texture \"{name}\" \"spectrum\" \"scale\" \"texture tex\" \"{from}\"\n")
        };
        let links: String = (1..=length).rev().map(link).collect();
        world(&format!("Texture \"{length}\" \"spectrum\" \"constant\"\n{links}{DIFFUSE} Shape \"sphere\""))
    };
    assert!(chain(60).is_ok());
    let error = chain(10_000).unwrap_err();
    assert!(error.contains("scene.pbrt:") && error.contains("nested more than 64 deep"), "{error}");
}

#[test]
fn what_is_refused() {
    let of = |kind: &str| format!("Texture \"t\" \"spectrum\" \"{kind}\" {DIFFUSE} Shape \"sphere\"");
    for (texture, expected) in [
        (of("ptex"), "the texture `ptex` is not supported"),
        (of("fbm"), "the texture `fbm` gives a `float`, not a `spectrum`"),
        (of("wrong"), "the texture `wrong` is not supported"),
        (image_map("\"string mapping\" \"conical\""), "the mapping `conical` is not known"),
        (image_map("\"string wrap\" \"octahedralsphere\""), "the wrap mode `octahedralsphere` is not supported"),
        (image_map("\"string encoding\" \"wrong\""), "the encoding `wrong` is not known"),
        (format!("Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"t\" {DIFFUSE}"), "no texture of that name"),
        (format!("Texture \"t\" \"float\" \"constant\" {DIFFUSE}"), "gives a `spectrum` stands before"),
        (
            "Texture \"t\" \"float\" \"scale\" \"texture scale\" \"t\" Attribute \"shape\" \"texture alpha\" \"t\""
                .to_owned(),
            "scene.pbrt:2: textures are nested more than 64 deep: does one contain itself?",
        ),
    ] {
        let error = load_in(&folder(&texture, COLORS)).expect_err(expected);
        assert!(error.contains(expected) && error.contains("scene.pbrt:"), "{error} lacks {expected}");
    }
    assert!(world(&of("constant")).is_ok());
    let warned = textured(&image_map("").replace("\"point\"", "\"trilinear\""), COLORS).warnings.join("\n");
    assert!(warned.contains("scene.pbrt:2: the filter `trilinear` is not supported; `bilinear` is used"), "{warned}");
}
