//! Textures that are computed.

use glam::DVec3;
use lodestar::scene::bsdf::Relief;
use lodestar::scene::texture::Pattern;
use lodestar::scene::texture_lookup::sample;
use lodestar::scene::{Bsdf, Scene};
use support::twins::program::{Point, noise, run};

use super::textures::{COLORS, DIFFUSE, folder};
use super::{bsdf, load_in, surface};

fn loaded(textures: &str) -> Scene {
    load_in(&folder(textures, COLORS)).unwrap_or_else(|error| panic!("{textures}: {error}"))
}

fn at(uv: [f64; 2], position: [f64; 3]) -> Point {
    Point { uv: uv.into(), position: position.into(), normal: DVec3::Z, ..Point::default() }
}

/// Value of a texture of a scene, whatever it is.
pub fn value(scene: &Scene, texture: u32, at: Point) -> [f64; 3] {
    let texture = &scene.textures[texture as usize];
    let found = match &texture.pattern {
        Pattern::Program(program) => run(program, at, (&scene.textures, &scene.images)),
        _ => sample(texture, &scene.images, at.uv).truncate(),
    };
    found.to_array()
}

/// Reflectance of the diffuse surface with the texture `t`.
fn color(textures: &str, at: Point) -> [f64; 3] {
    let scene = loaded(&format!("{textures}\n{DIFFUSE}"));
    let Bsdf::Diffuse { reflectance } = bsdf(&scene) else { panic!("diffuse") };
    let found = value(&scene, reflectance.texture.expect("a texture"), at);
    (DVec3::from(found) * reflectance.value.as_dvec3()).to_array()
}

/// Height of the displacement with the texture `t`.
fn height(textures: &str, at: Point) -> f64 {
    let scene = loaded(&format!("{textures}\nMaterial \"diffuse\" \"texture displacement\" \"t\""));
    let Some(Relief::Bump { texture, scale }) = surface(&scene).relief else { panic!("a bump map") };
    value(&scene, texture, at)[0] * f64::from(scale)
}

fn close(found: [f64; 3], expected: [f64; 3]) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-5), "{found:?} is not {expected:?}");
}

const IMAGE: &str = "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"string filter\" \"point\"";

/// The texture's space is that of the directive, as pbrt inverts the transform that holds there.
#[test]
fn noise_lies_in_the_textures_space() {
    let place = DVec3::new(0.7, -3.2, 11.4);
    let own = (place - DVec3::new(1.0, 2.0, 3.0)) / 2.0;
    let space = "Translate 1 2 3 Scale 2 2 2";
    let fbm = |p: DVec3| noise(p) + 0.25 * noise(f64::from(1.99f32) * p);
    let found = height(
        &format!("{space} Texture \"t\" \"float\" \"fbm\" \"integer octaves\" 2 \"float roughness\" 0.25"),
        at([0.0; 2], place.to_array()),
    );
    assert!((found - fbm(own)).abs() < 1e-5 && found.abs() > 1e-3, "{found} is not {}", fbm(own));
    let wrinkled = height(
        &format!("{space} Texture \"t\" \"float\" \"wrinkled\" \"integer octaves\" 1"),
        at([0.0; 2], place.to_array()),
    );
    assert!((wrinkled - (noise(own).abs() + 0.1)).abs() < 1e-5, "{wrinkled}");
    let waves = |p: DVec3, count: i32| -> f64 {
        (0..count).map(|octave| 0.5f64.powi(octave) * noise(f64::from(1.99f32).powi(octave) * p)).sum()
    };
    let windy = height(&format!("{space} Texture \"t\" \"float\" \"windy\""), at([0.0; 2], place.to_array()));
    assert!((windy - waves(0.1 * own, 3).abs() * waves(own, 6)).abs() < 1e-4, "{windy}");
}

