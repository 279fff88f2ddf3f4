//! Valid files in the less usual forms that other programs write: images, meshes and models.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use exr::meta::attribute::Chromaticities;
use exr::prelude::*;
use lodestar::scene::texture::Texels;
use lodestar::scene::{EnvironmentChoice, LoadOptions, Scene, load};
use serde_json::{Value, json};

use super::gltf::square;
use super::meshes::load_bytes;
use super::textures::ktx2;
use super::{Folder, load_mesh, with_sensor};

/// EXR picture of 4 x 3 texels of one color, with primaries, in channels of these names.
fn exr(names: &[&str], color: &[f32], primaries: Option<[[f32; 2]; 4]>) -> Vec<u8> {
    let size = Vec2(4, 3);
    let channel = |(name, &value): (&&str, &f32)| AnyChannel::new(*name, FlatSamples::F32(vec![value; 12]));
    let channels = AnyChannels::sort(names.iter().zip(color).map(channel).collect());
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    let [red, green, blue, white] = primaries.unwrap_or_default().map(|[x, y]| Vec2(x, y));
    let chromaticities = primaries.map(|_| Chromaticities { red, green, blue, white });
    let attributes = ImageAttributes { chromaticities, ..ImageAttributes::new(IntegerBounds::from_dimensions(size)) };
    let mut bytes = std::io::Cursor::new(Vec::new());
    exr::image::Image::new(attributes, layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// First texel of the image that a scene reads as `plugin`.
fn texel(file: &str, content: &[u8], scene: &str) -> [f32; 4] {
    let folder = Folder::new(&[("scene.xml", &with_sensor(scene))]);
    folder.write(file, content);
    first_texel(&folder.load(&[]).unwrap())
}

fn first_texel(scene: &Scene) -> [f32; 4] {
    match &scene.images[0].texels {
        Texels::Floats(texels) => texels[0],
        other => panic!("{other:?}"),
    }
}

fn bitmap(file: &str, raw: bool) -> String {
    format!(
        r#"<shape type="disk"><bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename"
        value="{file}"/><boolean name="raw" value="{raw}"/></texture></bsdf></shape>"#
    )
}

const ENVIRONMENT: &str = r#"<emitter type="envmap"><string name="filename" value="a.exr"/></emitter>"#;

#[track_caller]
fn assert_close(found: [f32; 4], expected: [f32; 3]) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2.0e-3), "{found:?} is not {expected:?}");
}

/// Colors of the same numbers in AP1 and in CIE XYZ, as Mitsuba 3.9 reads them.
#[test]
fn primaries_of_pictures() {
    let ap1 = [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]];
    let xyz = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]];
    let color = [0.5, 0.3, 0.2];
    for (primaries, expected) in [(None, color), (Some(ap1), [0.668, 0.273, 0.163]), (Some(xyz), [1.060, 0.086, 0.178])]
    {
        let file = exr(&["R", "G", "B"], &color, primaries);
        assert_close(texel("a.exr", &file, &bitmap("a.exr", false)), expected);
        assert_close(texel("a.exr", &file, ENVIRONMENT), expected);
        // Numbers are no colors.
        assert_eq!(texel("a.exr", &file, &bitmap("a.exr", true)), [0.5, 0.3, 0.2, 1.0]);
        let folder = Folder::new(&[]);
        folder.write("a.exr", &file);
        let [red, green, blue] = lodestar::image::exr::read_rgb(&folder.path("a.exr")).unwrap().pixels[0];
        assert_close([red, green, blue, 1.0], expected);
        let world = "Camera \"perspective\" WorldBegin LightSource \"infinite\" \"string filename\" \"a.exr\"\nShape \"sphere\"";
        folder.write("scene.pbrt", world.as_bytes());
        load(&folder.path("scene.pbrt"), &LoadOptions::default()).expect_err("the map is not square");
    }
    let folder = Folder::new(&[("scene.xml", &with_sensor(&bitmap("a.exr", false)))]);
    folder.write("a.exr", &exr(&["R", "G", "B"], &color, Some([[0.3, 0.3]; 4])));
    let error = folder.load(&[]).map(drop).expect_err("no primaries").to_string();
    assert!(error.contains("a.exr") && error.contains("`chromaticities` are no primaries"), "{error}");
}

#[test]
fn a_single_channel_is_gray() {
    for name in ["R", "Y", "roughness"] {
        assert_eq!(texel("a.exr", &exr(&[name], &[0.25], None), &bitmap("a.exr", true)), [0.25, 0.25, 0.25, 1.0]);
    }
}

