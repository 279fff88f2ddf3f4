//! Files that the program writes: those that the command line names, and its cache. It may read any file that a scene
//! names, wherever it lies.

use std::fs;

use crate::support::{Folder, SCENE, assert_quiet_success, assert_written};

const MESH: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";

#[test]
fn only_named_files_and_the_cache_are_written() {
    let folder = Folder::new();
    for name in ["work", "home", "temporary", "cache", "scene/inside", "elsewhere"] {
        fs::create_dir_all(folder.path(name)).unwrap();
    }
    let shape = r#"<shape type="obj"><string name="filename" value="../../elsewhere/quad.obj"/></shape></scene>"#;
    folder.write("scene/inside/scene.xml", &SCENE.replace("</scene>", shape));
    folder.write("elsewhere/quad.obj", MESH);
    let before = folder.names();
    let run = |arguments: &[&str]| {
        let mut command = folder.command(arguments);
        command.current_dir(folder.path("work")).env("HOME", folder.path("home"));
        let output = command.env("TMPDIR", folder.path("temporary")).output().unwrap();
        match arguments {
            ["merge", .., name] => assert_written(&output, name),
            _ => assert_quiet_success(&output),
        }
    };
    let scene = "../scene/inside/scene.xml";
    let files = ["-o", "a.exr", "-o", "b.png", "--stats", "s.json", "--checkpoint", "c.ckpt", "--write-every", "0.01"];
    run(&[&["render", scene, "--quiet", "--spp", "24"][..], &files].concat());
    run(&["resume", "c.ckpt", "--quiet", "--spp", "32", "-o", "d.exr"]);
    let range = ["--sampler", "bsdf", "--spp", "8", "--sample-offset"];
    run(&[&["render", scene, "--quiet", "-o", "e.exr"][..], &range, &["0"]].concat());
    run(&[&["render", scene, "--quiet", "-o", "f.exr"][..], &range, &["8"]].concat());
    run(&["merge", "e.exr", "f.exr", "-o", "g.exr"]);
    let named = ["a.exr", "b.png", "c.ckpt", "d.exr", "e.exr", "f.exr", "g.exr", "s.json"];
    let named = named.map(|name| format!("work/{name}"));
    let written: Vec<_> = folder.names().into_iter().filter(|name| !before.contains(name)).collect();
    assert_eq!(written, named);
    // The cache holds only Lodestar's files and the driver's.
    let mut cached: Vec<_> =
        fs::read_dir(folder.path("cache")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    cached.retain(|name| name != "lodestar" && !name.to_string_lossy().starts_with("mesa_shader_cache"));
    assert!(cached.is_empty(), "{cached:?}");
}
