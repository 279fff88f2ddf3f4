//! Models whose meshes are compressed by meshopt or Draco, as their own encoders write them (tests/data/compressed/make.mjs).

use std::collections::HashSet;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use lodestar::scene::texture::Texels;
use lodestar::scene::{LoadOptions, Scene, convert, load};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::fuzz::{fuzz, mangled};
use crate::gltf::read;
use crate::textures::ktx2;

const MODELS: [(&str, &str); 5] = [
    ("meshopt, version 0", include_str!("../data/compressed/meshopt-0.gltf")),
    ("meshopt, version 1", include_str!("../data/compressed/meshopt-1.gltf")),
    ("Draco, sequential", include_str!("../data/compressed/draco-sequential.gltf")),
    ("Draco, edgebreaker", include_str!("../data/compressed/draco-edgebreaker.gltf")),
    ("Draco, edgebreaker by valence", include_str!("../data/compressed/draco-edgebreaker-valence.gltf")),
];

/// Vertices of the grid in a row.
const SIDE: u32 = 20;

fn model(at: usize) -> Value {
    serde_json::from_str(MODELS[at].1).expect("a model")
}

/// Corners of a triangle of the grid, beginning with the first of them.
fn turned(mut corners: [u32; 3]) -> [u32; 3] {
    let first = (0..3).min_by_key(|&at| corners[at]).unwrap();
    corners.rotate_left(first);
    corners
}

/// Checks positions, normals and texture coordinates of all triangles.
fn check(name: &str, scene: &Scene) {
    let mut found = HashSet::new();
    for primitive in &scene.primitives {
        let origin = primitive.origin;
        let corners = [origin, origin + primitive.edge_u, origin + primitive.edge_v];
        let indices = std::array::from_fn(|corner| {
            let position = corners[corner];
            let (x, y) = (position.x.round() as u32, position.y.round() as u32);
            let index = x + SIDE * y;
            let expected = Vec3::new(x as f32, y as f32, (7 * index % 5) as f32 / 4.0);
            assert!(position.distance(expected) < 0.002, "{name}: {position} instead of {expected}");
            let normal = primitive.normals.expect("normals")[corner];
            assert!(normal.distance(Vec3::Z) < 0.01, "{name}: the normal {normal}");
            let uv = primitive.uvs[corner] * SIDE as f32;
            assert!(uv.distance(expected.truncate()) < 0.005, "{name}: the coordinates {uv} at {expected}");
            index
        });
        found.insert(turned(indices));
    }
    let cells = (0..(SIDE - 1) * (SIDE - 1)).map(|cell| cell % (SIDE - 1) + SIDE * (cell / (SIDE - 1)));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + SIDE + 1], [a, a + SIDE + 1, a + SIDE]]);
    assert_eq!(found, triangles.map(turned).collect(), "{name}");
    assert_eq!(scene.primitives.len(), found.len(), "{name}");
}

#[test]
fn meshes_are_those_that_were_compressed() {
    for (at, (name, _)) in MODELS.iter().enumerate() {
        check(name, &read(&model(at)).unwrap_or_else(|error| panic!("{name}: {error}")));
    }
}

/// The compressed bytes of a model.
fn payload(model: &Value) -> Vec<u8> {
    let uri = model["buffers"][0]["uri"].as_str().expect("a URI");
    STANDARD.decode(uri.split_once(',').expect("a data URI").1).expect("base64")
}

