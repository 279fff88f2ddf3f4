//! Subcommand `lodestar info`.

use std::process::Command;

use crate::support::assert_sentence;

const SCENE: &str = r#"<scene version="3.0.0"><default name="w" value="16"/>
<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="$w"/><integer name="height" value="9"/></film>
<sampler type="independent"><integer name="sample_count" value="7"/></sampler></sensor>
<integrator type="bdpt"><integer name="max_depth" value="5"/></integrator><emitter type="point"/>
<shape type="cube"><bsdf type="dielectric" id="glass"/></shape>
<shape type="sphere"><bsdf type="roughconductor" id="metal"/></shape>
<shape type="disk"><emitter type="area"/><bsdf type="diffuse" id="board">
<texture type="checkerboard" name="reflectance" id="checks"/></bsdf></shape></scene>"#;

fn info(arguments: &[&str]) -> std::process::Output {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.xml"), SCENE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lodestar"));
    command.current_dir(folder.path()).arg("info").args(arguments).output().unwrap()
}

#[test]
fn a_scene_is_summarized() {
    let output = info(&["s.xml", "--json", "-D", "w=32"]);
    assert!(output.status.success());
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = [
        ("name", "s".into()),
        ("width", 32.into()),
        ("height", 9.into()),
        ("sample_count", 7.into()),
        ("max_depth", 5.into()),
        ("triangles", 0.into()),
        ("parallelograms", 6.into()),
        ("disks", 1.into()),
        ("spheres", 1.into()),
        ("image_bytes", serde_json::Value::from(0)),
        ("film_bytes", (64 * 32 * 9).into()),
    ];
    for (key, value) in expected {
        assert_eq!(found[key], value, "{key}");
    }
    let materials = found["materials"].as_array().unwrap();
    let parts = materials.iter().map(|m| [&m["name"], &m["kind"], &m["guided"]].map(|part| part.as_str().unwrap()));
    assert_eq!(
        parts.collect::<Vec<_>>(),
        [
            ["glass", "dielectric", "nothing"],
            ["metal", "roughconductor", "whole"],
            ["board", "diffuse", "diffuse-lobe"]
        ]
    );
    assert_eq!((&found["lights"]["area"], &found["lights"]["point"]), (&1.into(), &1.into()));
    assert_eq!(found["textures"][0]["name"], "checks");
    assert_eq!(found["warnings"].as_array().unwrap().len(), 1);
}

#[test]
fn the_text_says_the_same() {
    let output = info(&["s.xml"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let text = String::from_utf8(output.stdout).unwrap();
    for part in [
        "s: 16 x 9 pixels",
        "6 parallelograms, 1 disks",
        "glass (dielectric): not guided",
        "checks: checkerboard",
        "`bdpt`",
    ] {
        assert!(text.contains(part), "`{part}` is missing in:\n{text}");
    }
}

#[test]
fn a_scene_that_cannot_be_read_is_one_sentence() {
    let output = info(&["gone.xml"]);
    assert_sentence(&output, 1, &["gone.xml"]);
}

#[test]
fn depth_and_all_faults_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let info = |body: &str| {
        std::fs::write(folder.path().join("s.xml"), format!("<scene version=\"3.0.0\">\n{body}\n</scene>")).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_lodestar"));
        command.current_dir(folder.path()).args(["info", "s.xml"]).output().unwrap()
    };
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    let unlimited = info(r#"<sensor type="perspective"/><integrator type="path"/>"#);
    assert!(text(&unlimited.stdout).contains("max_depth: not given, so unlimited"), "{}", text(&unlimited.stdout));
    let faulty = info("<emitter type=\"sky\"/>\n<shape type=\"sdfgrid\"/>");
    let message = text(&faulty.stderr);
    assert_eq!(faulty.status.code(), Some(1));
    for part in ["the scene has 2 faults:", "  s.xml:2: ", "`sky`", "  s.xml:3: ", "`sdfgrid`"] {
        assert!(message.contains(part), "`{part}` is missing in:\n{message}");
    }
}