/// Where noise is 0, values are those of the spline.
#[test]
fn marble() {
    let text = "Texture \"t\" \"spectrum\" \"marble\" \"float scale\" 1 \"float variation\" 0.5";
    // At the height 0 the share is 0.5: the beginning of the fourth segment.
    close(color(text, at([0.0; 2], [0.0; 3])), [0.75; 3]);
    let up = std::f64::consts::FRAC_PI_2;
    let noise = 0.5 * (0..8).map(|o| 0.5f64.powi(o) * noise(1.99f64.powi(o) * DVec3::new(0.0, up, 0.0))).sum::<f64>();
    let share = 0.5 + 0.5 * (up + noise).sin();
    let found = color(text, at([0.0; 2], [0.0, up, 0.0]));
    assert!(share > 5.0 / 6.0 && found[2] > found[0], "{found:?}");
}

#[test]
fn mappings() {
    let image = |mapping: &str| IMAGE.replace("\"i\"", "\"t\"") + " " + mapping;
    // The image has red and green above, blue and white below.
    let planar = image("\"string mapping\" \"planar\" \"vector3 v1\" [ 0 0 1 ] \"float vdelta\" 0.5");
    close(color(&planar, at([0.9, 0.9], [5.0, 0.3, 0.25])), [1.0, 0.0, 0.0]);
    close(color(&planar, at([0.9, 0.9], [5.0, 0.3, 0.75])), [0.0, 1.0, 0.0]);
    close(color(&planar, at([0.9, 0.9], [5.0, -0.3, 0.25])), [0.0, 0.0, 1.0]);
    // The first coordinate is the angle from the z-axis in half turns.
    let sphere = image("\"string mapping\" \"spherical\"");
    close(color(&sphere, at([0.0; 2], [1.0, -1.0, 0.5])), [1.0, 0.0, 0.0]);
    close(color(&sphere, at([0.0; 2], [1.0, -1.0, -0.5])), [0.0, 1.0, 0.0]);
    close(color(&sphere, at([0.0; 2], [1.0, 1.0, 0.5])), [0.0, 0.0, 1.0]);
    let cylinder = image("\"string mapping\" \"cylindrical\"");
    close(color(&cylinder, at([0.0; 2], [0.0, -1.0, 0.7])), [1.0, 0.0, 0.0]);
    close(color(&cylinder, at([0.0; 2], [0.0, 1.0, 0.7])), [0.0, 1.0, 0.0]);
    close(color(&cylinder, at([0.0; 2], [0.0, -1.0, 0.2])), [0.0, 0.0, 1.0]);
    let black = image("\"string wrap\" \"black\"");
    close(color(&black, at([0.2, 0.8], [0.0; 3])), [1.0, 0.0, 0.0]);
    for outside in [[1.2, 0.8], [-0.2, 0.8], [0.2, 1.2], [0.2, -0.2]] {
        close(color(&black, at(outside, [0.0; 3])), [0.0; 3]);
    }
}

#[test]
fn patterns_of_textures() {
    let board = |rest: &str| format!("{IMAGE} Texture \"t\" \"spectrum\" \"checkerboard\" {rest}");
    let of_image = board("\"float uscale\" 2 \"texture tex1\" \"i\" \"rgb tex2\" [ 0.1 0.2 0.3 ]");
    close(color(&of_image, at([0.2, 0.8], [0.0; 3])), [1.0, 0.0, 0.0]);
    close(color(&of_image, at([0.7, 0.8], [0.0; 3])), [0.1, 0.2, 0.3]);
    let solid = board("\"integer dimension\" 3 \"rgb tex1\" [ 1 0 0 ] \"rgb tex2\" [ 0 0 1 ]");
    close(color(&solid, at([0.0; 2], [0.5, 0.5, 0.5])), [1.0, 0.0, 0.0]);
    close(color(&solid, at([0.0; 2], [0.5, -0.5, 0.5])), [0.0, 0.0, 1.0]);
    close(color(&solid, at([0.0; 2], [1.5, -0.5, 0.5])), [1.0, 0.0, 0.0]);
    let bilerp = "Texture \"t\" \"spectrum\" \"bilerp\" \"rgb v00\" [ 0 0 0 ] \"rgb v10\" [ 1 0 0 ] \"rgb v01\" [ 0 1 0 ] \"rgb v11\" [ 0 0 1 ]";
    close(color(bilerp, at([0.25, 0.5], [0.0; 3])), [0.125, 0.375, 0.125]);
    let turned =
        "Rotate 90 1 0 0 Texture \"t\" \"spectrum\" \"directionmix\" \"rgb tex1\" [ 1 0 0 ] \"rgb tex2\" [ 0 0 1 ]";
    // The y-axis of the texture's space is the z-axis of the world, which is the normal.
    close(color(turned, at([0.0; 2], [0.0; 3])), [1.0, 0.0, 0.0]);
    let slanted = "Texture \"t\" \"spectrum\" \"directionmix\" \"vector3 dir\" [ 0 3 4 ] \"rgb tex1\" [ 1 0 0 ] \"rgb tex2\" [ 0 0 1 ]";
    close(color(slanted, at([0.0; 2], [0.0; 3])), [0.8, 0.0, 0.2]);
    // As in pbrt, a dot has the color of `outside`.
    let dots = "Texture \"t\" \"spectrum\" \"dots\" \"rgb inside\" [ 1 0 0 ] \"rgb outside\" [ 0 0 1 ]";
    let cell = (0..100).map(f64::from).find(|cell| noise(DVec3::new(cell + 0.5, 0.5, 0.5)) > 0.0).unwrap();
    close(color(dots, at([cell, 0.0], [0.0; 3])), [0.0, 0.0, 1.0]);
    close(color(dots, at([cell + 0.5, 0.5], [0.0; 3])), [1.0, 0.0, 0.0]);
}