/// An environment keeps its light where a value is infinite, and says so.
#[test]
fn values_that_are_no_radiance() {
    let folder = Folder::new(&[("scene.xml", &with_sensor(ENVIRONMENT))]);
    for (value, read, word) in [
        (f32::INFINITY, 65504.0, "infinite radiance, which counts as 65504"),
        (f32::NEG_INFINITY, 0.0, "negative radiance"),
        (f32::NAN, 0.0, "no numbers, which count as 0"),
        (1.0e9, 1.0e9, "no light"),
    ] {
        folder.write("a.exr", &exr(&["R", "G", "B"], &[value, 1.0, 1.0], None));
        let scene = folder.load(&[]).unwrap();
        assert_eq!(first_texel(&scene), [read, 1.0, 1.0, 1.0]);
        assert_eq!(scene.warnings.iter().any(|warning| warning.contains(word)), value != 1.0e9, "{:?}", scene.warnings);
        let file = EnvironmentChoice::File(folder.path("a.exr"));
        let options = LoadOptions { environment: Some(file), ..LoadOptions::default() };
        let scene = load(&folder.path("scene.xml"), &options).unwrap();
        assert_eq!(first_texel(&scene), [read, 1.0, 1.0, 1.0]);
    }
}

#[test]
fn headers_of_radiance_files() {
    let file = |begin: &str, end: &str| {
        let header = format!("{begin}{end}FORMAT=32-bit_rle_rgbe{end}{end}-Y 2 +X 2{end}");
        [header.as_bytes(), &[128, 64, 32, 129].repeat(4)].concat()
    };
    for (begin, end) in [("#?RADIANCE", "\n"), ("#?RGBE", "\n"), ("#?RADIANCE", "\r\n"), ("#?RGBE", "\r\n")] {
        assert_eq!(texel("a.hdr", &file(begin, end), &bitmap("a.hdr", false)), [1.0, 0.5, 0.25, 1.0], "{begin}{end:?}");
    }
}

#[test]
fn formats_that_are_not_read_are_named() {
    let folder = Folder::new(&[("scene.xml", &with_sensor(&bitmap("a.png", false)))]);
    folder.write("a.png", b"\0\0\0\x1cftypavif\0\0\0\0");
    let error = folder.load(&[]).map(drop).expect_err("no AVIF").to_string();
    assert!(error.contains("images of the format AVIF are not read; save it as"), "{error}");
    let texels = [[255, 128, 0, 255], [0, 255, 0, 128]];
    let webp = image::RgbaImage::from_vec(2, 1, texels.concat()).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    webp.write_to(&mut bytes, image::ImageFormat::WebP).unwrap();
    folder.write("a.png", bytes.get_ref());
    let scene = folder.load(&[]).unwrap();
    assert!(
        matches!(&scene.images[0].texels, Texels::Bytes { data, .. } if data[..] == texels),
        "{:?}",
        scene.images[0]
    );
    folder.write("a.png", &bytes.get_ref()[..40]);
    let error = folder.load(&[]).map(drop).expect_err("a short WebP").to_string();
    assert!(error.contains("it is not a whole image"), "{error}");
}

