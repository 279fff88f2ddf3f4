//! `<emitter>`: the forms that are read, and the forms that are refused.

use glam::{Mat3, Vec3, vec3};
use lodestar::scene::{
    Bsdf, DeltaKind, Environment, EnvironmentKind, MaterialKind, Scene, SurfaceMaterial, Textured, load,
};

use super::{Folder, load_body, with_sensor};

/// Folder with the scene and a picture `sky.exr`.
fn folder(body: &str) -> Folder {
    let folder = Folder::new(&[("scene.xml", &with_sensor(body))]);
    let sky = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/lights/sky.exr");
    std::fs::copy(sky, folder.path("sky.exr")).unwrap();
    folder
}

fn emitter(plugin: &str, parameters: &str) -> String {
    format!(r#"<emitter type="{plugin}">{parameters}</emitter>"#)
}

const SKY: &str = r#"<string name="filename" value="sky.exr"/>"#;

fn delta(plugin: &str, parameters: &str) -> DeltaKind {
    let scene = load_body(&emitter(plugin, parameters)).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.delta_emitters.len(), 1);
    scene.delta_emitters[0].kind
}

#[test]
fn defaults_are_mitsubas() {
    let position = Vec3::ZERO;
    assert_eq!(delta("point", ""), DeltaKind::Point { position, intensity: Vec3::ONE });
    assert_eq!(delta("directional", ""), DeltaKind::Directional { direction: Vec3::Z, irradiance: Vec3::ONE });
    let DeltaKind::Spot { position, direction, intensity, cutoff_angle, beam_width } = delta("spot", "") else {
        panic!("no spot")
    };
    assert_eq!((position, direction, intensity), (Vec3::ZERO, Vec3::Z, Vec3::ONE));
    assert!((cutoff_angle.to_degrees() - 20.0).abs() < 1.0e-4 && (beam_width.to_degrees() - 15.0).abs() < 1.0e-4);
    let scene = load_body(&emitter("constant", "")).unwrap();
    assert_eq!(scene.environment, Some(Environment::constant(Vec3::ONE)));
    let scene = folder(&emitter("envmap", SKY)).load(&[]).unwrap();
    let expected = EnvironmentKind::Map { image: 0, scale: 1.0, to_world: Mat3::IDENTITY };
    assert_eq!(scene.environment.unwrap().kind, expected);
    assert_eq!((scene.images[0].width, scene.images[0].height), (32, 16));
}

