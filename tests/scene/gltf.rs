//! Reader of glTF 2.0: models made in code, with their buffers as data URIs.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use lodestar::scene::texture_lookup::sample;
use lodestar::scene::{
    Bsdf, CameraChoice, EnvironmentChoice, EnvironmentKind, LoadOptions, MaterialKind, Scene, Textured, load,
};
use serde_json::{Value, json};

use crate::Folder;
use crate::fuzz::{fuzz, mangled};

/// A square in the plane z = 0, seen from +z, with normals and texture coordinates.
pub fn square() -> Value {
    let positions = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let uvs = [[0.0f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let mut bytes: Vec<u8> = positions.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend(uvs.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "Wall", "translation": [0, 0, -2]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"name": "Paint", "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.6, 1.0], "metallicFactor": 0.0}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 92, "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))}],
    })
}

fn read_with(model: &Value, options: &LoadOptions) -> Result<Scene, String> {
    let folder = Folder::new(&[("model.gltf", &model.to_string())]);
    load(&folder.path("model.gltf"), options).map_err(|error| error.to_string())
}

pub fn read(model: &Value) -> Result<Scene, String> {
    read_with(model, &LoadOptions::default())
}

/// PNG image of one texel.
fn png(texel: [u8; 4]) -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(1, 1, image::Rgba(texel)).write_to(&mut png, image::ImageFormat::Png).unwrap();
    png.into_inner()
}

pub fn png_uri(texel: [u8; 4]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png(texel)))
}

pub fn push(list: &mut Value, entry: Value) {
    list.as_array_mut().unwrap().push(entry);
}

/// Gives the model these two materials, and the square a second time with the second one.
fn paint_twice(model: &mut Value, materials: [Value; 2]) {
    model["materials"] = json!(materials);
    let primitives = &mut model["meshes"][0]["primitives"];
    let mut second = primitives[0].clone();
    second["material"] = json!(1);
    push(primitives, second);
}

/// Base color of a material with a texture, at the texture's middle.
fn base_color(scene: &Scene, material: usize) -> glam::DVec3 {
    let MaterialKind::Surface(surface) = &scene.materials[material].kind else { panic!("a surface") };
    let Bsdf::Principled(principled) = &surface.bsdf else { panic!("a principled") };
    let texture = &scene.textures[principled.base_color.texture.unwrap() as usize];
    let texel = sample(texture, &scene.images, glam::DVec2::splat(0.5)).truncate();
    principled.base_color.value.as_dvec3() * texel
}

/// Mangled models give a scene or an error.
#[test]
fn mangled_models_never_panic() {
    let mut model = square();
    model["nodes"][0]["skin"] = json!(0);
    model["skins"] = json!([{"joints": [0]}]);
    let text = model.to_string().into_bytes();
    fuzz(mangled(text), |bytes| {
        let folder = Folder::new(&[]);
        folder.write("model.gltf", &bytes);
        let finite = |scene: &Scene| scene.primitives.iter().all(|primitive| primitive.bounds().0.is_finite());
        proptest::prop_assert!(load(&folder.path("model.gltf"), &LoadOptions::default()).map_or(true, |s| finite(&s)));
        Ok(())
    });
}

/// Body of a scene in XML with the square of [`square`].
const SQUARE_IN_XML: &str = r#"
    <shape type="ply"><string name="filename" value="square.ply"/><boolean name="face_normals" value="true"/>
        <transform name="to_world"><translate z="-2"/></transform>
        <bsdf type="twosided"><bsdf type="principled">
            <rgb name="base_color" value="0.2 0.4 0.6"/><float name="roughness" value="1"/><float name="eta" value="1.5"/>
        </bsdf></bsdf></shape>"#;

