//! Invalid input of any kind: one sentence, exit code 1 (2 for usage), and no file.

use std::fs;
use std::process::Output;

use crate::support::{Folder, SCENE, assert_sentence};

/// Runs the program without any driver, so that only errors found before the device is opened are reported.
fn run_without_driver(folder: &Folder, arguments: &[&str]) -> Output {
    let mut command = folder.command(arguments);
    command.env("VK_DRIVER_FILES", "/nonexistent").env_remove("VK_ICD_FILENAMES").output().unwrap()
}

/// Fails unless `render scene.xml` with `arguments` is refused with `code` and `words`, and leaves no file.
#[track_caller]
fn refuse(folder: &Folder, arguments: &[&str], code: i32, words: &[&str]) {
    let before = folder.names();
    let output = run_without_driver(folder, &[&["render", "scene.xml", "--stats", "s.json"], arguments].concat());
    assert_sentence(&output, code, words);
    assert_eq!(folder.names(), before);
}

/// Fails unless the scene with `old` replaced by `new` is refused with `words`.
#[track_caller]
fn refuse_scene(old: &str, new: &str, words: &[&str]) {
    assert!(SCENE.contains(old));
    let folder = Folder::new();
    folder.write("scene.xml", &SCENE.replace(old, new));
    refuse(&folder, &[], 1, words);
}

#[test]
fn a_scene_that_is_no_whole_scene() {
    let folder = Folder::new();
    for length in (0..SCENE.trim_end().len()).step_by(17) {
        folder.write("scene.xml", &SCENE[..length]);
        refuse(&folder, &[], 1, &["scene.xml"]);
    }
    let output = run_without_driver(&folder, &["render", "missing.xml"]);
    assert_sentence(&output, 1, &["missing.xml: cannot be read"]);
    fs::write(folder.path("scene.xml"), [0xff, 0xfe, 0, 0x80]).unwrap();
    refuse(&folder, &[], 1, &["scene.xml"]);
}

/// A film of 2^32 pixels is refused before anything is allocated or rendered.
#[test]
fn what_memory_cannot_hold_is_refused_before_anything_is_rendered() {
    let folder = Folder::new();
    folder.write("a.exr", "earlier");
    let size = ["--width", "65536", "--height", "65536"];
    let files = ["-o", "a.exr", "--checkpoint", "a.ckpt", "--stats", "s.json"];
    let output = folder.run(&[&["render", "scene.xml", "--quiet"], &size[..], &files].concat());
    let words = ["the render needs ", " of memory, but ", "the film 275 GB (smaller with --width", "--crop"];
    assert_sentence(&output, 1, &words);
    assert_eq!(fs::read(folder.path("a.exr")).unwrap(), b"earlier");
    assert_eq!(folder.names(), ["a.exr", "scene.xml"]);
}

