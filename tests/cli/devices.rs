//! Subcommand `lodestar devices`, and the choice of a device.

use serde_json::Value;

use crate::resume::assert_same_picture;
use crate::support::{Folder, assert_quiet_success, assert_sentence};

const TINY: [&str; 9] = ["render", "scene.xml", "--quiet", "--spp", "1", "--width", "8", "--height", "8"];

fn list(folder: &Folder) -> Vec<Value> {
    let output = folder.run(&["devices", "--json"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let survey: Value = serde_json::from_slice(&output.stdout).unwrap();
    survey["devices"].as_array().unwrap().clone()
}

/// Index and name of a usable device.
fn usable(folder: &Folder) -> (String, String) {
    let devices = list(folder);
    let device = devices.iter().find(|device| device["refused"].is_null()).expect("a device that can be used");
    (device["index"].to_string(), device["name"].as_str().unwrap().to_owned())
}

#[test]
fn the_list_names_every_device() {
    let folder = Folder::new();
    let devices = list(&folder);
    let output = folder.run(&["devices"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && output.stderr.is_empty());
    for (index, device) in devices.iter().enumerate() {
        assert_eq!(device["index"], index);
        assert!(["discrete", "integrated", "virtual", "cpu", "other"].contains(&device["kind"].as_str().unwrap()));
        let line = text.lines().find(|line| line.starts_with(&format!("{index}: "))).unwrap();
        for key in ["name", "api_version", "driver_name", "driver_info"] {
            assert!(line.contains(device[key].as_str().unwrap()), "{line} lacks {key}");
        }
        if let Some(lack) = device["refused"].as_str() {
            assert!(text.contains(&format!("cannot be used: {lack}")), "{text}");
        }
    }
}

/// Two devices get tiles by their speed, a message says how many, and the picture is that of one device.
#[test]
fn tiles_are_dealt_out_by_speed() {
    let folder = Folder::new();
    let (index, _) = usable(&folder);
    let tiny = ["render", "scene.xml", "--spp", "16", "--width", "40", "--height", "24"];
    let render = |more: &[&str]| folder.run(&[&tiny[..], more].concat());
    let two = format!("{index},{index}");
    let output = render(&["--device", &two, "--deal-by-speed", "-o", "two.exr"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && text.contains("tiles by measured speed: "), "{text}");
    assert!(render(&["--device", &index, "--deal-by-speed", "-o", "one.exr"]).status.success());
    assert_same_picture(&folder.path("two.exr"), &folder.path("one.exr"));
}

/// The device that renders without `--device` is marked, and the kinds are words.
#[test]
fn the_default_is_marked_and_advice_follows() {
    let folder = Folder::new();
    let output = folder.run(&["devices", "--json"]);
    let survey: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = String::from_utf8(folder.run(&["devices"]).stdout).unwrap();
    let default = survey["default"].to_string();
    let marked: Vec<_> = text.lines().filter(|line| line.ends_with(" - the default")).collect();
    assert!(marked.len() == 1 && marked[0].starts_with(&format!("{default}: ")), "{text}");
    assert_eq!(folder.render(&["--spp", "1"])["device"]["index"].to_string(), default);
    for device in survey["devices"].as_array().unwrap() {
        let words = if device["kind"] == "cpu" { "(CPU, Vulkan " } else { ", Vulkan " };
        assert!(text.contains(words), "{text}");
        let own = text.lines().find(|line| line.starts_with(&format!("{}: ", device["index"]))).unwrap();
        assert_eq!(own.contains(", ray queries"), device["limits"]["has_ray_queries"] == true, "{own}");
        let is_old_mesa =
            ["Mesa 22.", "Mesa 23.", "Mesa 24."].iter().any(|old| device["driver_info"].to_string().contains(old));
        if is_old_mesa && device["driver_name"] == "llvmpipe" && device["index"] == survey["default"] {
            assert!(text.contains("\nnote: the CPU renders with Mesa 2"), "{text}");
        }
    }
    for sentence in survey["advice"].as_array().unwrap() {
        assert!(text.contains(&format!("note: {}\n", sentence.as_str().unwrap())), "{text}");
    }
    let output = folder.command(&["devices"]).env("LODESTAR_DEVICE", "voodoo").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("note: no Vulkan device is called `voodoo`") && !text.contains("the default"), "{text}");
}

#[test]
fn a_device_is_chosen_by_index_or_name() {
    let folder = Folder::new();
    let (index, name) = usable(&folder);
    assert_eq!(folder.render(&["--spp", "1", "--device", &index])["device"]["name"], name.as_str());
    // The first word of the name is enough, in any case. The option takes precedence over the environment.
    let word = name.split_whitespace().next().unwrap().to_uppercase();
    if list(&folder).iter().filter(|device| device["name"].to_string().to_uppercase().contains(&word)).count() == 1 {
        let mut command = folder.command(&TINY);
        assert_quiet_success(&command.args(["--device", &word]).env("LODESTAR_DEVICE", "voodoo").output().unwrap());
    }
}

#[test]
fn the_environment_chooses_where_no_option_does() {
    let folder = Folder::new();
    let with = |value: &str| folder.command(&TINY).env("LODESTAR_DEVICE", value).output().unwrap();
    assert_sentence(&with("voodoo"), 1, &["`voodoo`", "there ", &usable(&folder).1]);
    assert_quiet_success(&with(&usable(&folder).0));
    assert_quiet_success(&with(""));
}

/// Ray queries trace rays where the device has them. Elsewhere they are refused, and `auto` does without.
#[test]
fn ray_queries_need_a_device_that_has_them() {
    let folder = Folder::new();
    let index = usable(&folder).0;
    let device = list(&folder).into_iter().find(|device| device["index"] == index.parse::<u64>().unwrap()).unwrap();
    let with =
        |traversal: &str| folder.command(&TINY).args(["--device", &index, "--traversal", traversal]).output().unwrap();
    match device["limits"]["has_ray_queries"] == true {
        true => assert_quiet_success(&with("query")),
        false => assert_sentence(&with("query"), 1, &["needs ray queries", "take --traversal compute"]),
    }
    assert_quiet_success(&with("auto"));
}

#[test]
fn an_unknown_device_is_refused_and_the_known_ones_are_named() {
    let folder = Folder::new();
    let (before, name) = (folder.names(), usable(&folder).1);
    for device in ["99", "-1", "voodoo", "1.5"] {
        let wanted = format!("--device={device}");
        assert_sentence(&folder.run(&["render", "scene.xml", &wanted]), 1, &[&format!("`{device}`"), &name]);
    }
    assert_eq!(folder.names(), before);
}