#[test]
fn a_model_is_the_scene_of_its_xml() {
    let ours = read(&square()).unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\nproperty float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 1\n1 0 0 1 1\n1 1 0 1 0\n0 1 0 0 0\n3 0 1 2\n3 0 2 3\n";
    let xml = format!(r#"<scene version="3.0.0">{SQUARE_IN_XML}</scene>"#);
    let folder = Folder::new(&[("scene.xml", &xml), ("square.ply", ply)]);
    let theirs = load(&folder.path("scene.xml"), &LoadOptions::default()).unwrap();
    assert_eq!(ours.primitives, theirs.primitives);
    assert_eq!(ours.materials[0].kind, theirs.materials[0].kind);
}

#[test]
fn a_model_without_camera_and_light_says_so() {
    let warnings = read(&square()).unwrap().warnings.join("\n");
    assert!(
        warnings.contains("the scene has no light, so the picture is black; --environment constant lights it evenly"),
        "{warnings}"
    );
    assert!(warnings.contains("a camera at"), "{warnings}");
}

#[test]
fn cameras_are_chosen_by_name_and_by_index() {
    let mut model = square();
    model["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 2.0}},
        {"type": "orthographic", "orthographic": {"xmag": 2.0, "ymag": 1.0, "znear": 0.1, "zfar": 10.0}},
    ]);
    let nodes = model["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"camera": 0, "name": "Front", "translation": [0.5, 0.5, 3.0]}));
    nodes.push(json!({"camera": 1, "name": "Flat"}));
    model["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let with = |name: &str| {
        let camera = Some(name.parse::<CameraChoice>().unwrap());
        read_with(&model, &LoadOptions { camera, ..LoadOptions::default() })
    };
    let front = with("Front").unwrap();
    assert_eq!(front.camera.world_from_camera.w_axis.truncate(), glam::Vec3::new(0.5, 0.5, 3.0));
    assert_eq!(front.camera.world_from_camera.z_axis.truncate(), glam::Vec3::NEG_Z, "it looks along -z");
    assert_eq!((front.film.width, front.film.height), (1440, 720));
    assert!((front.camera.fov - 0.5f32.to_degrees()).abs() < 1e-4);
    assert_eq!(with("0").unwrap().camera, front.camera);
    assert_ne!(with("Flat").unwrap().camera, front.camera);
    assert_ne!(with("fit").unwrap().camera, front.camera);
    let error = with("Side").unwrap_err();
    assert!(error.contains("there is no camera `Side`") && error.contains("0 (`Front`), 1 (`Flat`)"), "{error}");
}

/// Messages about a model say what it calls its things, not how XML writes them.
#[test]
fn messages_have_the_words_of_models() {
    let mut model = square();
    model["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 2.0}}]);
    for _ in 0..2 {
        push(&mut model["nodes"], json!({"camera": 0}));
    }
    model["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let warnings = read(&model).unwrap().warnings.join("\n");
    assert!(
        warnings.contains(
            "a second camera; the scene's cameras are 0 (`camera0`), 1 (`camera1`); the first is used; --camera chooses another, or all"
        ),
        "{warnings}"
    );
}

#[test]
fn an_environment_replaces_the_scenes_own() {
    let options = LoadOptions { environment: Some(EnvironmentChoice::Constant), ..LoadOptions::default() };
    let environment = read_with(&square(), &options).unwrap().environment.unwrap();
    assert!(matches!(environment.kind, EnvironmentKind::Constant { .. }));
    let environment = Some(EnvironmentChoice::File("no-such-file.exr".into()));
    let error = read_with(&square(), &LoadOptions { environment, ..LoadOptions::default() }).unwrap_err();
    assert!(error.contains("no-such-file.exr"), "{error}");
}

#[test]
fn lights_and_emissive_surfaces_shine() {
    let mut model = square();
    model["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_emissive_strength"]);
    model["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "color": [1, 0.5, 0.25], "intensity": 8},
        {"type": "directional", "intensity": 2},
        {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.4}},
    ]}});
    for light in 0..3 {
        let node = json!({"extensions": {"KHR_lights_punctual": {"light": light}}, "translation": [0, 5, 0]});
        model["nodes"].as_array_mut().unwrap().push(node);
    }
    model["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    model["materials"][0]["emissiveFactor"] = json!([1, 1, 0.5]);
    model["materials"][0]["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 4}});
    let scene = read(&model).unwrap();
    assert_eq!((scene.delta_emitters.len(), scene.emitters.len()), (3, 1));
    assert_eq!(scene.emitters[0].radiance.value, glam::Vec3::new(4.0, 4.0, 2.0));
    assert!(!scene.warnings.join("\n").contains("has no light"));
}

/// The channels of a packed texture become textures of their own, and the transform of a texture turns from `v` to `u`.
#[test]
fn textures_are_unpacked_and_transformed() {
    let mut model = square();
    model["extensionsUsed"] = json!(["KHR_texture_transform"]);
    model["images"] = json!([{"uri": png_uri([10, 128, 51, 255])}]);
    model["textures"] = json!([{"source": 0}]);
    let quarter = std::f64::consts::FRAC_PI_2;
    let transform = json!({"offset": [0.25, 0.5], "rotation": quarter, "scale": [2.0, 3.0]});
    let turned = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    model["materials"][0]["pbrMetallicRoughness"] =
        json!({"baseColorTexture": turned, "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.5});
    let scene = read(&model).unwrap();
    let MaterialKind::Surface(surface) = &scene.materials[0].kind else { panic!("a surface") };
    let Bsdf::Principled(principled) = &surface.bsdf else { panic!("a principled") };
    let to_uv = scene.textures[principled.base_color.texture.unwrap() as usize].to_uv;
    let close = |found: glam::Vec3, x: f32, y: f32| (found - glam::Vec3::new(x, y, 1.0)).length() < 1e-6;
    assert!(close(to_uv * glam::Vec3::new(0.0, 1.0, 1.0), 3.25, 0.5), "{to_uv}");
    assert!(close(to_uv * glam::Vec3::new(1.0, 0.0, 1.0), 0.25, -1.5), "{to_uv}");
    let number = |number: &Textured<f32>| {
        let texture = &scene.textures[number.texture.unwrap() as usize];
        number.value * sample(texture, &scene.images, glam::DVec2::splat(0.5)).x as f32
    };
    assert!((number(&principled.roughness) - 0.5 * 128.0 / 255.0).abs() < 1e-6);
    assert!((number(&principled.metallic) - 51.0 / 255.0).abs() < 1e-6);
}

/// Materials that share an image, but no factor, have images of their own.
#[test]
fn factors_of_specular_glossiness_are_told_apart() {
    let mut model = square();
    model["extensionsUsed"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    model["images"] = json!([{"uri": png_uri([128, 128, 128, 255])}]);
    model["textures"] = json!([{"source": 0}]);
    let paint = |diffuse: [f32; 4]| {
        json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": diffuse, "diffuseTexture": {"index": 0},
            "specularFactor": [0.1, 0.1, 0.1], "specularGlossinessTexture": {"index": 0},
        }}})
    };
    paint_twice(&mut model, [paint([1.0, 0.0, 0.0, 1.0]), paint([0.0, 1.0, 0.0, 1.0])]);
    let scene = read(&model).unwrap();
    let [red, green] = [0, 1].map(|material| base_color(&scene, material));
    assert!(red.x > 0.1 && red.y == 0.0, "{red}");
    assert!(green.y > 0.1 && green.x == 0.0, "{green}");
}

