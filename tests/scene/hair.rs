//! Reader of `hair`, and shapes whose material it is.

use glam::Vec3;
use lodestar::scene::texture::Pattern;
use lodestar::scene::{Bsdf, MaterialKind, Scene, Textured};

use super::{Folder, load_body, with_sensor};

fn plugin(parameters: &str) -> String {
    format!(r#"<bsdf type="hair">{parameters}</bsdf>"#)
}

fn shape(inside: &str) -> String {
    format!(r#"<shape type="disk">{inside}</shape>"#)
}

#[track_caller]
fn hair_of(scene: &Scene) -> Bsdf {
    let MaterialKind::Surface(surface) = &scene.materials[0].kind else { panic!("no surface") };
    assert!(matches!(surface.bsdf, Bsdf::Hair { .. }) && surface.bsdf.is_anisotropic(), "{:?}", surface.bsdf);
    surface.bsdf.clone()
}

#[track_caller]
fn hair(parameters: &str) -> Bsdf {
    let scene = load_body(&shape(&plugin(parameters))).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    hair_of(&scene)
}

#[track_caller]
fn refuse(bsdf: &str, parts: &[&str]) {
    let message = load_body(&shape(bsdf)).map(drop).expect_err("this should be refused").to_string();
    for part in [&["scene.xml:2: "], parts].concat() {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

fn expected(sigma_a: [f32; 3], roughness: [f32; 2], eta: f32, tilt: f32, along_u: bool) -> Bsdf {
    Bsdf::Hair {
        sigma_a: Textured::constant(Vec3::from(sigma_a)),
        longitudinal_roughness: Textured::constant(roughness[0]),
        azimuthal_roughness: Textured::constant(roughness[1]),
        eta,
        tilt_sine: tilt.to_radians().sin(),
        along_u,
    }
}

#[track_caller]
fn close(found: &Bsdf, wanted: &Bsdf) {
    let (Bsdf::Hair { sigma_a: a, .. }, Bsdf::Hair { sigma_a: b, .. }) = (found, wanted) else { panic!("{found:?}") };
    assert!((a.value - b.value).length() < 1e-5, "{found:?} is not {wanted:?}");
    let plain = |bsdf: &Bsdf| {
        let mut bsdf = bsdf.clone();
        if let Bsdf::Hair { sigma_a, .. } = &mut bsdf {
            sigma_a.value = Vec3::ZERO;
        }
        bsdf
    };
    assert_eq!(plain(found), plain(wanted));
}

/// Mitsuba's defaults, and each parameter.
#[test]
fn every_parameter_is_read() {
    let pigments = [1.3 * 0.419 + 0.2 * 0.187, 1.3 * 0.697 + 0.2 * 0.4, 1.3 * 1.37 + 0.2 * 1.05];
    close(&hair(""), &expected(pigments, [0.3; 2], 1.55 / 1.000277, 2.0, false));
    let given = r#"<float name="eumelanin" value="0.5"/><float name="longitudinal_roughness" value="0.1"/>
        <float name="azimuthal_roughness" value="0.7"/><float name="scale_tilt" value="-3"/>
        <float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/><boolean name="along_u" value="true"/>"#;
    let pigments = [0.5 * 0.419 + 0.2 * 0.187, 0.5 * 0.697 + 0.2 * 0.4, 0.5 * 1.37 + 0.2 * 1.05];
    close(&hair(given), &expected(pigments, [0.1, 0.7], 1.5, -3.0, true));
    let absorbing = r#"<rgb name="sigma_a" value="0.2, 3, 40"/><float name="scale" value="2"/>"#;
    close(&hair(absorbing), &expected([0.4, 6.0, 80.0], [0.3; 2], 1.55 / 1.000277, 2.0, false));
}

/// An absorption above 1 is no reflectance, and a computed one is not clamped.
#[test]
fn absorptions_may_be_textures() {
    let board = r#"<texture type="checkerboard" name="sigma_a"><rgb name="color0" value="3"/></texture><float name="scale" value="5"/>"#;
    let scene = load_body(&shape(&plugin(board))).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let Bsdf::Hair { sigma_a, .. } = hair_of(&scene) else { panic!() };
    let Pattern::Checkerboard { color0, .. } = scene.textures[sigma_a.texture.unwrap() as usize].pattern else {
        panic!()
    };
    assert_eq!((color0, sigma_a.value), (Vec3::splat(3.0), Vec3::splat(5.0)));
    let computed =
        r#"<texture type="add" name="sigma_a"><texture type="uv" name="a"/><float name="b" value="7"/></texture>"#;
    let scene = load_body(&shape(&plugin(computed))).unwrap();
    let Bsdf::Hair { sigma_a, .. } = hair_of(&scene) else { panic!() };
    let Pattern::Program(program) = &scene.textures[sigma_a.texture.unwrap() as usize].pattern else { panic!() };
    assert_eq!(program.limits, [0.0, f32::MAX]);
}

#[test]
fn what_is_refused() {
    let sigma = r#"<rgb name="sigma_a" value="1"/>"#;
    for pigment in ["eumelanin", "pheomelanin"] {
        refuse(&plugin(&format!(r#"{sigma}<float name="{pigment}" value="1"/>"#)), &["`sigma_a`", "leave out"]);
        refuse(&plugin(&format!(r#"<float name="{pigment}" value="-1"/>"#)), &[&format!("`{pigment}`"), "negative"]);
    }
    refuse(&plugin(r#"<rgb name="sigma_a" value="-1"/>"#), &["negative"]);
    refuse(&plugin(&format!(r#"{sigma}<float name="scale" value="-1"/>"#)), &["`scale`", "negative"]);
    refuse(&plugin(r#"<float name="int_ior" value="1.5"/><float name="ext_ior" value="1.5"/>"#), &["differ"]);
    refuse(&format!(r#"<bsdf type="twosided">{}</bsdf>"#, plugin("")), &["`twosided`", "transmit nothing"]);
    refuse(&format!(r#"<bsdf type="coating">{}</bsdf>"#, plugin("")), &["`coating`", "transmits"]);
    let fog = r#"<medium type="homogeneous" name="interior"><rgb name="sigma_t" value="1"/></medium>"#;
    refuse(&format!("{}{fog}", plugin("")), &["bounds a medium", "`hair`"]);
    let rough = plugin(r#"<float name="azimuthal_roughness" value="1.5"/>"#);
    let warnings = load_body(&shape(&rough)).unwrap().warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("`azimuthal_roughness` must lie in 0..1"), "{warnings:?}");
}

/// Rays meet a mesh of hair, or of a blend with it, from outside only, and other meshes from both sides.
#[test]
fn hair_is_met_from_outside() {
    let blend = format!(
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.5"/><bsdf type="diffuse"/>{}</bsdf>"#,
        plugin("")
    );
    for (bsdf, expected) in [(plugin(""), true), (blend, true), (r#"<bsdf type="diffuse"/>"#.to_owned(), false)] {
        let scene = load_body(&format!(r#"<shape type="cylinder">{bsdf}</shape>"#)).unwrap();
        assert!(scene.primitives.iter().all(|primitive| primitive.front_only == expected), "{bsdf}");
    }
}

/// A converted file has the same hair.
#[test]
fn convert_writes_hair() {
    let body = shape(&plugin(r#"<rgb name="sigma_a" value="0.2, 3, 40"/><float name="scale_tilt" value="5"/>"#));
    let folder = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    let path = folder.path("converted.xml");
    lodestar::scene::convert(&folder.path("scene.xml"), &[], &path, false).unwrap();
    assert_eq!(hair_of(&Scene::load(&path).unwrap()), hair_of(&Scene::load(folder.path("scene.xml")).unwrap()));
}