#[test]
fn images_of_ktx2() {
    let folder = Folder::new(&[("scene.xml", &with_sensor(&bitmap("a.png", false)))]);
    let file = ktx2([200, 100, 50, 255]);
    folder.write("a.png", &file);
    let scene = folder.load(&[]).unwrap();
    let is_color = |texel: &[u8; 4]| *texel == [200, 100, 50, 255];
    let Texels::Bytes { data, .. } = &scene.images[0].texels else { panic!("{:?}", scene.images[0]) };
    assert!(data.len() == 16 && data.iter().all(is_color), "{data:?}");
    for length in 12..file.len() {
        folder.write("a.png", &file[..length]);
        let error = folder.load(&[]).map(drop).expect_err("a short file").to_string();
        assert!(error.contains("cut short"), "{length}: {error}");
    }
    for (at, byte, expected) in [
        (12, 43, "is not compressed by Basis Universal"),
        (27, 1, "larger than 65536 texels"),
        (36, 6, "is no plain picture"),
        (40, 0, "header is damaged"),
        (116, 162, "is not a whole KTX2 image"),
    ] {
        let mut changed = file.clone();
        changed[at] = byte;
        folder.write("a.png", &changed);
        let error = folder.load(&[]).map(drop).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// Area of a scene's triangles.
fn area(scene: &Scene) -> f32 {
    scene.primitives.iter().map(|primitive| 0.5 * primitive.edge_u.cross(primitive.edge_v).length()).sum()
}

/// An L of six corners and area 3, which fans around four of its corners get wrong.
#[test]
fn concave_faces_keep_their_area() {
    let corners = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
    let vertices = |begin: &str| corners.map(|[x, y]| format!("{begin}{x} {y} 5\n")).concat();
    let header = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for first in 0..6 {
        let indices: Vec<_> = (0..6).map(|i| (first + i) % 6).collect();
        let words = |add: usize| indices.iter().map(|index| format!(" {}", index + add)).collect::<String>();
        let scene = load_mesh(&format!("{}f{}\n", vertices("v "), words(1)), "").unwrap();
        assert!((area(&scene) - 3.0).abs() < 1e-5, "{first}: {}", area(&scene));
        let scene = load_bytes("ply", format!("{header}{}6{}\n", vertices(""), words(0)).as_bytes(), "").unwrap();
        assert!((area(&scene) - 3.0).abs() < 1e-5, "{first}: {}", area(&scene));
    }
}

#[test]
fn faces_that_are_none_are_left_out_with_a_warning() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (faces, word) in [
        ("f 1 2 3\nf 1 2\n", "mesh.obj: a face is a point or a line and is left out"),
        ("f\nf 1 2 3\nf 1\n", "mesh.obj: 2 faces are points or lines and are left out"),
    ] {
        let scene = load_mesh(&format!("{vertices}{faces}"), "").unwrap();
        assert_eq!(scene.primitives.len(), 1);
        assert!(scene.warnings.iter().any(|warning| warning.contains(word)), "{:?}", scene.warnings);
    }
}

/// Editors of other systems.
#[test]
fn marks_and_line_ends() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for text in [format!("\u{feff}{text}"), text.replace('\n', "\r"), format!("\u{feff}{}", text.replace('\n', "\r\n"))]
    {
        assert_eq!(load_mesh(&text, "").unwrap().primitives.len(), 1, "{text:?}");
    }
    let curve = "\u{feff}0 0 0 1\r0 0 1 1\r";
    assert!(!load_bytes("linearcurve", curve.as_bytes(), "").unwrap().primitives.is_empty());
    let folder = Folder::new(&[("scene.pbrt", "\u{feff}Camera \"perspective\" WorldBegin\nShape \"sphere\"")]);
    assert_eq!(load(&folder.path("scene.pbrt"), &LoadOptions::default()).unwrap().primitives.len(), 1);
}

