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

/// A mesh of two triangles whose PLY file has this many sets of vertices more; each lies one unit higher. The last column of `normals` is
/// whether sets have normals.
fn sets(more: usize, normals: bool) -> String {
    let kinds: &[&str] = if normals { &["position", "normal"] } else { &["position"] };
    let first = ["x", "y", "z"].into_iter().chain(if normals { vec!["nx", "ny", "nz"] } else { Vec::new() });
    let mut names: Vec<String> = first.map(str::to_owned).collect();
    for at in 1..=more {
        names.extend(kinds.iter().flat_map(|kind| ["x", "y", "z"].map(|axis| format!("{kind}{at}_{axis}"))));
    }
    let properties: String = names.iter().map(|name| format!("property float {name}\n")).collect();
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\n{properties}element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    );
    for [x, y] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
        let of_set = |z: usize| format!("{x} {y} {z} {}", if normals { "0 0 -1 " } else { "" });
        text += &((0..=more).map(of_set).collect::<String>() + "\n");
    }
    text + "3 0 1 2\n3 0 2 3\n"
}

fn load_sets(sensor: &str, body: &str, more: usize, normals: bool) -> lodestar::Result<lodestar::scene::Scene> {
    let text = format!("<scene version=\"3.0.0\">{sensor}{body}</scene>");
    Folder::new(&[("scene.xml", &text), ("mesh.ply", &sets(more, normals))]).load(&[])
}

const SHEET: &str = r#"<shape type="ply"><string name="filename" value="mesh.ply"/><emitter type="area"/></shape>"#;

/// Sets of vertices of PLY files, in the world and in groups that instances show.
#[test]
fn sets_of_vertices() {
    for (more, normals) in [(1, false), (2, true), (16, false)] {
        let scene = load_sets(SENSOR, SHEET, more, normals).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let deformation = &scene.deformations[0];
        assert_eq!((scene.deformations.len(), deformation.triangles(), deformation.intervals), (1, 0..2, more as u32));
        for (at, key) in deformation.keys_of(1).iter().enumerate() {
            let z = at as f32;
            let vertices = key.vertices.map(|vertex| vertex.to_array());
            assert_eq!(vertices, [[0.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]]);
            // Computed normals are those of the face.
            let z = if normals { -1.0 } else { 1.0 };
            assert!(key.normals.unwrap().iter().all(|normal| normal.to_array() == [0.0, 0.0, z]));
        }
        assert_eq!(scene.bounds().unwrap().1.z, more as f32);
    }
    let refused = load_sets(SENSOR, SHEET, 17, false).unwrap_err().to_string();
    assert!(refused.contains("`position17_x` is one of more than 17 sets of vertices"), "{refused}");
    let group = format!(
        r#"<shape type="rectangle"/><shape type="shapegroup" id="g">{SHEET}<shape type="disk"/>{SHEET}</shape>
        <shape type="instance"><ref id="g"/>{ANIMATION}</shape>"#
    );
    let scene = load_sets(SENSOR, &group, 1, false).unwrap();
    assert!(scene.deformations.is_empty());
    let firsts: Vec<_> = scene.groups[0].deformations.iter().map(|deformation| deformation.first).collect();
    assert_eq!((scene.groups[0].primitives.len(), firsts), (5, vec![0, 3]));
    assert!(scene.bounds().unwrap().1.x > 2.0);
}

/// Sets that are not whole, or have no set before them, are refused.
#[test]
fn sets_are_whole() {
    let refused = |properties: &str, parts: &[&str]| {
        let names: Vec<&str> = properties.split(' ').collect();
        let lines: String = names.iter().map(|name| format!("property float {name}\n")).collect();
        let mesh = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\n{lines}element face 1\nproperty list uchar int vertex_indices\nend_header\n{}3 0 1 2\n",
            format!("{}\n", vec!["1"; names.len()].join(" ")).repeat(3)
        );
        let text = format!("<scene version=\"3.0.0\">{SENSOR}{SHEET}</scene>");
        let message = Folder::new(&[("scene.xml", &text), ("mesh.ply", &mesh)]).load(&[]).unwrap_err().to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{properties}: {message}");
    };
    for (properties, name) in [
        ("x y z position1_x", "position1_x"),
        ("x y z position1_x position1_y", "position1_x"),
        ("x y z position1_z position1_y position1_x", "position1_z"),
        ("x y z position2_x position2_y position2_z", "position2_x"),
        ("x y z normal1_x normal1_y normal1_z", "normal1_x"),
    ] {
        refused(properties, &["mesh.ply:", "the sets of vertices are not whole", name]);
    }
    let twice = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nelement vertex 1\nend_header\n";
    let text = format!("<scene version=\"3.0.0\">{SENSOR}{SHEET}</scene>");
    let message = Folder::new(&[("scene.xml", &text), ("mesh.ply", twice)]).load(&[]).unwrap_err().to_string();
    assert!(message.contains("mesh.ply:5: a second element `vertex`"), "{message}");
}

/// A triangle that has no area at first has the front that its normals give it later.
#[test]
fn a_mesh_may_grow_from_a_point() {
    let mesh = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float position1_x\n\
                property float position1_y\nproperty float position1_z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
                0 0 0 0 0 0\n0 0 0 0 1 0\n0 0 0 1 0 0\n3 0 1 2\n";
    let text = format!("<scene version=\"3.0.0\">{SENSOR}{SHEET}</scene>");
    let scene = Folder::new(&[("scene.xml", &text), ("mesh.ply", mesh)]).load(&[]).unwrap();
    let (primitive, keys) = (&scene.primitives[0], scene.deformations[0].keys_of(0));
    assert!(!primitive.flip_normal && keys.len() == 2);
    assert_eq!(keys[1].normals.unwrap()[0].z, -1.0);
}

/// Without time, a mesh has its first shape.
#[test]
fn sets_need_time() {
    let scene = load_sets(r#"<sensor type="perspective"/>"#, SHEET, 2, false).unwrap();
    assert!(scene.deformations.is_empty() && scene.warnings[0].contains("it does not move"), "{:?}", scene.warnings);
    assert_eq!(scene.bounds().unwrap().1.z, 0.0);
}
