//! `convert`: the scene that is written is the scene that was read.

use std::path::Path;

use lodestar::scene::{Array, Dictionary, LoadOptions, Scene, Value, convert, convert_dictionary, fingerprint, load};

use super::Folder;

const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

fn read(path: &Path) -> Scene {
    load(path, &LoadOptions::default()).unwrap()
}

/// Folder of a scene of Mitsuba 0.6 with an include, a default, a folder to search, and a rotation that is not normalized.
fn old_scene() -> Folder {
    let scene = r#"<scene version="0.6.0">
        <default name="turn" value="30"/>
        <path value="meshes"/>
        <sensor type="perspective"><float name="focusDistance" value="3"/></sensor>
        <include filename="parts.xml"/>
    </scene>"#;
    let parts = r#"<scene version="0.6.0"><shape type="obj">
        <string name="filename" value="a &amp; b.obj"/>
        <transform name="toWorld"><rotate x="1" y="2" angle="$turn"/><translate x="0.1"/></transform>
        <bsdf type="dielectric"><float name="intIOR" value="1.4"/></bsdf>
    </shape></scene>"#;
    Folder::new(&[("scene.xml", scene), ("parts.xml", parts), ("meshes/a & b.obj", MESH)])
}

#[test]
fn an_old_scene_keeps_its_fingerprint() {
    let folder = old_scene();
    let (input, output) = (folder.path("scene.xml"), folder.path("new/out.xml"));
    std::fs::create_dir(folder.path("new")).unwrap();
    for turn in ["30", "31"] {
        let defines = [("turn".to_string(), turn.to_string())];
        let options = LoadOptions { defines: defines.to_vec(), ..LoadOptions::default() };
        let converted = convert(&input, &defines, &output, turn == "31").unwrap();
        assert_eq!(converted.file_count, 1);
        let expected = fingerprint(&load(&input, &options).unwrap()).unwrap();
        assert_eq!(fingerprint(&read(&output)).unwrap(), expected, "{turn}");
        // The twin: another turn is another scene.
        assert_eq!(fingerprint(&read(&input)).unwrap() == expected, turn == "30");
    }
    let text = std::fs::read_to_string(&output).unwrap();
    for gone in ["include", "default", "$", "toWorld", "rotate", "0.6"] {
        assert!(!text.contains(gone), "{gone} in {text}");
    }
    assert!(folder.path("new/out/a & b.obj").is_file());
}

#[test]
fn our_scenes_keep_their_fingerprints() {
    let folder = Folder::new(&[]);
    for name in ["cornell-box", "door-ajar"] {
        let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).join("scene.xml");
        let output = folder.path(&format!("{name}.xml"));
        convert(&input, &[], &output, false).unwrap();
        assert_eq!(fingerprint(&read(&output)).unwrap(), fingerprint(&read(&input)).unwrap(), "{name}");
    }
}