/// An image within the file hides no image file whose name it would get.
#[test]
fn image_files_are_not_hidden() {
    let mut model = square();
    model["images"] = json!([{"uri": png_uri([255, 0, 0, 255])}, {"uri": "image%30.png"}]);
    model["textures"] = json!([{"source": 0}, {"source": 1}]);
    let paint = |texture: u32| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}});
    paint_twice(&mut model, [paint(0), paint(1)]);
    let folder = Folder::new(&[("model.gltf", &model.to_string())]);
    folder.write("image0.png", &png([0, 255, 0, 255]));
    let scene = load(&folder.path("model.gltf"), &LoadOptions::default()).unwrap();
    for (material, expected) in [(0, glam::DVec3::X), (1, glam::DVec3::Y)] {
        let found = base_color(&scene, material);
        assert!((found - expected).length() < 1e-6, "material {material}: {found}");
    }
}

#[test]
fn vertex_colors_that_are_not_shown_are_named() {
    let mut model = square();
    model["extensionsUsed"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    model["materials"][0]["extensions"] = json!({"KHR_materials_pbrSpecularGlossiness": {}});
    let warnings = |model: &Value| read(model).unwrap().warnings.join("\n");
    assert!(!warnings(&model).contains("vertex colors"));
    // The positions of the square's corners serve as colors.
    model["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(0);
    let found = warnings(&model);
    assert!(found.contains("material `Paint`: vertex colors cannot stand beside"), "{found}");
}

/// A node without a skin has the mesh as it is, though a node before it moves the mesh by a skin.
#[test]
fn a_skin_moves_the_mesh_of_its_node_alone() {
    let mut model = square();
    let weights = [[1.0f32, 0.0, 0.0, 0.0]; 4];
    let mut bytes: Vec<u8> = weights.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    // All vertices have joint 0.
    bytes.extend([0u8; 16]);
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes));
    push(&mut model["buffers"], json!({"byteLength": 80, "uri": uri}));
    push(&mut model["bufferViews"], json!({"buffer": 1, "byteOffset": 0, "byteLength": 64}));
    push(&mut model["bufferViews"], json!({"buffer": 1, "byteOffset": 64, "byteLength": 16}));
    push(&mut model["accessors"], json!({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4"}));
    push(&mut model["accessors"], json!({"bufferView": 4, "componentType": 5121, "count": 4, "type": "VEC4"}));
    let attributes = &mut model["meshes"][0]["primitives"][0]["attributes"];
    (attributes["WEIGHTS_0"], attributes["JOINTS_0"]) = (json!(3), json!(4));
    model["skins"] = json!([{"joints": [2]}]);
    model["nodes"] = json!([{"mesh": 0, "skin": 0}, {"mesh": 0}, {"translation": [5, 0, 0]}]);
    model["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let places = read(&model).unwrap().primitives.iter().map(|primitive| primitive.origin.x).collect::<Vec<_>>();
    assert_eq!(places, [5.0, 5.0, 0.0, 0.0]);
}

/// Names of cameras may be ids of other objects, or those that cameras without a name would get.
#[test]
fn cameras_have_ids_of_their_own() {
    let mut model = square();
    model["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    model["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    model["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 2.0}}]);
    push(&mut model["nodes"], json!({"extensions": {"KHR_lights_punctual": {"light": 0}}}));
    for name in ["camera1", "", "light0", "shape0_Wall", "material0_Paint", "camera3", "camera1"] {
        push(&mut model["nodes"], json!({"camera": 0, "name": name}));
    }
    model["scenes"][0]["nodes"] = json!((0..9).collect::<Vec<_>>());
    let camera = Some("Side".parse::<CameraChoice>().unwrap());
    let error = read_with(&model, &LoadOptions { camera, ..LoadOptions::default() }).unwrap_err();
    let ids = [1, 2, 4, 5, 6, 3, 7].map(|number| format!("(`camera{number}`)"));
    let ids = (0..).zip(ids).map(|(index, id)| format!("{index} {id}")).collect::<Vec<_>>().join(", ");
    assert!(error.contains(&ids), "{error} lacks {ids}");
}

#[test]
fn instances_of_an_extension_are_placed() {
    let mut model = square();
    model["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    // The positions of the square's corners serve as translations.
    model["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}});
    assert_eq!(read(&model).unwrap().primitives.len(), 8);
}

#[test]
fn faults_name_the_thing() {
    let refused = |change: &dyn Fn(&mut Value), expected: &str| {
        let mut model = square();
        change(&mut model);
        let error = read(&model).expect_err(expected);
        assert!(error.contains(expected) && error.contains("model.gltf"), "{error} lacks {expected}");
    };
    refused(&|m| m["extensionsRequired"] = json!(["EXT_texture_avif"]), "EXT_texture_avif");
    refused(&|m| m["buffers"][0]["uri"] = json!("http://a.b/c.bin"), "is not read; put the file beside the scene");
    refused(&|m| m["buffers"][0]["uri"] = json!("gone.bin"), "gone.bin");
    refused(&|m| m["bufferViews"][0]["byteLength"] = json!(12), "accessor 0");
    refused(&|m| m["bufferViews"][0]["byteOffset"] = json!(4_000_000_000u32), "reaches beyond");
    refused(&|m| m["accessors"][0]["count"] = json!(4_000_000_000u32), "more than 100663296 vertices");
    refused(&|m| m["accessors"][2]["count"] = json!(4_000_000_000u32), "too many values");
    refused(&|m| m["nodes"][0]["children"] = json!([0]), "its own descendant");
    let add_instances = |model: &mut Value| {
        // An accessor without a buffer view, of which one element is given and all others are zero.
        let given =
            json!({"count": 1, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 0}});
        let zeros = json!({"componentType": 5126, "count": 1 << 20, "type": "VEC3", "sparse": given});
        push(&mut model["accessors"], zeros);
        let instancing = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 3}}});
        push(&mut model["nodes"], json!({"mesh": 0, "extensions": instancing}));
        model["scenes"][0]["nodes"] = json!([0, 1]);
    };
    refused(&add_instances, "it has more than 1048576 nodes");
    refused(&|m| m["images"] = json!([{"bufferView": 0}]), "image 0");
    refused(&|m| m["images"] = json!([{"name": "empty"}]), "image 0");
    refused(&|m| m["nodes"][0]["mesh"] = json!(7), "it is no glTF 2.0 file");
    refused(&|m| m["accessors"][0]["count"] = json!(3), "it has fewer texture coordinates or colors than vertices");
    refused(&|m| m["accessors"][2]["byteOffset"] = json!(2), "accessor 2");
    refused(&|m| m["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9), "there is no accessor 9");
    let options = LoadOptions { defines: vec![("a".into(), "1".into())], ..LoadOptions::default() };
    assert!(read_with(&square(), &options).unwrap_err().contains("-D a"));
}