/// The model with other compressed bytes, to which its views are fitted.
fn with_payload(mut model: Value, bytes: &[u8]) -> Value {
    let before = payload(&model).len();
    model["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes)));
    model["buffers"][0]["byteLength"] = json!(bytes.len());
    for view in model["bufferViews"].as_array_mut().expect("views") {
        let source = match view.get("extensions") {
            Some(_) => view["extensions"].as_object_mut().unwrap().values_mut().next().unwrap(),
            None => view,
        };
        let (offset, length) =
            (source["byteOffset"].as_u64().unwrap_or(0) as usize, source["byteLength"].as_u64().unwrap() as usize);
        if offset + length == before {
            source["byteLength"] = json!(bytes.len().saturating_sub(offset));
        }
    }
    model
}

#[test]
fn data_that_end_early_are_refused() {
    for (at, (name, _)) in MODELS.iter().enumerate() {
        let bytes = payload(&model(at));
        for length in (0..bytes.len()).step_by(7) {
            let error = read(&with_payload(model(at), &bytes[..length])).map(drop).expect_err(name);
            assert_eq!(error.lines().count(), 1, "{name}: {error}");
            let says = ["damaged", "cut short"].iter().any(|words| error.contains(words));
            assert!(says && error.contains("model.gltf"), "{name}, {length} bytes: {error}");
        }
    }
}

/// Whatever the compressed bytes are, the model is read or refused in one sentence.
#[test]
fn mangled_data_never_panic() {
    let payloads = MODELS.iter().enumerate().map(|(at, _)| (Just(at), mangled(payload(&model(at)))).boxed());
    fuzz(proptest::strategy::Union::new(payloads), |(at, bytes)| {
        match read(&with_payload(model(at), &bytes)) {
            Ok(scene) => prop_assert!(scene.primitives.iter().all(|primitive| primitive.bounds().0.is_finite())),
            Err(error) => prop_assert_eq!(error.lines().count(), 1, "{}", error),
        }
        Ok(())
    });
}

/// Whatever the description of compressed data says, the model is read or refused in one sentence.
#[test]
fn mangled_descriptions_never_panic() {
    let texts = MODELS.iter().map(|(_, text)| {
        let (begin, uri) = text.split_at(text.find("\"buffers\"").expect("buffers"));
        mangled(begin.as_bytes().to_vec()).prop_map(move |begin| [&begin[..], uri.as_bytes()].concat())
    });
    fuzz(proptest::strategy::Union::new(texts), |bytes| {
        let folder = crate::Folder::new(&[]);
        folder.write("model.gltf", &bytes);
        let _ = load(&folder.path("model.gltf"), &LoadOptions::default());
        Ok(())
    });
}

#[test]
fn faults_of_compressed_data_name_the_place() {
    let refused = |at: usize, change: &dyn Fn(&mut Value), expected: &str| {
        let mut model = model(at);
        change(&mut model);
        let error = read(&model).map(drop).expect_err(expected);
        assert!(error.contains(expected) && error.contains("model.gltf"), "{error} lacks {expected}");
    };
    fn source(model: &mut Value, view: usize) -> &mut Value {
        &mut model["bufferViews"][view]["extensions"]["EXT_meshopt_compression"]
    }
    refused(
        0,
        &|m| source(m, 0)["mode"] = json!("POINTS"),
        "buffer view 0: its meshopt compression has the mode `POINTS`",
    );
    refused(
        0,
        &|m| source(m, 1)["filter"] = json!("SHARP"),
        "buffer view 1: its meshopt compression has the filter `SHARP`",
    );
    refused(
        0,
        &|m| source(m, 3)["filter"] = json!("COLOR"),
        "which elements of 4 bytes in the mode TRIANGLES cannot have",
    );
    refused(0, &|m| source(m, 0)["byteStride"] = json!(6), "has 400 elements of 6 bytes");
    refused(0, &|m| source(m, 0)["byteStride"] = Value::Null, "gives no `byteStride`");
    refused(
        0,
        &|m| source(m, 0)["byteOffset"] = json!(1),
        "buffer view 0: its meshopt data are damaged: their first byte",
    );
    refused(0, &|m| source(m, 0)["count"] = json!(300), "they go on beyond their last element");
    refused(0, &|m| source(m, 0)["count"] = json!(100_000), "they end too early");
    refused(0, &|m| source(m, 0)["count"] = json!(u64::MAX), "more than 1024 times as large as the file");
    refused(0, &|m| source(m, 0)["buffer"] = json!(1), "its compressed data reach beyond their buffer");
    fn draco(model: &mut Value) -> &mut Value {
        &mut model["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
    }
    refused(3, &|m| draco(m)["bufferView"] = json!(7), "mesh 0: it is no glTF 2.0 file: there is no buffer view 7");
    refused(3, &|m| draco(m)["attributes"] = Value::Null, "mesh 0: its Draco compression gives no `attributes`");
    refused(3, &|m| draco(m)["attributes"]["NORMAL"] = json!(9), "its Draco data have no attribute 9 for NORMAL");
    refused(
        3,
        &|m| m["accessors"][0]["componentType"] = json!(7),
        "POSITION has no accessor with a known `componentType`",
    );
    refused(3, &|m| m["bufferViews"][0]["byteLength"] = json!(9_999_999), "reaches beyond its buffer");
}

/// Two primitives of the same data share it, and one of the same accessors with other data gets accessors of its own.
#[test]
fn primitives_share_what_is_compressed() {
    for (at, (name, _)) in MODELS.iter().enumerate().skip(2) {
        let mut model = model(at);
        let primitive = model["meshes"][0]["primitives"][0].clone();
        let view = model["bufferViews"][0].clone();
        model["bufferViews"].as_array_mut().unwrap().push(view);
        let mut other = primitive.clone();
        other["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = json!(1);
        model["meshes"][0]["primitives"] = json!([primitive, primitive, other]);
        let scene = read(&model).unwrap();
        assert_eq!(scene.primitives.len(), 3 * 722, "{name}");
    }
}

/// A file with the same data without compression is read by these where the extension is not required.
#[test]
fn plain_data_take_the_place_of_draco() {
    let mut model = crate::gltf::square();
    model["bufferViews"].as_array_mut().unwrap().push(json!({"buffer": 0, "byteLength": 4}));
    let source = json!({"bufferView": 3, "attributes": {"POSITION": 0, "TEXCOORD_0": 1}});
    model["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": source});
    assert_eq!(read(&model).unwrap().primitives.len(), 2);
    model["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    assert!(read(&model).map(drop).unwrap_err().contains("its Draco data are damaged"));
}

/// Images by the extensions of textures. Mitsuba reads neither WebP nor KTX2, so a converted scene has PNG images.
#[test]
fn images_of_extensions_are_shown_and_converted() {
    let mut webp = std::io::Cursor::new(Vec::new());
    let texel = image::RgbaImage::from_pixel(4, 4, image::Rgba([200, 100, 50, 255]));
    texel.write_to(&mut webp, image::ImageFormat::WebP).unwrap();
    for (extension, bytes) in
        [("EXT_texture_webp", webp.into_inner()), ("KHR_texture_basisu", ktx2([200, 100, 50, 255]))]
    {
        let mut model = crate::gltf::square();
        model["extensionsRequired"] = json!([extension]);
        model["images"] = json!([{"uri": format!("data:image/webp;base64,{}", STANDARD.encode(bytes))}]);
        model["textures"] = json!([{"extensions": {extension: {"source": 0}}}]);
        model["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        let folder = crate::Folder::new(&[("model.gltf", &model.to_string())]);
        let options = LoadOptions::default();
        let scene = load(&folder.path("model.gltf"), &options).unwrap();
        convert(&folder.path("model.gltf"), &[], &folder.path("model.xml"), false).unwrap();
        let converted = load(&folder.path("model.xml"), &options).unwrap();
        for scene in [&scene, &converted] {
            let Texels::Bytes { data, .. } = &scene.images[0].texels else { panic!("{:?}", scene.images[0]) };
            assert_eq!(data[..], [[200, 100, 50, 255]; 16]);
        }
        let files = std::fs::read_dir(folder.path("model")).unwrap().map(|file| file.unwrap().path());
        let pictures = files.filter(|path| path.extension().is_some_and(|extension| extension == "png"));
        assert!(pictures.map(|path| std::fs::read(path).unwrap()).all(|bytes| bytes.starts_with(b"\x89PNG")));
    }
}
