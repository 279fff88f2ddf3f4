//! Inputs as people write them first: typos, folders, units, one side of a size. Each works, or its message says what to do.

use std::fs;

use lodestar::image::exr::read_rgb;

use crate::support::{Folder, SCENE, assert_quiet_success, assert_sentence, attribute};

const TINY: [&str; 6] = ["--spp", "1", "--sampler", "bsdf", "--scale", "0.5"];

#[test]
fn a_typo_is_answered_with_the_name_that_was_meant() {
    let folder = Folder::new();
    for (arguments, meant) in [
        (&["render", "scene.xml", "--ssp", "4"][..], "'--spp'"),
        (&["render", "scene.xml", "--chekpoint", "a"], "'--checkpoint'"),
        (&["rendr", "scene.xml"], "'render'"),
        (&["render", "scene.xml", "--sampler", "prodct"], "did you mean product?"),
        (&["render", "scene.xml", "--sampler", "Quadtree"], "did you mean quadtree?"),
        (&["render", "scene.xml", "--learner", "sara"], "did you mean sarsa?"),
        (&["render", "scene.xml", "--tone", "sgrb"], "'srgb'"),
    ] {
        assert_sentence(&folder.run(arguments), 2, &[meant, "--help"]);
    }
    // A text that is similar to no word is not guessed at.
    let output = folder.run(&["render", "scene.xml", "--sampler", "xyz"]);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("did you mean"));
}

#[test]
fn names_of_other_renderers_are_explained() {
    let folder = Folder::new();
    for (arguments, words) in [
        (&["render", "scene.xml", "--samples", "4"][..], "--spp sets the samples per pixel"),
        (&["render", "scene.xml", "--resolution", "4"], "--width sets the width of the picture in pixels"),
        (&["render", "scene.xml", "--threads", "4"], "LP_NUM_THREADS"),
        (&["render", "scene.xml", "--animation=1"], "--frames sets the frames to render"),
        (&["render", "scene.xml", "--spp", "1k"], "give a whole number"),
        (&["render", "scene.xml", "--width", "1920x1080"], "the width and the height, 1920 and 1080, are two options"),
        (&["render", "--view", "scene.xml"], "name the scene before --view"),
        (&["scene.xml"], "`lodestar render scene.xml` renders a scene"),
        (&["merge", "a.exr", "-o", "b.exr"], "name two files or more"),
        (
            &["merge"],
            "--output C.exr and A.exr A.exr... are missing; write lodestar merge --output C.exr A.exr A.exr...",
        ),
        (&["merge", "a.exr", "b.exr"], "--output C.exr is missing"),
        (&["compare", "a.exr"], "name two files or more"),
    ] {
        assert_sentence(&folder.run(arguments), 2, &[words, "--help"]);
    }
}

/// Files of other kinds are told by their extensions, or else by their content.
#[test]
fn what_is_no_scene_is_told() {
    let folder = Folder::new();
    for (name, words) in [
        (
            "a.blend",
            "a file of Blender, not a scene in Mitsuba's XML (.xml), glTF 2.0 (.gltf, .glb), USD (.usd, .usda, .usdc, .usdz) or pbrt-v4 (.pbrt)",
        ),
        ("a.obj", "name it in a <shape>"),
        ("a.FBX", "export it as glTF 2.0"),
        ("a.USDC", "it is no USD file"),
        ("a.zip", "unpack it"),
        ("a.exr", "it is a picture"),
        ("a.ckpt", "`lodestar resume`"),
        ("a.txt", "it is no XML; a scene is a file in Mitsuba's XML (.xml)"),
    ] {
        folder.write(name, "v 0 0 0\n");
        assert_sentence(&folder.run(&["render", name]), 1, &[name, words]);
        assert_sentence(&folder.run(&["info", name]), 1, &[name, words]);
    }
    fs::write(folder.path("a.dat"), [0, 0xff, 0, 0xfe]).unwrap();
    assert_sentence(&folder.run(&["info", "a.dat"]), 1, &["a.dat", "it is no text; a scene is a file in Mitsuba's"]);
    assert_sentence(&folder.run(&["info", "missing.obj"]), 1, &["missing.obj", "cannot be read"]);
}

