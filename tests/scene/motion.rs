//! Motion in scenes of Mitsuba and pbrt.

use glam::{DMat4, DVec3};
use lodestar::scene::{Course, Motion, PrimitiveShape};

use crate::{Folder, load_body};

/// Sensor whose shutter is open for a second.
const SENSOR: &str = r#"<sensor type="perspective"><float name="shutter_open" value="0"/>
    <float name="shutter_close" value="1"/></sensor>"#;
const ANIMATION: &str = r#"<animation name="to_world"><transform time="0"/>
    <transform time="2"><rotate z="1" angle="90"/><translate x="2"/></transform></animation>"#;

fn load(sensor: &str, body: &str) -> lodestar::Result<lodestar::scene::Scene> {
    let text = format!("<scene version=\"3.0.0\">{sensor}{body}</scene>");
    Folder::new(&[("scene.xml", &text), ("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]).load(&[])
}

fn expected(shutter: [f64; 2]) -> Motion {
    let end = DMat4::from_translation(DVec3::new(2.0, 0.0, 0.0)) * DMat4::from_rotation_z(90_f64.to_radians());
    match Motion::of_keys(&[(0.0, DMat4::IDENTITY), (2.0, end)], shutter) {
        Ok(Course::Moving(motion)) => motion,
        other => panic!("{other:?}"),
    }
}

/// Shapes, instances and cameras that move, by Mitsuba's `<animation>`.
#[test]
fn animations_of_mitsuba() {
    let shapes = format!(
        r#"<shape type="sphere"><float name="radius" value="0.5"/><point name="center" x="1" y="0" z="0"/>{ANIMATION}</shape>
        <shape type="rectangle"><emitter type="area"/>{ANIMATION}</shape>
        <shape type="disk"/>
        <shape type="shapegroup" id="g"><shape type="sphere"/><shape type="rectangle"/></shape>
        <shape type="instance"><ref id="g"/>{ANIMATION}</shape><shape type="instance"><ref id="g"/>{ANIMATION}</shape>
        <shape type="instance"><ref id="g"/></shape>"#
    );
    let scene = load(SENSOR, &shapes).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // The disk, and the copies of the instance that stands.
    assert_eq!((scene.primitives.len(), scene.groups.len(), scene.instances.len()), (3, 3, 4));
    assert!(scene.motions.iter().all(|motion| *motion == expected([0.0, 1.0])));
    let sphere = scene.groups[0].primitives[0];
    assert_eq!((sphere.shape, sphere.origin.x, sphere.edge_u.length()), (PrimitiveShape::Sphere, 1.0, 0.5));
    assert_eq!(scene.groups[1].primitives[0].emitter, Some(0));
    assert_eq!(scene.groups[2].primitives.len(), 2);
    assert_eq!(scene.shown_primitives(), 3 + 1 + 1 + 2 + 2);

    let sensor = SENSOR.replace("</sensor>", &format!("{ANIMATION}</sensor>"));
    let scene = load(&sensor, r#"<shape type="disk"/>"#).unwrap();
    assert_eq!(scene.camera_motion, Some(expected([0.0, 1.0])));
    assert_eq!(scene.camera.world_from_camera, expected([0.0, 1.0]).at(0.5).as_mat4());
}

/// Without a shutter, everything stands where it is at the time 0, and the user is told.
#[test]
fn a_shutter_that_is_open_for_no_time() {
    let body = format!(r#"<shape type="sphere">{ANIMATION}</shape>"#);
    let scene = load_body(&body).unwrap();
    assert!(scene.warnings[0].contains("the shutter is open for no time"), "{:?}", scene.warnings);
    assert_eq!((scene.primitives[0].origin, scene.motions.len()), (glam::Vec3::ZERO, 0));
    let at_one = r#"<sensor type="perspective"><float name="shutterOpen" value="2"/><float name="shutterClose" value="2"/></sensor>"#;
    assert!(load(at_one, &body).unwrap().primitives[0].origin.abs_diff_eq(glam::Vec3::new(2.0, 0.0, 0.0), 1.0e-6));
    let error = load(&at_one.replace("\"shutterClose\" value=\"2\"", "\"shutterClose\" value=\"1\""), &body).map(drop);
    assert!(error.unwrap_err().to_string().contains("`shutter_close` (1) must not be before `shutter_open` (2)"));
}

#[test]
fn animations_that_make_no_sense() {
    let refused = |body: &str, part: &str| {
        let error = load(SENSOR, body).map(drop).expect_err("this should be refused").to_string();
        assert!(error.contains(part), "`{part}` is missing in: {error}");
    };
    let sphere =
        |animation: &str| format!(r#"<shape type="sphere"><animation name="to_world">{animation}</animation></shape>"#);
    refused(&sphere(""), "needs a <transform> with its `time`");
    refused(&sphere("<transform/>"), "<transform> lacks its attribute `time`");
    refused(&sphere("<lookat/>"), "has one <transform> for each time, not a <lookat>");
    refused(&sphere(r#"<transform time="0"><scale x="2"/></transform>"#), "must not scale unevenly");
    refused(&sphere(r#"<transform time="0"/><transform time="0"/>"#), "two keys have the time 0");
    refused(
        &sphere(r#"<transform time="0"/><transform time="1"><scale value="-1"/></transform>"#),
        "is a mirror at one",
    );
    let lamp = format!(r#"<emitter type="spot">{ANIMATION}</emitter>"#);
    refused(&lamp, "emitter `spot` cannot move; give its `to_world` as a <transform>");
}

/// A mirrored mesh without normals faces as one that stands.
#[test]
fn mirrored_shapes_that_move() {
    let mesh = |place: &str| format!(r#"<shape type="obj"><string name="filename" value="mesh.obj"/>{place}</shape>"#);
    let mirror = r#"<scale x="-1"/>"#;
    let still = load(SENSOR, &mesh(&format!(r#"<transform name="to_world">{mirror}</transform>"#))).unwrap();
    let keys = format!(
        r#"<animation name="to_world"><transform time="0">{mirror}</transform>
        <transform time="1">{mirror}<translate z="1"/></transform></animation>"#
    );
    let moving = load(SENSOR, &mesh(&keys)).unwrap();
    assert_eq!(moving.groups[0].primitives, still.primitives);
    assert!(moving.motions[0].at(0.0).abs_diff_eq(DMat4::IDENTITY, 1.0e-6));
}
