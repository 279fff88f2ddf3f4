//! Scenes with several cameras.

use crate::support::{Folder, SCENE, assert_quiet_success, assert_sentence};
use lodestar::image::exr::read_rgb;

/// Adds a camera behind the cube, which has the name `back`.
fn two_cameras() -> Folder {
    let folder = Folder::new();
    let film =
        "<film type=\"hdrfilm\"><integer name=\"width\" value=\"8\"/><integer name=\"height\" value=\"6\"/></film>";
    let turn = "<transform name=\"to_world\"><rotate y=\"1\" angle=\"90\"/></transform>";
    let back = format!("<sensor type=\"perspective\" id=\"back\">{turn}{film}</sensor>");
    folder.write("scene.xml", &SCENE.replace("<emitter", &format!("{back}<emitter")));
    folder
}

#[test]
fn all_cameras_have_a_picture_each() {
    let folder = two_cameras();
    let output = folder.run(&["render", "scene.xml", "--camera", "all", "--spp", "2", "-o", "a.exr", "-o", "b.png"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("camera 1 of 2: 0\n") && said.contains("camera 2 of 2: back\n"), "{said}");
    assert_eq!(folder.names(), ["a.0.exr", "a.back.exr", "b.0.png", "b.back.png", "scene.xml"]);
    for (name, choice) in [("a.0.exr", "0"), ("a.back.exr", "back")] {
        let alone = ["render", "scene.xml", "--quiet", "--camera", choice, "--spp", "2", "-o", "alone.exr"];
        assert_quiet_success(&folder.run(&alone));
        assert_eq!(read_rgb(&folder.path("alone.exr")).unwrap(), read_rgb(&folder.path(name)).unwrap(), "{name}");
    }
    let info = folder.run(&["info", "scene.xml", "--camera", "back"]);
    assert!(String::from_utf8(info.stdout).unwrap().contains("cameras: 0, 1 (`back`)\n"));
}

#[test]
fn files_of_one_picture_are_refused_for_all_cameras() {
    let folder = two_cameras();
    let common = ["render", "scene.xml", "--camera", "all", "--spp", "1"];
    for more in [["--stats", "s.json"], ["--checkpoint", "a.ckpt"]] {
        assert_sentence(&folder.run(&[&common[..], &more].concat()), 1, &["--camera all", more[0], "name a camera"]);
    }
    let mut of_launcher = folder.command(&common);
    assert_sentence(
        &of_launcher.env("OMPI_COMM_WORLD_SIZE", "2").output().unwrap(),
        1,
        &["--camera all", "several processes"],
    );
    folder.write("none.xml", "<scene version=\"3.0.0\"><emitter type=\"constant\"/><shape type=\"cube\"/></scene>");
    let none = folder.run(&["render", "none.xml", "--camera", "all"]);
    assert_sentence(&none, 1, &["none.xml: the scene has no camera"]);
}