#[test]
fn old_and_new_spellings() {
    let spot = |to_world: &str, cutoff: &str, beam: &str| {
        let parameters = format!(
            r#"<transform name="{to_world}"><lookat origin="1,2,3" target="1,2,5" up="0,1,0"/></transform>
               <float name="{cutoff}" value="40"/><float name="{beam}" value="10"/>"#
        );
        delta("spot", &parameters.replace('\n', " "))
    };
    let new = spot("to_world", "cutoff_angle", "beam_width");
    assert_eq!(new, spot("toWorld", "cutoffAngle", "beamWidth"));
    let DeltaKind::Spot { position, direction, .. } = new else { panic!("no spot") };
    assert!(position == vec3(1.0, 2.0, 3.0) && direction.abs_diff_eq(Vec3::Z, 1.0e-6));
    let weight = |name: &str| {
        let scene = load_body(&emitter("point", &format!(r#"<float name="{name}" value="0.25"/>"#))).unwrap();
        scene.delta_emitters[0].sampling_weight
    };
    assert_eq!((weight("sampling_weight"), weight("samplingWeight")), (0.25, 0.25));
}

#[test]
fn places_are_given_by_name_or_transform() {
    let moved = r#"<transform name="to_world"><translate x="1" y="2" z="3"/></transform>"#;
    let named = r#"<point name="position" x="1" y="2" z="3"/>"#;
    assert_eq!(delta("point", moved), delta("point", named));
    let turned = r#"<transform name="to_world"><lookat origin="5,5,5" target="6,5,5" up="0,1,0"/></transform>"#;
    let DeltaKind::Directional { direction, .. } = delta("directional", turned) else { panic!("not directional") };
    assert!(direction.abs_diff_eq(Vec3::X, 1.0e-6));
    let DeltaKind::Directional { direction, .. } =
        delta("directional", r#"<vector name="direction" x="0" y="-3" z="4"/>"#)
    else {
        panic!("not directional")
    };
    assert!(direction.abs_diff_eq(vec3(0.0, -0.6, 0.8), 1.0e-6));
}

#[test]
fn every_plugin_has_a_scene_that_loads() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/lights/scene.xml");
    for light in [
        "area",
        "rectangle",
        "disk",
        "sphere",
        "mesh",
        "textured",
        "constant",
        "envmap",
        "point",
        "spot",
        "directional",
    ] {
        let options =
            lodestar::scene::LoadOptions { defines: vec![("light".into(), light.into())], ..Default::default() };
        let scene = load(&path, &options).unwrap();
        assert!(scene.warnings.is_empty(), "{light}: {:?}", scene.warnings);
        let count = scene.emitters.len() + scene.delta_emitters.len() + usize::from(scene.environment.is_some());
        assert_eq!(count, if light == "area" { 4 } else { 1 }, "{light}");
    }
}

/// Emitters without a BSDF are black. In Mitsuba 3, too, a shape without a BSDF has a reflectance of 0.5 only if it
/// does not emit.
#[test]
fn shapes_that_emit_are_black_unless_they_say_otherwise() {
    let scene = load_body(
        r#"<shape type="disk"><emitter type="area"/></shape> <shape type="disk"/>
           <shape type="disk"><emitter type="area"/><bsdf type="diffuse"/></shape>"#,
    )
    .unwrap();
    let reflectance =
        |scene: &Scene, primitive: usize| match &scene.materials[scene.primitives[primitive].material as usize].kind {
            MaterialKind::Surface(SurfaceMaterial { bsdf: Bsdf::Diffuse { reflectance }, .. }) => *reflectance,
            _ => panic!("not diffuse"),
        };
    let expected = [0.0, 0.5, 0.5].map(|value| Textured::constant(Vec3::splat(value)));
    assert_eq!([0, 1, 2].map(|primitive| reflectance(&scene, primitive)), expected);
}

#[track_caller]
fn refuse(body: &str, parts: &[&str]) {
    let message = folder(body).load(&[]).map(drop).expect_err("this should be refused").to_string();
    for part in [&["scene.xml:2: "], parts].concat() {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let with = |parameters: &str| emitter("envmap", &format!("{SKY}{parameters}"));
    refuse(&emitter("envmap", ""), &["`envmap`", "`filename`"]);
    refuse(&emitter("envmap", r#"<string name="filename" value="gone.exr"/>"#), &["`gone.exr`", "does not exist"]);
    refuse(&with(r#"<float name="scale" value="-1"/>"#), &["`scale`", "negative"]);
    refuse(&with(r#"<transform name="to_world"><scale value="2"/></transform>"#), &["`to_world`", "envmap"]);
    refuse(&with(r#"<transform name="to_world"><scale x="2"/></transform>"#), &["`to_world`", "envmap"]);
    refuse(&format!("{}{}", with(""), emitter("constant", "")), &["`constant`", "second environment"]);
    refuse(&format!("{}{}", emitter("constant", ""), with("")), &["`envmap`", "second environment"]);
    let moved = r#"<transform name="to_world"><translate x="1"/></transform>"#;
    refuse(&emitter("point", &format!(r#"<point name="position" x="1"/>{moved}"#)), &["`position`", "`to_world`"]);
    refuse(&emitter("directional", &format!(r#"<vector name="direction" x="1"/>{moved}"#)), &["`direction`"]);
    refuse(&emitter("directional", r#"<vector name="direction" x="0"/>"#), &["`direction`"]);
    refuse(&emitter("spot", r#"<float name="cutoff_angle" value="0"/>"#), &["`cutoff_angle`"]);
    refuse(&emitter("spot", r#"<float name="cutoff_angle" value="181"/>"#), &["`cutoff_angle`", "180"]);
    refuse(&emitter("spot", r#"<float name="beam_width" value="-1"/>"#), &["`beam_width`"]);
    refuse(&emitter("spot", r#"<texture type="checkerboard"/>"#), &["<texture>", "`spot`"]);
    let board = r#"<texture type="checkerboard" name="NAME"/>"#;
    let scaled = format!(r#"{board}<transform name="to_world"><scale value="2"/></transform>"#);
    refuse(&emitter("spot", &scaled.replace("NAME", "texture")), &["`to_world`", "scale"]);
    refuse(&emitter("projector", &scaled.replace("NAME", "irradiance")), &["`to_world`", "scale"]);
    refuse(&emitter("projector", ""), &["`projector`", "`irradiance`"]);
    refuse(&emitter("point", r#"<float name="sampling_weight" value="-1"/>"#), &["`sampling_weight`", "negative"]);
    refuse(&emitter("sky", ""), &["`sky`", "`directional`"]);
    refuse(&format!(r#"<shape type="disk">{}</shape>"#, emitter("point", "")), &["`point`", "`area`"]);
}

/// A projector's picture has the image's sides; its field of view spans the side that `fov_axis` names.
#[test]
fn projectors_have_the_shape_of_their_pictures() {
    let projector = |axis: &str| {
        let inside = format!(
            r#"<texture type="bitmap" name="irradiance"><string name="filename" value="sky.exr"/></texture>
            <float name="fov" value="90"/><string name="fov_axis" value="{axis}"/><float name="scale" value="3"/>"#
        );
        let scene = folder(&emitter("projector", &inside.replace('\n', " "))).load(&[]).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let DeltaKind::Projector { axes, irradiance, direction, .. } = scene.delta_emitters[0].kind else {
            panic!("no projector")
        };
        assert_eq!((irradiance.value, irradiance.texture, direction), (Vec3::splat(3.0), Some(0), Vec3::Z));
        let image = &scene.images[0];
        let aspect = image.width as f32 / image.height as f32;
        assert!((axes.v.length() / axes.u.length() - aspect).abs() < 1e-6, "{axes:?}");
        axes
    };
    // At distance 1, a field of view of 90 degrees spans 2.
    assert!(projector("x").u.abs_diff_eq(Vec3::NEG_X / 2.0, 1e-6), "{:?}", projector("x"));
    assert!(projector("y").v.abs_diff_eq(Vec3::NEG_Y / 2.0, 1e-6), "{:?}", projector("y"));
}

#[test]
fn pictures_of_spots_multiply_their_intensity() {
    let inside = r#"<texture type="checkerboard" name="texture"/><rgb name="intensity" value="3"/>"#;
    let DeltaKind::PicturedSpot { intensity, .. } = delta("spot", inside) else { panic!("no picture") };
    assert_eq!((intensity.value, intensity.texture), (Vec3::splat(3.0), Some(0)));
}

/// No path from the camera finds these; Mitsuba's `path` leaves them dark, too.
#[test]
fn beams_are_dark() {
    let body = r#"<emitter type="collimated"/>
<shape type="disk"><emitter type="directionalarea"><rgb name="radiance" value="3"/></emitter></shape>"#;
    let scene = load_body(body).unwrap();
    assert!(scene.emitters.is_empty() && scene.delta_emitters.is_empty());
    assert_eq!(scene.primitives[0].emitter, None);
    let [beam, area] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert!(beam.contains("scene.xml:2: ") && beam.contains("`collimated`"), "{beam}");
    assert!(area.contains("scene.xml:3: ") && area.contains("`directionalarea`"), "{area}");
}

#[test]
fn images_of_environments_must_be_readable() {
    let body = emitter("envmap", SKY);
    let broken = folder(&body);
    broken.write("sky.exr", b"no picture");
    assert!(broken.load(&[]).expect_err("refused").to_string().contains("sky.exr"));
    let small = folder(&body);
    exr::prelude::write_rgb_file(small.path("sky.exr"), 2, 2, |_, _| (1.0_f32, 1.0_f32, 1.0_f32)).unwrap();
    assert!(small.load(&[]).expect_err("refused").to_string().contains("2 x 3"));
}

#[test]
fn unknown_parameters_are_named() {
    let scene = load_body(&emitter("point", r#"<float name="wobble" value="1"/>"#)).unwrap();
    assert!(scene.warnings.len() == 1 && scene.warnings[0].contains("`wobble`"), "{:?}", scene.warnings);
}
