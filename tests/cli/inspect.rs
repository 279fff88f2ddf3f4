//! Subcommand `lodestar inspect`.

use std::process::{Command, Output};

use serde_json::Value;

use crate::support::{Folder, assert_sentence, keys};

fn has_spirv_tools() -> bool {
    let has =
        ["spirv-dis", "spirv-opt", "spirv-val"].iter().all(|tool| Command::new(tool).arg("--version").output().is_ok());
    if !has {
        eprintln!("SPIRV-Tools are not installed: the variant is not looked at");
    }
    has
}

/// Report without the variant, which takes most of the time.
fn inspect(folder: &Folder, arguments: &[&str]) -> Value {
    json(&folder.without_tools(&[&["inspect", "--json"], arguments].concat()))
}

fn json(output: &Output) -> Value {
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn text(folder: &Folder, arguments: &[&str]) -> String {
    let output = folder.without_tools(&[&["inspect"], arguments].concat());
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Report about the tracing kernel that reads texel buffers.
fn trace(folder: &Folder, arguments: &[&str]) -> Value {
    inspect(folder, &[&["trace", "--back-end", "texel"], arguments].concat())["kernels"][0].clone()
}

/// Report about the tracing kernel with the variant, where SPIRV-Tools are installed.
fn trace_with_variant(folder: &Folder, arguments: &[&str]) -> Value {
    let output = folder.run(&[&["inspect", "--json", "trace", "--back-end", "texel"], arguments].concat());
    json(&output)["kernels"][0].clone()
}

fn constant(kernel: &Value, name: &str) -> Value {
    let constants = kernel["interface"]["constants"].as_array().unwrap();
    constants.iter().find(|constant| constant["name"] == name).unwrap_or_else(|| panic!("no {name}"))["value"].clone()
}

fn instructions(histogram: &Value) -> u64 {
    histogram["total"]["instructions"].as_u64().unwrap()
}

/// Number of instructions that come from a GLSL file.
fn instructions_of(histogram: &Value, file: &str) -> u64 {
    let lines = histogram["lines"].as_array().unwrap().iter().filter(|line| line["file"] == file);
    lines.map(|line| line["total"]["instructions"].as_u64().unwrap()).sum()
}

#[test]
fn every_kernel_is_there_for_all_back_ends() {
    let folder = Folder::new();
    let report = inspect(&folder, &[]);
    let kernels = report["kernels"].as_array().unwrap();
    let of = |file: &str| kernels.iter().find(|kernel| kernel["file"] == file).unwrap_or_else(|| panic!("no {file}"));
    assert_eq!(of("trace.texel.spv")["back_ends"], serde_json::json!(["texel"]));
    assert_eq!(of("trace.spv")["back_ends"], serde_json::json!(["storage"]));
    assert_eq!(of("trace.query.spv")["back_ends"], serde_json::json!(["query"]));
    assert_eq!(of("wave_shade.spv")["back_ends"], serde_json::json!(["storage", "query"]));
    assert_eq!(of("update_radiance.spv")["back_ends"], serde_json::json!(["texel", "storage", "query"]));
    for kernel in kernels {
        assert_eq!(
            keys(kernel),
            [
                "back_ends",
                "disassembly",
                "file",
                "histogram",
                "interface",
                "name",
                "notes",
                "pipeline",
                "specialized",
                "spirv_bytes"
            ]
        );
        let interface = &kernel["interface"];
        assert_eq!((&interface["entry_point"], &interface["workgroup_size"][0]["value"]), (&"main".into(), &64.into()));
        assert!(kernel["disassembly"].as_str().unwrap().contains("OpEntryPoint GLCompute"), "{}", kernel["file"]);
        assert!(kernel["pipeline"].is_null());
    }
}

#[test]
fn layouts_are_those_of_the_glsl() {
    let folder = Folder::new();
    let kernel = trace(&folder, &[]);
    let bindings = kernel["interface"]["bindings"].as_array().unwrap();
    let scene = bindings.iter().find(|binding| binding["name"] == "Scene").unwrap();
    assert_eq!((&scene["set"], &scene["binding"], &scene["kind"]), (&0.into(), &2.into(), &"uniform buffer".into()));
    let member = &scene["layout"]["members"][0];
    assert_eq!(member["members"][0]["type"], "vec4[3]");
    assert_eq!((&member["members"][0]["stride"], &member["members"][1]["offset"]), (&16.into(), &48.into()));
    // `layout.rs` is checked against the same reflection when the crate is compiled.
    assert_eq!(member["bytes"], size_of::<lodestar::generated::layout::SceneConstants>());
    assert_eq!(kernel["interface"]["push_constants"]["bytes"], size_of::<lodestar::generated::layout::TracePush>());
}

#[test]
fn options_choose_the_variant() {
    let folder = Folder::new();
    let plain = trace_with_variant(&folder, &["--sampler", "bsdf", "--max-depth", "3", "--rfilter", "gaussian"]);
    let guided = trace_with_variant(&folder, &["--sampler", "rejection-mix", "--directions", "8"]);
    assert_eq!((constant(&plain, "SAMPLER"), constant(&guided, "SAMPLER")), (0.into(), 1.into()));
    assert_eq!((constant(&plain, "MAX_DEPTH"), constant(&plain, "FILTER_WIDTH")), (3.into(), 0.5.into()));
    assert_eq!(
        (constant(&guided, "DIRECTION_RESOLUTION"), constant(&guided, "HIDE_EMITTERS")),
        (8.into(), false.into())
    );
    if !has_spirv_tools() {
        return;
    }
    let (plain, guided) = (&plain["specialized"]["histogram"], &guided["specialized"]["histogram"]);
    let rejection = "glsl/include/guide/samplers/rejection_mix.glsl";
    assert_eq!(instructions_of(plain, rejection), 0);
    assert!(instructions_of(guided, rejection) > 20);
    assert!(instructions(plain) < instructions(guided), "{} and {}", instructions(plain), instructions(guided));
}

#[test]
fn a_scene_chooses_what_scenes_do() {
    let folder = Folder::new();
    folder.write("sphere.xml", &crate::support::SCENE.replace("\"cube\"", "\"sphere\""));
    let [cube, sphere] = ["scene.xml", "sphere.xml"].map(|scene| trace(&folder, &["--scene", scene]));
    assert_eq!([&cube, &sphere].map(|kernel| constant(kernel, "HAS_SPHERES")), [false, true]);
    assert_ne!(constant(&cube, "LIGHT_KINDS"), 0);
    let nee = |arguments| constant(&trace(&folder, arguments), "NEE");
    assert_eq!((nee(&["--scene", "scene.xml", "--nee", "on"]), nee(&["--nee", "off"])), (true.into(), false.into()));
}

#[test]
fn counts_add_up() {
    let folder = Folder::new();
    let histogram = &trace(&folder, &[])["histogram"];
    let sum =
        |of: &Value| of.as_object().unwrap().values().map(|count| count["instructions"].as_u64().unwrap()).sum::<u64>();
    let operations = histogram["operations"].as_object().unwrap();
    assert_eq!(sum(&histogram["classes"]), instructions(histogram));
    assert_eq!(operations.values().map(|count| count.as_u64().unwrap()).sum::<u64>(), instructions(histogram));
    for class in ["texel_fetch", "atomic", "branch", "loop", "float", "division", "root", "store_buffer"] {
        assert!(histogram["classes"][class]["instructions"].as_u64().unwrap_or(0) > 0, "no {class}");
    }
    assert_eq!(histogram["classes"]["texel_fetch"]["instructions"], operations["ImageFetch"]);
    let lines = histogram["lines"].as_array().unwrap();
    let fetch = lines.iter().find(|line| line["text"].as_str().unwrap().contains("texelFetch(bvh_nodes")).unwrap();
    assert!(
        fetch["file"] == "glsl/include/geometry/bvh.glsl" && fetch["classes"]["texel_fetch"].is_object(),
        "{fetch}"
    );
}

#[test]
fn without_spirv_tools_the_rest_is_shown() {
    let folder = Folder::new();
    let output = folder.without_tools(&["inspect", "trace"]);
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("note: the variant is not shown: install SPIRV-Tools"), "{said}");
    assert!(said.contains("texel fetches") && said.contains("FilmRadiance[] film_radiance"), "{said}");
    let output = folder.without_tools(&["inspect", "trace", "--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let kernel = &report["kernels"][0];
    assert!(kernel["specialized"].is_null() && kernel["disassembly"].as_str().unwrap().contains("OpImageFetch"));
}

#[test]
fn the_text_names_what_a_tuner_asks_for() {
    let folder = Folder::new();
    let said = text(&folder, &["trace", "--lines", "3"]);
    let push = format!("push constants: {} bytes", size_of::<lodestar::generated::layout::TracePush>());
    for words in ["workgroup 64 (constant 0) x 1 x 1", &push, "MAX_TRIES", "atomics", "transcendental"] {
        let known = if words == "transcendental" { "sin, exp, log, pow" } else { words };
        assert!(said.contains(known), "{known} is missing:\n{said}");
    }
}

#[test]
fn a_driver_that_tells_nothing_is_no_fault() {
    let folder = Folder::new();
    let devices = folder.run(&["devices", "--json"]);
    let devices: Value = serde_json::from_slice(&devices.stdout).unwrap();
    let usable =
        devices["devices"].as_array().unwrap().iter().find(|device| device["refused"].is_null()).expect("a device");
    let index = usable["index"].to_string();
    let pipeline = &trace(&folder, &["--device", &index])["pipeline"];
    assert!(pipeline["creation_seconds"].as_f64().unwrap() > 0.0);
    let said = text(&folder, &["trace", "--device", &index]);
    match &pipeline["executables"] {
        Value::Null => assert!(said.contains("lacks VK_KHR_pipeline_executable_properties"), "{said}"),
        executables => check_executables(executables),
    }
}

fn check_executables(executables: &Value) {
    let all = executables.as_array().unwrap();
    assert!(!all.is_empty());
    for executable in all {
        assert!(!executable["name"].as_str().unwrap().is_empty());
        assert!(executable["statistics"].as_array().unwrap().iter().all(|statistic| !statistic["value"].is_null()));
    }
}

/// Statistics of a driver are quoted. Mesa's driver of AMD GPUs compiles for hardware that is absent and reports
/// everything.
#[test]
fn a_driver_that_tells_much_is_quoted() {
    let folder = Folder::new();
    let run = |arguments: &[&str]| folder.command(arguments).env("RADV_FORCE_FAMILY", "navi21").output().unwrap();
    let devices: Value = serde_json::from_slice(&run(&["devices", "--json"]).stdout).unwrap();
    let null = devices["devices"]
        .as_array()
        .unwrap()
        .iter()
        .find(|device| device["name"].to_string().contains("Null hardware"));
    let Some(null) = null.filter(|device| device["refused"].is_null()) else {
        eprintln!("no driver here compiles for hardware that is absent: nothing is tested");
        return;
    };
    let index = null["index"].to_string();
    let output = run(&["inspect", "trace", "--back-end", "texel", "--device", &index, "--json", "--out", "out"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let executables = &report["kernels"][0]["pipeline"]["executables"];
    check_executables(executables);
    let statistics = executables[0]["statistics"].as_array().unwrap();
    let registers = statistics.iter().find(|statistic| statistic["name"] == "VGPRs").expect("a count of registers");
    assert!(registers["value"].as_u64().unwrap() > 8, "{registers}");
    let names = folder.names();
    assert!(names.contains(&"out/device/trace.texel.Compute-Shader.Assembly.txt".to_owned()), "{names:?}");
    let assembly = std::fs::read_to_string(folder.path("out/device/trace.texel.Compute-Shader.Assembly.txt")).unwrap();
    assert!(assembly.contains("s_endpgm"), "the whole text, to its end");
}

#[test]
fn wrong_wishes_are_refused() {
    let folder = Folder::new();
    assert_sentence(
        &folder.run(&["inspect", "path_tracer"]),
        1,
        &["`path_tracer`", "pool_radiance, refine_quadtrees, trace, update_"],
    );
    assert_sentence(&folder.run(&["inspect", "--grid", "99"]), 1, &["--grid is 99"]);
    assert_sentence(&folder.run(&["inspect", "--device", "voodoo"]), 1, &["`voodoo`"]);
    assert_sentence(&folder.run(&["inspect", "--scene", "none.xml"]), 1, &["none.xml"]);
    assert_sentence(&folder.run(&["inspect", "update_radiance", "--out", "scene.xml"]), 1, &["scene.xml"]);
}