/// A scene without a camera is written with the one that is fitted to it, which the new file has for its own.
#[test]
fn a_fitted_camera_is_written() {
    let folder = Folder::new(&[
        (
            "scene.xml",
            r#"<scene version="3.0.0"><shape type="sphere"><float name="radius" value="0.3"/></shape></scene>"#,
        ),
        ("flat.gltf", &super::gltf::square().to_string()),
    ]);
    for name in ["scene.xml", "flat.gltf"] {
        let (input, output) = (folder.path(name), folder.path(&format!("{name}.out.xml")));
        let converted = convert(&input, &[], &output, false).unwrap();
        assert!(converted.warnings.iter().any(|warning| warning.contains("fitted")), "{:?}", converted.warnings);
        let (ours, theirs) = (read(&output), read(&input));
        assert_eq!((ours.camera, ours.film), (theirs.camera, theirs.film), "{name}");
        assert_eq!(fingerprint(&ours).unwrap(), fingerprint(&theirs).unwrap(), "{name}");
        assert!(!ours.warnings.iter().any(|warning| warning.contains("fitted")), "{:?}", ours.warnings);
        assert!(std::fs::read_to_string(&output).unwrap().contains(r#"<integrator type="path"/>"#), "{name}");
    }
}

#[test]
fn a_mesh_in_memory_becomes_a_ply_file_with_all_attributes() {
    let rows = |columns: usize, values: &[f64]| {
        Value::Array(Array { shape: vec![values.len() / columns, columns], values: values.to_vec() })
    };
    let object = |plugin: &str, entries: Vec<(&str, Value)>| {
        let plugin = ("type".to_string(), Value::Text(plugin.to_string()));
        let entries = entries.into_iter().map(|(key, value)| (key.to_string(), value));
        Dictionary { entries: std::iter::once(plugin).chain(entries).collect() }
    };
    let colors = object("mesh_attribute", vec![("name", Value::Text("vertex_color".to_string()))]);
    let mesh = |with_normals: bool| {
        let mut arrays = vec![
            ("vertices", rows(3, &[0.1, 0.0, 0.0, 1.0 / 3.0, 0.0, 0.0, 0.0, 1e-7, 0.0, 1.0, 1.0, 1.0])),
            ("faces", rows(3, &[0.0, 1.0, 2.0, 3.0, 2.0, 1.0])),
            ("colors", rows(3, &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.3, 0.2, 0.1])),
            ("bsdf", Value::Object(object("diffuse", vec![("reflectance", Value::Object(colors.clone()))]))),
        ];
        if with_normals {
            arrays.push(("normals", rows(3, &[0.0, 0.6, 0.8, 0.0, 0.0, 1.0, 0.6, 0.0, 0.8, 0.0, 0.0, 1.0])));
        }
        object("mesh", arrays)
    };
    let plain = object(
        "mesh",
        vec![
            ("vertices", rows(3, &[0.0, 0.0, 2.0, 1.0, 0.0, 2.0, 0.0, 1.0, 2.0])),
            ("faces", rows(3, &[0.0, 1.0, 2.0])),
            ("uvs", rows(2, &[0.1, 0.2, 0.7, 0.2, 0.1, 0.9])),
        ],
    );
    let sets = |key, values: &[f64]| (key, Value::Array(Array { shape: vec![2, 3, 3], values: values.to_vec() }));
    let bent = object(
        "mesh",
        vec![
            sets(
                "vertices",
                &[0.0, 0.0, 2.0, 1.0, 0.0, 2.0, 0.0, 1.0, 2.0, 0.1, 0.0, 2.0, 1.0, 0.5, 2.0, 0.0, 1.0, 3.0],
            ),
            sets(
                "normals",
                &[0.0, 0.6, 0.8, 0.0, 0.0, 1.0, 0.6, 0.0, 0.8, 0.6, 0.0, 0.8, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0],
            ),
            ("faces", rows(3, &[0.0, 1.0, 2.0])),
        ],
    );
    let shutter = vec![("shutter_open", Value::Number(0.0)), ("shutter_close", Value::Number(1.0))];
    let eye = object("perspective", shutter);
    let scene = |with_normals| {
        object(
            "scene",
            vec![
                ("eye", Value::Object(eye.clone())),
                ("bent", Value::Object(bent.clone())),
                ("colored", Value::Object(mesh(with_normals))),
                ("plain", Value::Object(plain.clone())),
            ],
        )
    };
    let folder = Folder::new(&[]);
    let output = folder.path("out.xml");
    assert_eq!(convert_dictionary(&scene(true), &output, false).unwrap().file_count, 3);
    assert_eq!(Scene::from_dictionary(&scene(true)).unwrap().deformations.len(), 1);
    let of = |dictionary: &Dictionary| fingerprint(&Scene::from_dictionary(dictionary).unwrap()).unwrap();
    let written = fingerprint(&read(&output)).unwrap();
    assert_eq!(written, of(&scene(true)));
    assert_ne!(written, of(&scene(false)));
}

#[test]
fn nothing_is_replaced_unless_asked() {
    let folder = old_scene();
    let (input, output) = (folder.path("scene.xml"), folder.path("out.xml"));
    let refusal = |output: &Path, overwrite| convert(&input, &[], output, overwrite).unwrap_err().to_string();
    folder.write("out.xml", b"mine");
    assert!(refusal(&output, false).contains("--overwrite"));
    assert_eq!(std::fs::read(&output).unwrap(), b"mine");
    assert!(refusal(&input, true).contains("cannot replace itself"));
    assert!(refusal(&folder.path("out.obj"), true).contains("must end in .xml"));
    convert(&input, &[], &output, true).unwrap();
    assert_ne!(std::fs::read(&output).unwrap(), b"mine");
}

#[test]
fn files_of_one_name_are_kept_apart() {
    let shape = |file: &str| format!(r#"<shape type="obj"><string name="filename" value="{file}"/></shape>"#);
    let scene = super::with_sensor(&["a/m.obj", "b/m.obj", "a/m.obj"].map(shape).concat());
    let other = MESH.replace("v 1 0 0", "v 2 0 0");
    let folder = Folder::new(&[("scene.xml", &scene), ("a/m.obj", MESH), ("b/m.obj", &other)]);
    let output = folder.path("out.xml");
    let converted = convert(&folder.path("scene.xml"), &[], &output, false).unwrap();
    assert_eq!(converted.file_count, 2);
    assert_eq!(fingerprint(&read(&output)).unwrap(), fingerprint(&read(&folder.path("scene.xml"))).unwrap());
}
