//! `hair` and the curves that have it.

use glam::{DVec3, Vec3};
use lodestar::scene::{Bsdf, Scene};
use support::twins::program::Point;

use super::computed::value;
use super::textures::{COLORS, folder};
use super::{bsdf, load_in, world};

const CURVE: &str = "Shape \"curve\" \"point3 P\" [ 0 0 0  0 0 1  0 0 2  0 0 3 ] \"float width\" 0.1";

fn with(parameters: &str) -> Scene {
    world(&format!("Material \"hair\" {parameters}\n{CURVE}")).unwrap_or_else(|error| panic!("{parameters}: {error}"))
}

/// Absorption, roughnesses, index, sine of the tilt.
fn numbers(scene: &Scene) -> (Vec3, [f32; 4]) {
    let Bsdf::Hair { sigma_a, longitudinal_roughness, azimuthal_roughness, eta, tilt_sine, along_u } = bsdf(scene)
    else {
        panic!("{:?}", bsdf(scene))
    };
    assert!(*along_u && sigma_a.texture.is_none());
    (sigma_a.value, [longitudinal_roughness.value, azimuthal_roughness.value, *eta, *tilt_sine])
}

#[track_caller]
fn close(found: Vec3, expected: [f32; 3]) {
    assert!(
        (found - Vec3::from(expected)).length() < 1e-4 * Vec3::from(expected).length() + 1e-6,
        "{found} is not {expected:?}"
    );
}

/// pbrt's defaults, and each way to give the color. The figures of the reflectance are those of its formula.
#[test]
fn every_parameter_is_read() {
    let (sigma_a, others) = numbers(&with(""));
    close(sigma_a, [1.3 * 0.419, 1.3 * 0.697, 1.3 * 1.37]);
    assert_eq!(others, [0.3, 0.3, 1.55, 2.0_f32.to_radians().sin()]);
    let given = "\"float beta_m\" 0.25 \"float beta_n\" 0.4 \"float eta\" 1.4 \"float alpha\" 3";
    assert_eq!(numbers(&with(given)).1, [0.25, 0.4, 1.4, 3.0_f32.to_radians().sin()]);
    close(numbers(&with("\"rgb sigma_a\" [ 0.1 2 30 ]")).0, [0.1, 2.0, 30.0]);
    close(numbers(&with("\"float eumelanin\" 0.5 \"float pheomelanin\" 2")).0, [0.5835, 1.1485, 2.785]);
    close(numbers(&with("\"float pheomelanin\" 1")).0, [0.187, 0.4, 1.05]);
    // With a beta_n of 0.3, the divisor is 5.969 - 0.0645 + 0.22788 - 0.28971 + 0.0451494 + 0.00059535.
    let divisor = 5.888_415_f32;
    let root = [0.8_f32, 0.5, 0.1].map(|color| (color.ln() / divisor).powi(2));
    close(numbers(&with("\"rgb reflectance\" [ 0.8 0.5 0.1 ]")).0, root);
    close(numbers(&with("\"rgb color\" [ 0.8 0.5 0.1 ]")).0, root);
}

/// The first given color holds, and the others are named.
#[test]
fn one_color_holds() {
    let scene = with("\"rgb reflectance\" [ 0.5 0.5 0.5 ] \"rgb sigma_a\" [ 1 2 3 ] \"float eumelanin\" 1");
    close(numbers(&scene).0, [1.0, 2.0, 3.0]);
    let warned = scene.warnings.join("\n");
    assert!(warned.contains("`reflectance` and `eumelanin` is ignored beside `sigma_a`, as in pbrt"), "{warned}");
}

/// Textures are computed point by point, images as images.
#[test]
fn colors_may_be_textures() {
    let divisor = 5.888_415_f64;
    let absorption = |color: f64| (color.ln() / divisor).powi(2);
    let sigma_a = |textures: &str, parameters: &str| {
        let text = format!("{textures}\nMaterial \"hair\" {parameters}\n{CURVE}");
        let scene = load_in(&folder(&text, COLORS)).unwrap_or_else(|error| panic!("{error}"));
        let Bsdf::Hair { sigma_a, .. } = bsdf(&scene) else { panic!("hair") };
        let point = Point { uv: [0.1, 0.1].into(), position: DVec3::ZERO, normal: DVec3::Z, ..Point::default() };
        let found = value(&scene, sigma_a.texture.expect("a texture"), point);
        DVec3::from(found) * sigma_a.value.as_dvec3()
    };
    let board = "Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ 0.5 0.25 0.125 ] \"rgb tex2\" [ 1 1 1 ]";
    let found = sigma_a(board, "\"texture reflectance\" \"t\"");
    let expected = DVec3::new(absorption(0.5), absorption(0.25), absorption(0.125));
    assert!((found - expected).length() < 1e-4, "{found} is not {expected}");
    let noise = "Texture \"n\" \"float\" \"fbm\" Texture \"one\" \"float\" \"constant\" \"float value\" 1
        Texture \"t\" \"float\" \"mix\" \"texture tex1\" \"one\" \"texture tex2\" \"n\" \"float amount\" 0";
    let found = sigma_a(noise, "\"texture eumelanin\" \"t\"");
    assert!((found - DVec3::new(0.419, 0.697, 1.37)).length() < 1e-4, "{found}");
}

/// Curves of hair are met from outside, also with reversed orientation, and their normals point outward.
#[test]
fn curves_are_fibers() {
    for reversed in ["", "ReverseOrientation "] {
        let scene = world(&format!("Material \"hair\"\n{reversed}{CURVE}")).unwrap();
        assert!(scene.primitives.iter().all(|primitive| primitive.front_only && !primitive.flip_normal));
        for primitive in &scene.primitives {
            let outward = primitive.origin.with_z(0.0);
            assert!(primitive.normals.unwrap()[0].dot(outward) > 0.0, "{primitive:?}");
        }
    }
    let warned = |text: &str| world(text).unwrap().warnings.join("\n");
    let sphere = warned("Material \"hair\"\nShape \"sphere\"");
    assert!(sphere.contains("scene.pbrt:4: the material `hair` is made for curves"), "{sphere}");
    assert!(!warned(&format!("Material \"hair\"\n{CURVE}")).contains("made for curves"));
}

#[test]
fn what_is_refused() {
    let refused = |text: &str, expected: &str| {
        let error = world(text).expect_err(expected);
        assert!(error.contains(expected), "{error} lacks {expected}");
    };
    refused(&format!("Material \"hair\" \"float eta\" 1\n{CURVE}"), "scene.pbrt:3: `eta` of a `hair` must not be 1");
    let ribbon = format!("Material \"hair\"\n{CURVE} \"string type\" \"ribbon\" \"normal N\" [ 1 0 0 1 0 0 ]");
    refused(&ribbon, "scene.pbrt:4: the material `hair` on a `ribbon` is not supported");
}
