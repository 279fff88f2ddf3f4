//! Files of strangers: the program waits for none, takes little memory for what is refused, and says so in one sentence.
#![cfg(unix)]

use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::support::{Folder, assert_sentence, wait_until};

/// Runs the program to its end, which must come soon, within an address space of 2 GiB.
fn run(folder: &Folder, arguments: &[&str]) -> Output {
    let words = ["-c", "ulimit -v 2097152; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_lodestar")];
    let command = folder.command(&[]);
    let mut shell = Command::new("sh");
    shell.args(words).args(arguments).current_dir(folder.path(""));
    command.get_envs().for_each(|(name, value)| match value {
        Some(value) => drop(shell.env(name, value)),
        None => drop(shell.env_remove(name)),
    });
    // Each thread's arena takes address space.
    shell.env("RAYON_NUM_THREADS", "2").env("MALLOC_ARENA_MAX", "2").env("VK_DRIVER_FILES", "/nonexistent");
    shell.env_remove("VK_ICD_FILENAMES").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = shell.spawn().unwrap();
    wait_until(|| child.try_wait().unwrap());
    child.wait_with_output().unwrap()
}

/// Arguments with which the program reads the file `FILE`, for each way in which a user names one.
const WAYS: [&[&str]; 15] = [
    &["info", "FILE"],
    &["render", "FILE"],
    &["convert", "FILE", "out.xml"],
    &["info", "FILE.gltf"],
    &["info", "FILE.pbrt"],
    &["view", "FILE.exr"],
    &["compare", "FILE.exr", "FILE.exr"],
    &["merge", "FILE.exr", "FILE.exr", "-o", "out.exr"],
    &["resume", "FILE"],
    &["render", "scene.xml", "--environment", "FILE"],
    &["render", "scene.xml", "--reference", "FILE.exr"],
    &["render", "scene.xml", "--guide", "FILE"],
    &["info", "FILE.guide"],
    &["merge", "FILE.guide", "FILE.guide", "-o", "out.guide"],
    &["info", "scene.xml", "--environment", "FILE"],
];

/// Files of the system never end, have no length, or wait for somebody.
#[test]
fn only_regular_files_are_read() {
    let folder = Folder::new();
    assert!(Command::new("mkfifo").arg(folder.path("pipe")).status().unwrap().success());
    for (file, word) in
        [("/dev/zero", "it is a device, not a regular file"), ("pipe", "it is a pipe, not a regular file")]
    {
        let file = folder.path(file);
        for link in ["FILE", "FILE.exr", "FILE.gltf", "FILE.pbrt", "FILE.guide"] {
            let _ = std::fs::remove_file(folder.path(link));
            std::os::unix::fs::symlink(&file, folder.path(link)).unwrap();
        }
        for way in WAYS {
            assert_sentence(&run(&folder, way), 1, &["FILE", word]);
        }
    }
}