#[test]
fn a_scene_without_light_is_told() {
    let folder = Folder::new();
    let dark = "<scene version=\"3.0.0\"><shape type=\"sphere\"/></scene>";
    folder.write("dark.xml", dark);
    folder.write("dark.pbrt", "Camera \"perspective\"\nWorldBegin\nShape \"sphere\"\n");
    for scene in ["dark.xml", "dark.pbrt"] {
        let output = folder.run(&["info", scene]);
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(said.contains("the scene has no light, so the picture is black"), "{said}");
    }
}

#[test]
fn what_was_written_is_told() {
    let folder = Folder::new();
    let said = |arguments: &[&str]| {
        let output = folder.run(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(said(&["convert", "scene.xml", "new.xml"]).contains("wrote new.xml"));
    folder.render(&[&TINY[..], &["--sample-offset", "0", "-o", "a.exr"]].concat());
    folder.render(&[&TINY[..], &["--sample-offset", "1", "-o", "b.exr"]].concat());
    assert_eq!(said(&["merge", "a.exr", "b.exr", "-o", "c.exr"]), "wrote c.exr\n");
    let rendered = said(&[&["render", "scene.xml"], &TINY[..], &["--reference", "a.exr", "-o", "d.exr"]].concat());
    assert!(rendered.contains("against the reference: MAE 0.0000, relMSE 0.0000, mean 1.0000"), "{rendered}");
}

/// The scene's new place is asked for by the name of the option.
#[test]
fn a_moved_scene_is_asked_for() {
    let folder = Folder::new();
    folder.render(&[&TINY[..], &["--checkpoint", "a.ckpt", "-o", "a.png"]].concat());
    fs::rename(folder.path("scene.xml"), folder.path("moved.xml")).unwrap();
    let resumed = ["resume", "a.ckpt", "--spp", "2"];
    assert_sentence(&folder.run(&resumed), 1, &["scene.xml", "is not there; name its new place with --scene"]);
    let output = folder.run(&[&resumed[..], &["--scene", "moved.xml"]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.ends_with("/a.png\n") && !said.contains("-o NAME"), "{said}");
}

#[test]
fn one_side_of_the_film_keeps_the_aspect_ratio() {
    let folder = Folder::new();
    for (arguments, size) in [
        (&["--width", "32"][..], (32, 24)),
        (&["--height", "6"], (8, 6)),
        (&["--width", "5"], (5, 4)),
        (&["--height", "1"], (1, 1)),
        (&["--width", "7", "--height", "9"], (7, 9)),
    ] {
        folder.render(&[&TINY[..4], arguments, &["-o", "a.exr"]].concat());
        let image = read_rgb(&folder.path("a.exr")).unwrap();
        assert_eq!((image.width, image.height), size, "{arguments:?}");
    }
}

#[test]
fn extensions_have_any_case() {
    let folder = Folder::new();
    folder.render(&[&TINY[..], &["-o", "a.PNG", "-o", "b.Exr"]].concat());
    assert!(fs::read(folder.path("a.PNG")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(read_rgb(&folder.path("b.Exr")).unwrap().width, 8);
}

#[test]
fn times_have_units() {
    let folder = Folder::new();
    let times = ["--time", "1h", "--write-every", "1m30s", "--checkpoint", "a.ckpt", "--checkpoint-every", "2m"];
    folder.render(&[&TINY[..], &times].concat());
    for time in ["1m30", "30s1m", "soon"] {
        assert_sentence(&folder.run(&["render", "scene.xml", "--time", time]), 2, &["--time", time, "1m30s"]);
    }
}

#[test]
fn a_folder_stands_for_the_scene_in_it() {
    let folder = Folder::new();
    fs::create_dir_all(folder.path("hall")).unwrap();
    fs::create_dir_all(folder.path("empty")).unwrap();
    fs::rename(folder.path("scene.xml"), folder.path("hall/scene.xml")).unwrap();
    let output = folder.run(&[&["render", "hall"][..], &TINY].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("hall is a folder; its hall/scene.xml is rendered\n"), "{said}");
    assert_eq!(folder.names(), ["hall.exr", "hall/scene.xml"]);
    let words = ["empty: it is a folder without a scene.xml"];
    assert_sentence(&folder.run(&["render", "empty"]), 1, &words);
    assert_sentence(&folder.run(&["radiance", "empty", "--pixel", "1,1", "-o", "a.exr"]), 1, &words);
}

/// The folder is not made: it may be the place of a disk that is not there.
#[test]
fn a_missing_folder_is_named_before_the_scene_is_read() {
    let folder = Folder::new();
    let words = ["out/today/a.exr: cannot be written: ", "no folder `out/today`", "mkdir -p out/today"];
    assert_sentence(&folder.run(&["render", "missing.xml", "-o", "out/today/a.exr"]), 1, &words);
    assert_eq!(folder.names(), ["scene.xml"]);
}

#[test]
fn standard_output_is_no_picture() {
    let folder = Folder::new();
    let words = ["no picture goes to standard output", ".exr, .png, .jpg, .tif or .hdr"];
    assert_sentence(&folder.run(&["render", "scene.xml", "-o", "-"]), 2, &words);
}

#[test]
fn the_end_says_where_the_picture_went() {
    let folder = Folder::new();
    let lines = |arguments: &[&str]| {
        let output = folder.run(&[&["render", "scene.xml"], &TINY[..], arguments].concat());
        assert!(output.status.success() && output.stdout.is_empty());
        let said = String::from_utf8(output.stderr).unwrap();
        said.lines().filter(|line| line.starts_with("wrote ")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(lines(&["-o", "a.exr", "-o", "b.png", "--write-every", "1e-6"]), ["wrote a.exr", "wrote b.png"]);
    let default = lines(&[]);
    assert!(default.len() == 1 && default[0].ends_with(".exr; -o NAME.png writes a picture for any viewer"));
    assert_eq!(lines(&["--quiet"]), [""; 0]);
}

#[test]
fn an_unmet_noise_target_is_said() {
    let folder = Folder::new();
    let said = |noise: &str| {
        let output = folder.run(&["render", "scene.xml", "--noise", noise, "--spp", "64", "-o", "a.exr"]);
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(said("0.0001").contains("\n--noise 0.0001 was not reached: noise up to "));
    assert!(!said("0.5").contains("was not reached"));
}

/// A picture is replaced by one of the same scene, edited or moved, but not by another scene's.
#[test]
fn another_scenes_picture_is_not_replaced_in_silence() {
    let folder = Folder::new();
    fs::create_dir(folder.path("other")).unwrap();
    let run = |scene: &str, more: &[&str]| {
        folder.run(&[&["render", scene, "--quiet", "-o", "a.exr"], &TINY[..], more].concat())
    };
    assert_quiet_success(&run("scene.xml", &[]));
    let other = SCENE.replace("z=\"5\"", "z=\"6\"");
    folder.write("other/scene.xml", &other);
    let before = fs::read(folder.path("a.exr")).unwrap();
    let words = ["a.exr: it is a picture of another scene, ", "scene.xml", "-o", "--overwrite"];
    assert_sentence(&run("other/scene.xml", &[]), 1, &words);
    assert!(fs::read(folder.path("a.exr")).unwrap() == before);
    // The scene may be edited, changed on the command line, or copied.
    folder.write("scene.xml", &other);
    assert_quiet_success(&run("scene.xml", &[]));
    assert_quiet_success(&run("scene.xml", &["-D", "gray=0.25"]));
    assert_quiet_success(&run("scene.xml", &[]));
    assert_quiet_success(&run("other/scene.xml", &[]));
    folder.write("other/scene.xml", SCENE);
    folder.write("third.xml", SCENE);
    assert_quiet_success(&run("other/scene.xml", &[]));
    folder.write("third.xml", &other);
    assert_sentence(&run("third.xml", &[]), 1, &words);
    assert_quiet_success(&run("third.xml", &["--overwrite"]));
    assert!(attribute(&folder.path("a.exr"), "scene").ends_with("third.xml"));
    // A file that no render has written is replaced, as any program does.
    folder.write("a.exr", "notes");
    assert_quiet_success(&run("scene.xml", &[]));
}
