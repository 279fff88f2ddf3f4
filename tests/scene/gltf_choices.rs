//! Moments of a model's animation, and variants of its materials.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use lodestar::scene::{LoadOptions, Scene, load};
use serde_json::{Value, json};

use crate::Folder;
use crate::fuzz::{fuzz, mangled};
use crate::gltf::{push, square};

/// Adds an accessor of numbers with its own buffer. Returns its index.
fn add_numbers(model: &mut Value, kind: &str, numbers: &[f32]) -> usize {
    let width = match kind {
        "SCALAR" => 1,
        "VEC3" => 3,
        _ => 4,
    };
    let bytes: Vec<u8> = numbers.iter().flat_map(|value| value.to_le_bytes()).collect();
    let index = |model: &Value, list: &str| model[list].as_array().unwrap().len();
    let (buffer, view, accessor) = (index(model, "buffers"), index(model, "bufferViews"), index(model, "accessors"));
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    push(&mut model["buffers"], json!({"byteLength": bytes.len(), "uri": uri}));
    push(&mut model["bufferViews"], json!({"buffer": buffer, "byteLength": bytes.len()}));
    let mut entry = json!({"bufferView": view, "componentType": 5126, "count": numbers.len() / width, "type": kind});
    if kind == "VEC3" {
        // Positions of morph targets need bounds.
        (entry["min"], entry["max"]) = (json!([-9, -9, -9]), json!([9, 9, 9]));
    }
    push(&mut model["accessors"], entry);
    accessor
}

/// The square, whose node moves along x by 10 a second, grows twofold within the first second, and whose morph target lifts it along z.
fn moving() -> Value {
    let mut model = square();
    let times = add_numbers(&mut model, "SCALAR", &[0.0, 1.0]);
    let places = add_numbers(&mut model, "VEC3", &[0.0, 0.0, -2.0, 10.0, 0.0, -2.0]);
    let sizes = add_numbers(&mut model, "VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 1.0]);
    let weights = add_numbers(&mut model, "SCALAR", &[0.0, 1.0]);
    let target = add_numbers(&mut model, "VEC3", &[0.0, 0.0, 4.0].repeat(4));
    model["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
    let channel = |sampler: usize, path: &str| json!({"sampler": sampler, "target": {"node": 0, "path": path}});
    let pointer = json!({"extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/scale"}}, "path": "pointer"});
    let sampler = |output: usize| json!({"input": times, "output": output});
    model["animations"] = json!([
        {
            "channels": [channel(0, "translation"), json!({"sampler": 1, "target": pointer}), channel(2, "weights")],
            "samplers": [sampler(places), sampler(sizes), sampler(weights)],
        },
        {"channels": [], "samplers": []},
    ]);
    model
}

fn read_with(model: &Value, name: &str, value: &str) -> Result<Scene, String> {
    let folder = Folder::new(&[("model.gltf", &model.to_string())]);
    let options = LoadOptions { defines: vec![(name.to_owned(), value.to_owned())], ..LoadOptions::default() };
    load(&folder.path("model.gltf"), &options).map_err(|error| error.to_string())
}

#[test]
fn moments_of_animations_are_shown() {
    for (time, origin, edge) in [
        ("-1", Vec3::new(0.0, 0.0, -2.0), 1.0),
        ("0.5", Vec3::new(5.0, 0.0, 0.0), 1.5),
        ("7", Vec3::new(10.0, 0.0, 2.0), 2.0),
    ] {
        let scene = read_with(&moving(), "time", time).unwrap();
        let primitive = scene.primitives[0];
        assert!((primitive.origin - origin).length() < 1e-5, "{time}: {}", primitive.origin);
        assert!((primitive.edge_u - Vec3::X * edge).length() < 1e-5, "{time}: {}", primitive.edge_u);
        assert!(scene.warnings.join("\n").contains("it has 2 animations, of which the first is played"));
    }
    let still = crate::gltf::read(&moving()).unwrap();
    assert_eq!(still.primitives[0].origin, Vec3::new(0.0, 0.0, -2.0));
    assert!(still.warnings.join("\n").contains("its animations are not played"), "{:?}", still.warnings);
    let square = read_with(&square(), "time", "1").unwrap();
    assert!(square.warnings.join("\n").contains("it has no animation"), "{:?}", square.warnings);
}

#[test]
fn wrong_animations_get_a_sentence() {
    let refused = |change: &dyn Fn(&mut Value), says: &str| {
        let mut model = moving();
        change(&mut model);
        let error = read_with(&model, "time", "0.5").map(drop).expect_err(says);
        assert!(error.contains(says), "{error}");
    };
    refused(&|m| m["animations"][0]["channels"][0]["sampler"] = json!(9), "channel 0 of its animation has no sampler");
    refused(
        &|m| m["animations"][0]["samplers"][1]["output"] = json!(99),
        "channel 1 of its animation lacks the accessor",
    );
    refused(&|m| m["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE"), "has 6 numbers for 2 keys");
    refused(&|m| m["animations"][0]["samplers"][0]["input"] = json!(0), "has times that do not increase");
    let error = read_with(&square(), "time", "noon").map(drop).unwrap_err();
    assert!(error.contains("the time `noon` should be a number of seconds"), "{error}");
}

#[test]
fn variants_of_materials_are_chosen() {
    let mut model = square();
    let paint = |color: [f64; 4]| json!({"pbrMetallicRoughness": {"baseColorFactor": color, "metallicFactor": 0.0}});
    push(&mut model["materials"], paint([0.9, 0.1, 0.1, 1.0]));
    model["extensionsUsed"] = json!(["KHR_materials_variants"]);
    model["extensions"] = json!({"KHR_materials_variants": {"variants": [{"name": "plain"}, {"name": "red"}]}});
    model["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}});
    let name = |scene: &Scene| scene.materials[scene.primitives[0].material as usize].name.clone();
    let (default, plain) = (crate::gltf::read(&model).unwrap(), read_with(&model, "variant", "plain").unwrap());
    let red = read_with(&model, "variant", "red").unwrap();
    assert_eq!(name(&default), name(&plain));
    assert_ne!(name(&red), name(&plain));
    assert!(
        default.warnings.join("\n").contains("its materials have the variants `plain`, `red`"),
        "{:?}",
        default.warnings
    );
    let error = read_with(&model, "variant", "blue").map(drop).unwrap_err();
    assert!(error.contains("there is no variant `blue`; choose one of `plain`, `red`"), "{error}");
}

/// Mangled animations give a scene or an error.
#[test]
fn mangled_animations_never_panic() {
    fuzz(mangled(moving().to_string().into_bytes()), |bytes| {
        let folder = Folder::new(&[]);
        folder.write("model.gltf", &bytes);
        let options = LoadOptions { defines: vec![("time".into(), "0.3".into())], ..LoadOptions::default() };
        let finite = |scene: &Scene| scene.primitives.iter().all(|primitive| primitive.bounds().0.is_finite());
        proptest::prop_assert!(load(&folder.path("model.gltf"), &options).map_or(true, |s| finite(&s)));
        Ok(())
    });
}