/// Names of texture coordinates that other programs give.
#[test]
fn texture_coordinates_of_ply_files() {
    let mesh = |properties: &str, list: &str, vertices: [&str; 3], faces: &str| {
        let header = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{properties}\
             element face {}\nproperty list uchar int vertex_indices\n{list}end_header\n",
            faces.lines().count()
        );
        let vertices = vertices.concat();
        let scene = load_bytes("ply", format!("{header}{vertices}{faces}").as_bytes(), "").unwrap();
        scene.primitives.iter().map(|primitive| primitive.uvs.map(|uv| uv.to_array())).collect::<Vec<_>>()
    };
    let own = ["0 0 0 0.5 0.25\n", "1 0 0 1 0.25\n", "0 1 0 0.5 1\n"];
    for names in [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]] {
        let properties = names.map(|name| format!("property float {name}\n")).concat();
        assert_eq!(mesh(&properties, "", own, "3 0 1 2\n"), [[[0.5, 0.25], [1.0, 0.25], [0.5, 1.0]]], "{names:?}");
    }
    // MeshLab gives each face the coordinates of its corners.
    let plain = ["0 0 0\n", "1 0 0\n", "0 1 0\n"];
    let list = "property list uchar float texcoord\n";
    let faces = "3 0 1 2 6 0 0 1 0 0 1\n3 2 1 0 6 0.5 1 1 0 0 0\n3 0 2 1 0\n";
    let uvs = mesh("", list, plain, faces);
    assert_eq!(uvs[0], [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(uvs[1], [[0.5, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                        element face 1\nproperty list uchar int vertex_indices\n{list}end_header\n{}3 0 1 2 3 0 0 1\n",
        plain.concat()
    );
    let error = load_bytes("ply", text.as_bytes(), "").map(drop).expect_err("odd").to_string();
    assert!(error.contains("`texcoord` has 3 numbers for a face of 3 corners"), "{error}");
}

#[track_caller]
fn read_model(model: &Value) -> Scene {
    let folder = Folder::new(&[("model.gltf", &model.to_string())]);
    load(&folder.path("model.gltf"), &LoadOptions::default()).unwrap()
}

/// Changes of a model that keep it valid and change no picture.
#[test]
fn models_in_forms_that_are_valid() {
    let plain = read_model(&square()).primitives;
    type Change = fn(&mut Value);
    let changes: [(&str, Change); 9] = [
        ("own attribute", |m| m["meshes"][0]["primitives"][0]["attributes"]["_TEMPERATURE"] = json!(1)),
        ("extras", |m| {
            m["extras"] = json!(5);
            m["nodes"][0]["extras"] = json!(["a", null]);
        }),
        ("an unused accessor without data", |m| {
            m["accessors"].as_array_mut().unwrap().push(json!({"componentType": 5126, "count": 9, "type": "MAT4"}))
        }),
        ("no scene", |m| drop(m.as_object_mut().unwrap().remove("scene"))),
        ("no scenes", |m| {
            m.as_object_mut().unwrap().remove("scene");
            m.as_object_mut().unwrap().remove("scenes");
        }),
        ("a scene without nodes", |m| m["scenes"].as_array_mut().unwrap().push(json!({"name": "empty"}))),
        ("an animation of a pointer", |m| {
            m["extensionsUsed"] = json!(["KHR_animation_pointer"]);
            let target =
                json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/scale"}}});
            let sampler = json!({"input": 1, "output": 1});
            m["animations"] = json!([{"channels": [{"sampler": 0, "target": target}], "samplers": [sampler]}]);
        }),
        ("a matrix that is rounded", |m| {
            m["nodes"][0] = json!({"mesh": 0, "name": "Wall",
                "matrix": [0.99999994, 0, 0, 0, 0, 0.99999994, 0, 0, 0, 0, 0.99999994, 0, 0, 0, -1.9999999, 0.99999994]});
        }),
        ("a code in the data", |m| {
            let uri = m["buffers"][0]["uri"].as_str().unwrap();
            let (kind, data) = uri.split_once(',').unwrap();
            m["buffers"][0]["uri"] = json!(format!("{kind},{}", data.replace('A', "%41").replace('+', "%2B")));
        }),
    ];
    for (name, change) in changes {
        let mut model = square();
        change(&mut model);
        let found = read_model(&model).primitives;
        let near = |(a, b): (&lodestar::scene::Primitive, &lodestar::scene::Primitive)| {
            (a.origin - b.origin).length() < 1e-5 && (a.edge_u - b.edge_u).length() < 1e-5
        };
        assert!(found.len() == 2 && found.iter().zip(&plain).all(near), "{name}: {found:?}");
    }
}

/// Morph targets and colors may have no data: then they are zero.
#[test]
fn an_accessor_without_data_is_zero() {
    let mut model = square();
    model["accessors"].as_array_mut().unwrap().push(json!({"componentType": 5126, "count": 4, "type": "VEC3"}));
    model["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 3}]);
    model["meshes"][0]["weights"] = json!([1.0]);
    let (found, plain) = (read_model(&model).primitives, read_model(&square()).primitives);
    assert_eq!(found.iter().map(|p| p.origin).collect::<Vec<_>>(), plain.iter().map(|p| p.origin).collect::<Vec<_>>());
    model["accessors"][3]["count"] = json!(1 << 23);
    let folder = Folder::new(&[("model.gltf", &model.to_string())]);
    let error = load(&folder.path("model.gltf"), &LoadOptions::default()).map(drop).expect_err("many").to_string();
    assert!(error.contains("accessor 3: it has 8388608 elements without a buffer view"), "{error}");
}

/// Binary files with a mark, zeros after the JSON, and bytes after the end.
#[test]
fn binary_models() {
    let mut model = square();
    let uri = model["buffers"][0]["uri"].as_str().unwrap().to_owned();
    let mut binary = STANDARD.decode(uri.split_once(',').unwrap().1).unwrap();
    model["buffers"][0].as_object_mut().unwrap().remove("uri");
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut text = model.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4) + 4, 0);
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let words = |words: [u32; 2]| words.map(u32::to_le_bytes).concat();
    let file = [
        b"glTF",
        &words([2, length as u32])[..],
        &words([text.len() as u32, u32::from_le_bytes(*b"JSON")]),
        &text,
        &words([binary.len() as u32, u32::from_le_bytes(*b"BIN\0")]),
        &binary,
        b"left over",
    ]
    .concat();
    let folder = Folder::new(&[]);
    folder.write("model.glb", &file);
    assert_eq!(load(&folder.path("model.glb"), &LoadOptions::default()).unwrap().primitives.len(), 2);
    folder.write("model.gltf", format!("\u{feff}{}", square()).as_bytes());
    assert_eq!(load(&folder.path("model.gltf"), &LoadOptions::default()).unwrap().primitives.len(), 2);
}

#[test]
fn points_alone_are_told_in_words_of_gltf() {
    let mut model = square();
    model["meshes"][0]["primitives"][0]["mode"] = json!(0);
    let folder = Folder::new(&[("model.gltf", &model.to_string())]);
    let error = load(&folder.path("model.gltf"), &LoadOptions::default()).map(drop).expect_err("points").to_string();
    assert!(
        error.contains("its scene has neither triangles nor a camera; points and lines are not rendered"),
        "{error}"
    );
}