/// Textures that lie differently on the surface are combined where they are met.
#[test]
fn textures_that_lie_differently() {
    let board = "Texture \"b\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ 1 1 1 ] \"rgb tex2\" [ 0 0 0 ]";
    let mixed = format!(
        "{board} {IMAGE} Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"b\" \"texture tex2\" \"i\" \"float amount\" 0.25"
    );
    close(color(&mixed, at([0.2, 0.8], [0.0; 3])), [1.0, 0.75, 0.75]);
    close(color(&mixed, at([1.2, 0.8], [0.0; 3])), [0.25, 0.0, 0.0]);
    let number =
        "Texture \"r\" \"float\" \"checkerboard\" \"integer dimension\" 3 \"float tex1\" 0.25 \"float tex2\" 0.04";
    let scene = loaded(&format!("{number} Material \"conductor\" \"texture roughness\" \"r\""));
    let Bsdf::RoughConductor { microfacets, .. } = bsdf(&scene) else { panic!("rough") };
    let alpha = |position| value(&scene, microfacets.alpha_u.texture.unwrap(), at([0.0; 2], position))[0];
    assert!((alpha([0.5; 3]) - 0.5).abs() < 1e-6 && (alpha([1.5, 0.5, 0.5]) - 0.2).abs() < 1e-6);
    let holes = "Texture \"a\" \"float\" \"fbm\" Attribute \"shape\" \"texture alpha\" \"a\"";
    assert!(surface(&loaded(holes)).opacity.texture.is_some());
    let coated = loaded(&format!("{number} Material \"coateddiffuse\" \"texture roughness\" \"r\""));
    assert!(coated.warnings.join("\n").contains("the texture's mean is used"));
}

#[test]
fn what_is_refused() {
    for (textures, expected) in [
        ("Texture \"t\" \"float\" \"fbm\" \"integer octaves\" 99", "must be a whole number in 0..32"),
        ("Texture \"t\" \"float\" \"marble\"", "the texture `marble` is not supported"),
        ("Texture \"t\" \"float\" \"ptex\"", "the texture `ptex` is not supported"),
        (
            "Texture \"b\" \"float\" \"directionmix\" \"vector3 dir\" [ 0 0 0 ] Texture \"t\" \"float\" \"scale\" \"texture tex\" \"b\"",
            "`dir` of a `directionmix` must have a length above 0",
        ),
    ] {
        let scene = format!("{textures}\nMaterial \"diffuse\" \"texture displacement\" \"t\"");
        let error = load_in(&folder(&scene, COLORS)).expect_err(expected);
        assert!(error.contains(expected) && error.contains("scene.pbrt:"), "{error} lacks {expected}");
    }
}