/// Files that a scene names.
#[test]
fn a_scene_names_regular_files_only() {
    let folder = Folder::new();
    let model = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":8,"uri":"FILE"}],"scenes":[{}]}"#;
    folder.write("model.gltf", model);
    let scene = crate::support::SCENE;
    let shape = |plugin: &str| {
        let file = format!(r#"<shape type="{plugin}"><string name="filename" value="FILE"/></shape>"#);
        scene.replace("</scene>", &(file + "</scene>"))
    };
    let scenes = [
        shape("obj"),
        shape("ply"),
        shape("serialized"),
        shape("linearcurve"),
        scene.replace(
            "<emitter type=\"constant\"/>",
            r#"<emitter type="envmap"><string name="filename" value="FILE"/></emitter>"#,
        ),
        scene.replace(
            "<rgb name=\"reflectance\" value=\"$gray\"/>",
            r#"<spectrum name="reflectance" filename="FILE"/>"#,
        ),
        scene.replace("<emitter type=\"constant\"/>", r#"<include filename="FILE"/>"#),
    ];
    let begin = "Camera \"perspective\" WorldBegin\n";
    let worlds = [
        "Include \"FILE\"",
        "Shape \"plymesh\" \"string filename\" \"FILE\"",
        "LightSource \"distant\" \"spectrum L\" \"FILE\"",
    ];
    assert!(Command::new("mkfifo").arg(folder.path("pipe")).status().unwrap().success());
    let folders = ["/dev/zero", "pipe", "/proc/self/environ", "/proc/kmsg"];
    for file in folders.map(|file| folder.path(file)) {
        let _ = std::fs::remove_file(folder.path("FILE"));
        std::os::unix::fs::symlink(&file, folder.path("FILE")).unwrap();
        assert_sentence(&run(&folder, &["info", "model.gltf"]), 1, &["model.gltf"]);
        for scene in &scenes {
            folder.write("a.xml", scene);
            assert_sentence(&run(&folder, &["info", "a.xml"]), 1, &[]);
        }
        for world in worlds {
            folder.write("a.pbrt", &(begin.to_owned() + world + "\n"));
            let output = run(&folder, &["info", "a.pbrt"]);
            assert!(output.status.code().is_some_and(|code| code <= 1), "{output:?}");
        }
    }
}

/// A scene comes from a file: a pipe has no folder in which its files could be searched.
#[test]
fn a_scene_from_a_pipe_is_refused() {
    let folder = Folder::new();
    let mut command = folder.command(&["info", "/dev/stdin"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let _pipe = child.stdin.take();
    wait_until(|| child.try_wait().unwrap());
    let words = ["/dev/stdin: cannot be read: it is a pipe, not a regular file; save its content as a file"];
    assert_sentence(&child.wait_with_output().unwrap(), 1, &words);
}

/// Small files that ask for any amount of memory or time.
#[test]
fn crafted_files_end_soon_and_small() {
    let folder = Folder::new();
    let begin = "<scene version=\"3.0.0\">";
    let default = |i: u32| format!("<default name=\"a{i}\" value=\"{}\"/>", format!("$a{}", i - 1).repeat(10));
    let names: String = (1..10).map(default).collect();
    folder.write("names.xml", &format!("{begin}<default name=\"a0\" value=\"xxxxxxxxxx\"/>{names}</scene>"));
    for i in 0..14 {
        let next = format!("<include filename=\"{}.xml\"/>", i + 1).repeat(8);
        folder.write(&format!("{i}.xml"), &format!("{begin}{next}</scene>"));
    }
    folder.write("14.xml", &format!("{begin}</scene>"));
    let attributes: String = (0..100_000).map(|i| format!(" a{i}=\"\"")).collect();
    folder.write("attributes.xml", &format!("{begin}<bsdf{attributes}/></scene>"));
    folder.write("elements.xml", &format!("{begin}{}</scene>", "<a/>".repeat(9_000_000)));
    folder.write("nested.xml", &"<scene>".repeat(1_000_000));
    folder.write("nested.gltf", &"{\"a\":".repeat(1_000_000));
    let parameters: String = (0..100_000).map(|i| format!(" \"float a{i}\" 1")).collect();
    folder.write("parameters.pbrt", &format!("Camera \"perspective\" WorldBegin\nShape \"sphere\"{parameters}\n"));
    folder
        .write("blocks.pbrt", &format!("Camera \"perspective\" WorldBegin\n{}", "AttributeBegin\n".repeat(1_000_000)));
    for (name, word) in [
        ("names.xml", "names.xml:1: the values that replace $names"),
        ("0.xml", "the scene includes more than 4096 files"),
        ("attributes.xml", "attributes.xml:1: an element with more than 64 attributes"),
        ("elements.xml", "elements.xml:1: with it the scene's XML has more than 8388608 elements"),
        ("nested.xml", "nested.xml:1: elements are nested more than 64 deep"),
        ("nested.gltf", "nested.gltf: "),
        ("parameters.pbrt", "parameters.pbrt:2: Shape `sphere` has more than 256 parameters"),
    ] {
        assert_sentence(&run(&folder, &["info", name]), 1, &[word]);
    }
    assert_eq!(run(&folder, &["info", "blocks.pbrt"]).status.code(), Some(1));
    // They all have ended within the patience of `wait_until`; none is near it.
    let begin = std::time::Instant::now();
    run(&folder, &["info", "names.xml"]);
    assert!(begin.elapsed() < Duration::from_secs(10), "{:?}", begin.elapsed());
}