#[test]
fn a_scene_that_asks_for_what_there_is_not() {
    refuse_scene(r#"type="diffuse""#, r#"type="velvet""#, &["scene.xml:14: ", "bsdf plugin `velvet`"]);
    refuse_scene(r#"type="cube""#, r#"type="teapot""#, &["scene.xml:12: ", "shape plugin `teapot`"]);
    refuse_scene(r#"type="path""#, r#"type="depth""#, &["scene.xml:3: ", "integrator plugin `depth`"]);
    refuse_scene(r#"name="width" value="16""#, r#"name="width" value="0""#, &["scene.xml:", "`width`", "not 0"]);
    refuse_scene(r#"name="width" value="16""#, r#"name="width" value="99999999""#, &["width", "99999999"]);
    refuse_scene("$gray", "$grey", &["scene.xml:14: ", "$grey", "-D grey=VALUE"]);
    let folder = Folder::new();
    folder.write("scene.xml", "<scene version=\"3.0.0\"/>");
    refuse(&folder, &[], 1, &["scene.xml", "neither a <sensor> nor a shape"]);
}

#[test]
fn a_mesh_that_is_none() {
    let folder = Folder::new();
    let file = r#"type="obj"><string name="filename" value="mesh.obj"/>"#;
    folder.write("scene.xml", &SCENE.replace(r#"type="cube">"#, file));
    refuse(&folder, &[], 1, &["scene.xml:12: ", "mesh.obj"]);
    folder.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    refuse(&folder, &[], 1, &["mesh.obj:4: ", "index 4"]);
    folder.write("mesh.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
    refuse(&folder, &[], 1, &["mesh.obj:2: ", "nan"]);
}

#[test]
fn an_output_that_cannot_be_written_is_known_before_the_device_is_opened() {
    let folder = Folder::new();
    folder.write("file", "");
    fs::create_dir(folder.path("folder.exr")).unwrap();
    for output in ["missing/a.exr", "missing/a.png", "file/a.exr", "folder.exr"] {
        refuse(&folder, &["-o", "good.exr", "-o", output], 1, &[&format!("{output}: cannot be written: ")]);
    }
    for stats in ["missing/s.json", "folder.exr"] {
        let output = run_without_driver(&folder, &["render", "scene.xml", "--stats", stats]);
        assert_sentence(&output, 1, &[&format!("{stats}: cannot be written: ")]);
    }
    assert_eq!(folder.names(), ["file", "scene.xml"]);
}

#[test]
fn a_reference_that_is_none() {
    let folder = Folder::new();
    refuse(&folder, &["--reference", "missing.exr"], 1, &["missing.exr: cannot be read"]);
    refuse(&folder, &["--reference", "a.png"], 1, &["a.png: a reference is an EXR picture, whose colors are linear"]);
    folder.write("text.exr", "no picture");
    refuse(&folder, &["--reference", "text.exr"], 1, &["text.exr: it is not a whole EXR image"]);
    crate::compare::write_row(&folder.path("row.exr"), 16, 1.0);
    refuse(&folder, &["--reference", "row.exr"], 1, &["row.exr", "16 x 1", "16 x 12"]);
    crate::compare::write_row(&folder.path("nan.exr"), 16, f32::NAN);
    refuse(&folder, &["--reference", "nan.exr"], 1, &["nan.exr", "not a number"]);
}

#[test]
fn settings_out_of_their_ranges() {
    let folder = Folder::new();
    for (option, value) in [
        ("--grid", "0"),
        ("--grid", "33"),
        ("--fallback", "-1"),
        ("--noise", "0"),
        ("--noise", "nan"),
        ("--directions", "3"),
        ("--normals", "3"),
        ("--decay", "2"),
        ("--decay", "-1"),
        ("--decay", "NaN"),
        ("--min-uniform", "0"),
        ("--max-tries", "0"),
        ("--spp-per-step", "0"),
        ("--samples-per-dispatch", "65"),
        ("--rr-depth", "0"),
        ("--max-depth", "1025"),
        ("--slice-ms", "1e300"),
        ("--epsilon", "0"),
        ("--epsilon", "1.5"),
        ("--expected-directions", "0"),
    ] {
        refuse(&folder, &[option, value], 1, &[option, "must lie between"]);
    }
    for crop in ["16,0,1,1", "0,0,17,1", "0,0,1,13", "4294967295,0,1,1"] {
        refuse(&folder, &["--crop", crop], 1, &["crop", crop, "16 x 12"]);
    }
    refuse(&folder, &["-D", "grey=1"], 1, &["scene.xml", "-D grey"]);
}

#[test]
fn combinations_without_meaning() {
    let folder = Folder::new();
    for (arguments, words) in [
        (
            &["--sampler", "rejection", "--epsilon", "0.5"][..],
            ["--epsilon", "the samplers rejection-mix and product only; the sampler here is rejection"],
        ),
        (
            &["--sampler", "quadtree", "--learner", "sarsa"],
            ["--learner sarsa cannot be combined with --sampler quadtree", "monte-carlo only"],
        ),
        (&["--directions", "8"], ["--directions must be 16, 32 or 64", "but it is 8"]),
        (&["--noise", "0.1", "--sample-offset", "0"], ["--noise", "cannot be combined with --sample-offset"]),
        (&["--noise", "0.1", "--execution", "wavefront"], ["--execution wavefront", "cannot be combined with --noise"]),
        (
            &["--sampler", "quadtree", "--execution", "wavefront"],
            ["--execution wavefront cannot be combined with --sampler quadtree", "take --execution megakernel"],
        ),
        (
            &["--learner", "monte-carlo", "--execution", "wavefront"],
            ["--execution wavefront cannot be combined with --learner monte-carlo", "take --execution megakernel"],
        ),
        (
            &["--sampler", "bsdf", "--roulette", "contribution"],
            ["--roulette contribution", "product only; the sampler here is bsdf"],
        ),
        (
            &["--sampler", "bsdf", "--sample-weights", "growing"],
            ["--sample-weights growing", "the sampler here is bsdf"],
        ),
        (
            &["--sample-offset", "0", "--sample-weights", "growing"],
            ["--sample-weights growing", "cannot be combined with --sample-offset"],
        ),
        (
            &["--noise", "0.1", "--sample-weights", "growing"],
            ["--sample-weights growing", "cannot be combined with --noise"],
        ),
        (&["--sampler", "bsdf", "--bsdf-share", "fixed"], ["--bsdf-share", "product only; the sampler here is bsdf"]),
        (
            &["--epsilon", "0.5", "--bsdf-share", "learned"],
            ["--bsdf-share learned", "cannot be combined with --epsilon"],
        ),
        (
            &["--learner", "monte-carlo", "--bsdf-share", "learned"],
            ["--bsdf-share learned", "cannot be combined with --learner monte-carlo"],
        ),
        (
            &["--sampler", "sphere-inversion", "--mix", "acceptance"],
            ["--mix acceptance", "rejection-mix only; the sampler here is sphere-inversion"],
        ),
        (
            &["--sampler", "bsdf", "--learner", "monte-carlo"],
            ["--learner monte-carlo is used by the samplers", "the sampler here is bsdf"],
        ),
        (&["--expected-directions", "64"], ["--expected-directions", "expected-sarsa only; the learner here is sarsa"]),
    ] {
        refuse(&folder, arguments, 1, &words);
    }
}

#[test]
fn options_given_in_vain() {
    let folder = Folder::new();
    let cells = "product, rejection, rejection-mix, sphere-inversion and hemisphere-inversion only";
    let guided = "product, rejection, rejection-mix, sphere-inversion, hemisphere-inversion and quadtree only";
    let by_rejection = "rejection and rejection-mix only";
    for (sampler, option, value, of) in [
        ("bsdf", "--learner", "sarsa", guided),
        ("bsdf", "--guide-set", "all", guided),
        ("bsdf", "--map", "equal-area", guided),
        ("bsdf", "--grid", "8", guided),
        ("bsdf", "--directions", "16", guided),
        ("bsdf", "--fallback", "4", cells),
        ("quadtree", "--decay", "0.9", cells),
        ("quadtree", "--steps", "growing", cells),
        ("sphere-inversion", "--normals", "8", "product, rejection, rejection-mix and hemisphere-inversion only"),
        ("product", "--mix", "density", "the sampler rejection-mix only"),
        ("product", "--max-tries", "15", by_rejection),
        ("hemisphere-inversion", "--max-tries", "31", by_rejection),
        (
            "product",
            "--min-uniform",
            "0.25",
            "rejection, rejection-mix, sphere-inversion and hemisphere-inversion only",
        ),
        ("rejection", "--expected-directions", "128", "the learner expected-sarsa only; the learner here is sarsa"),
    ] {
        let is_here = match option {
            "--expected-directions" => "the learner here is sarsa".to_owned(),
            _ => format!("the sampler here is {sampler}"),
        };
        refuse(&folder, &["--sampler", sampler, option, value], 1, &[option, "is used by the", of, &is_here]);
    }
    let fixed_share = ["--sampler", "rejection-mix", "--epsilon", "0.5", "--min-uniform", "0.1"];
    refuse(
        &folder,
        &fixed_share,
        1,
        &["--min-uniform cannot be combined with --epsilon", "which fixes the share of mixed densities"],
    );
    let output = folder.run(&["inspect", "trace", "--sampler", "product", "--max-tries", "15"]);
    assert_sentence(&output, 1, &["--max-tries", by_rejection]);
}

/// Valid options are accepted: the only error is that there is no device.
#[test]
fn options_of_use_and_those_that_ask_for_nothing_are_taken() {
    let folder = Folder::new();
    for arguments in [
        "bsdf --fallback 0 --steps even --spp-per-step 4 --roulette throughput",
        "rejection-mix --mix density --max-tries 15 --min-uniform 0.25 --normals 8 --decay 1 --steps growing",
        "rejection-mix --mix acceptance --epsilon 0.5 --min-uniform 0.25",
        "rejection --max-tries 31 --min-uniform 0.25 --learner expected-sarsa --expected-directions 128",
        "sphere-inversion --min-uniform 0.25 --map cylindrical --fallback 4",
        "hemisphere-inversion --min-uniform 0.25 --normals 8 --fallback 4",
        "product --grid auto --fallback 4 --normals 8 --decay 0.9 --epsilon 0.5",
        "quadtree --grid 4 --directions 8 --map cylindrical --guide-set diffuse --learner monte-carlo --steps even",
    ] {
        let arguments: Vec<_> = ["--sampler"].into_iter().chain(arguments.split(' ')).collect();
        refuse(&folder, &arguments, 1, &["no Vulkan driver"]);
    }
}

#[test]
fn wrong_usage_exits_with_2() {
    let folder = Folder::new();
    for (arguments, word) in [
        (&["--width", "0", "--height", "4"][..], "--width"),
        (&["--scale", "2", "--width", "4", "--height", "4"], "--scale"),
        (&["--spp", "0"], "--spp"),
        (&["--spp", "many"], "--spp"),
        (&["--time", "-1"], "--time"),
        (&["--write-every", "-1"], "--write-every"),
        (&["--scale", "-1"], "--scale"),
        (&["--crop", "1,2,3"], "--crop"),
        (&["--crop", "-1,2,3,4"], "--crop"),
        (&["-D", "gray"], "-D"),
        (&["-o", "picture.gif"], ".exr, .png, .jpg, .tif or .hdr"),
        (&["--sampler", "magic"], "bsdf, rejection-mix"),
        (&["--fast"], "--fast"),
        (&["--seed"], "--seed"),
        (&["another.xml"], "another.xml"),
    ] {
        refuse(&folder, arguments, 2, &[word]);
    }
    for (arguments, word) in
        [(&["render"][..], "SCENE"), (&["fly"], "fly"), (&["compare", "a.exr"], "REF.exr"), (&["devices", "x"], "x")]
    {
        assert_sentence(&folder.run(arguments), 2, &[word, "--help"]);
    }
    let output = folder.run(&[]);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0));
    assert!(String::from_utf8_lossy(&output.stderr).contains("Usage: lodestar <COMMAND>"));
}

#[test]
fn no_vulkan_driver() {
    let folder = Folder::new();
    let words = ["no Vulkan driver", "VK_DRIVER_FILES"];
    refuse(&folder, &[], 1, &words);
    refuse(&folder, &["--device", "0"], 1, &words);
    refuse(&folder, &[], 1, &["`lodestar devices` says more"]);
    let advice = [&words[..], &["VK_DRIVER_FILES is `/nonexistent`", "unset it"]].concat();
    assert_sentence(&run_without_driver(&folder, &["devices"]), 1, &advice);
    // The same advice is in the JSON.
    let output = run_without_driver(&folder, &["devices", "--json"]);
    let survey: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((output.status.code(), survey["devices"].as_array().map(Vec::len)), (Some(1), Some(0)));
    let sentences = survey["advice"].to_string();
    assert!(survey["default"].is_null() && advice.iter().all(|word| sentences.contains(word)), "{survey}");
}
