//! The Cornell box as a glTF model is the scene of its XML.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use lodestar::scene::{LoadOptions, fingerprint, load};
use serde_json::{Value, json};

use crate::Folder;

type Quad = [[f32; 3]; 4];

/// Materials: white, red, green, and the lamp's. Each has a base color.
const COLORS: [[f32; 3]; 4] = [[0.725, 0.71, 0.68], [0.63, 0.065, 0.05], [0.14, 0.45, 0.091], [0.0; 3]];
const LAMP: u32 = 3;
/// Radiance of the lamp: a factor of at most 1 in each channel, and the strength that multiplies it.
const LAMP_FACTOR: [f32; 3] = [1.0, 0.75, 0.25];
const LAMP_STRENGTH: f32 = 16.0;
const FOV: f32 = 0.686;

/// Walls, the lamp, and the sides of both blocks, each with its material.
fn quads() -> Vec<(Quad, u32)> {
    let mut quads = vec![
        ([[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]], 0),
        ([[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]], 0),
        ([[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]], 0),
        ([[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]], 2),
        ([[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]], 1),
        ([[343.0, 548.3, 227.0], [343.0, 548.3, 332.0], [213.0, 548.3, 332.0], [213.0, 548.3, 227.0]], LAMP),
    ];
    let short = [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]];
    let tall = [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]];
    for (base, height) in [(short, 165.0), (tall, 330.0)] {
        let at = |corner: usize, y: f32| [base[corner % 4][0], y, base[corner % 4][1]];
        quads.push(([0, 1, 2, 3].map(|corner| at(corner, height)), 0));
        quads.extend((0..4).map(|i| ([at(i, 0.0), at(i, height), at(i + 1, height), at(i + 1, 0.0)], 0)));
    }
    quads
}

fn model() -> Value {
    let quads = quads();
    let mut bytes: Vec<u8> =
        quads.iter().flat_map(|(quad, _)| quad.as_flattened()).flat_map(|value| value.to_le_bytes()).collect();
    let indices = bytes.len();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    let count = quads.len();
    let mut views: Vec<Value> =
        (0..count).map(|i| json!({"buffer": 0, "byteOffset": 48 * i, "byteLength": 48})).collect();
    views.push(json!({"buffer": 0, "byteOffset": indices, "byteLength": 12}));
    let bound = |quad: &Quad, pick: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|axis| quad.iter().map(|corner| corner[axis]).reduce(pick).unwrap_or_default())
    };
    let positions = |(i, (quad, _)): (usize, &(Quad, u32))| {
        json!({"bufferView": i, "componentType": 5126, "count": 4, "type": "VEC3", "min": bound(quad, f32::min),
            "max": bound(quad, f32::max)})
    };
    let mut accessors: Vec<Value> = quads.iter().enumerate().map(positions).collect();
    accessors.push(json!({"bufferView": count, "componentType": 5123, "count": 6, "type": "SCALAR"}));
    let mesh = |(i, (_, material)): (usize, &(Quad, u32))| json!({"primitives": [{"attributes": {"POSITION": i}, "indices": count, "material": material}]});
    let materials = COLORS.map(|color| {
        json!({"pbrMetallicRoughness": {"baseColorFactor": [color[0], color[1], color[2], 1.0], "metallicFactor": 0.0}})
    });
    let mut model = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "scene": 0,
        "scenes": [{"nodes": (0..=count).collect::<Vec<_>>()}],
        "nodes": (0..count).map(|i| json!({"mesh": i})).collect::<Vec<_>>(),
        "meshes": quads.iter().enumerate().map(mesh).collect::<Vec<_>>(),
        "materials": materials,
        "cameras": [{"type": "perspective",
            "perspective": {"yfov": FOV, "aspectRatio": 1.0, "znear": 10.0, "zfar": 2800.0}}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))}],
    });
    // A half turn: the camera looks along +z.
    let camera = json!({"camera": 0, "translation": [278.0, 273.0, -800.0], "rotation": [0.0, 1.0, 0.0, 0.0]});
    model["nodes"].as_array_mut().unwrap().push(camera);
    let lamp = &mut model["materials"][LAMP as usize];
    lamp["emissiveFactor"] = json!(LAMP_FACTOR);
    lamp["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": LAMP_STRENGTH}});
    model
}

/// The scene in XML, written without the reader of glTF, and its meshes.
fn xml() -> (String, Vec<(String, String)>) {
    let mut text = format!(
        r#"<scene version="3.0.0"><sensor type="perspective">
            <transform name="to_world"><lookat origin="278, 273, -800" target="278, 273, 0" up="0, 1, 0"/></transform>
            <float name="fov" value="{:?}"/><string name="fov_axis" value="y"/>
            <float name="near_clip" value="10"/><float name="far_clip" value="2800"/>
            <film type="hdrfilm"><integer name="width" value="720"/><integer name="height" value="720"/></film>
        </sensor>"#,
        FOV.to_degrees()
    );
    for (i, [r, g, b]) in COLORS.iter().enumerate() {
        text += &format!(
            r#"<bsdf type="twosided" id="m{i}"><bsdf type="principled"><rgb name="base_color" value="{r} {g} {b}"/>
                <float name="roughness" value="1"/><float name="eta" value="1.5"/></bsdf></bsdf>"#
        );
    }
    let [r, g, b] = LAMP_FACTOR.map(|factor| factor * LAMP_STRENGTH);
    let lamp = format!(r#"<emitter type="area"><rgb name="radiance" value="{r} {g} {b}"/></emitter>"#);
    let mut meshes = Vec::new();
    for (i, (quad, material)) in quads().into_iter().enumerate() {
        let emitter = if material == LAMP { &lamp } else { "" };
        text += &format!(
            r#"<shape type="ply"><string name="filename" value="{i}.ply"/><boolean name="face_normals" value="true"/>
                <ref id="m{material}"/>{emitter}</shape>"#
        );
        let vertices = quad.map(|[x, y, z]| format!("{x} {y} {z}\n")).concat();
        let head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
        let faces = "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
        meshes.push((format!("{i}.ply"), format!("{head}{faces}{vertices}3 0 1 2\n3 0 2 3\n")));
    }
    (text + "</scene>", meshes)
}

/// Scenes of one fingerprint render to the same bits.
#[test]
fn the_cornell_box_is_that_of_its_xml() {
    let (text, meshes) = xml();
    let folder = Folder::new(&[("scene.xml", &text), ("box.gltf", &model().to_string())]);
    meshes.iter().for_each(|(name, content)| folder.write(name, content.as_bytes()));
    let read = |name: &str| load(&folder.path(name), &LoadOptions::default()).unwrap();
    let (ours, theirs) = (read("box.gltf"), read("scene.xml"));
    assert_eq!(ours.warnings, Vec::<String>::new());
    assert_eq!((ours.camera, ours.film), (theirs.camera, theirs.film));
    assert_eq!(ours.primitives, theirs.primitives);
    assert_eq!((ours.emitters.clone(), ours.materials.len()), (theirs.emitters.clone(), theirs.materials.len()));
    assert_eq!(fingerprint(&ours).unwrap(), fingerprint(&theirs).unwrap());
    // The twin: a brighter wall is another scene.
    folder.write("scene.xml", text.replace("0.725", "0.726").as_bytes());
    assert_ne!(fingerprint(&ours).unwrap(), fingerprint(&read("scene.xml")).unwrap());
}
