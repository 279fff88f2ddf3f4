//! Scenes of strangers: files that ask for more than any scene has are refused early, and no message repeats what a file says.

use lodestar::scene::{LoadOptions, load};

use super::{Folder, with_sensor};

/// Message of the refusal of the scene `name` in a folder.
#[track_caller]
fn refusal(folder: &Folder, name: &str) -> String {
    load(&folder.path(name), &LoadOptions::default()).map(drop).expect_err("this should be refused").to_string()
}

/// Fails unless the scene is refused with these words.
#[track_caller]
fn refuse(files: &[(&str, &str)], parts: &[&str]) {
    let message = refusal(&Folder::new(files), files[0].0);
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

/// Nine `<default>`s name ten of the one before. The last would have 10^10 bytes.
#[test]
fn names_that_grow() {
    let default = |i: u32| format!("<default name=\"a{i}\" value=\"{}\"/>\n", format!("$a{}", i - 1).repeat(10));
    let defaults: String = (1..10).map(default).collect();
    let text = with_sensor(&format!("<default name=\"a0\" value=\"xxxxxxxxxx\"/>{defaults}"));
    refuse(&[("scene.xml", &text)], &["scene.xml:8: ", "replace $names have more than 67108864 bytes"]);
}

/// Fourteen files include the next eight times each: 8^14 files.
#[test]
fn includes_that_multiply() {
    let folder = Folder::new(&[("scene.xml", &with_sensor("<include filename=\"0.xml\"/>"))]);
    for i in 0..14 {
        let next = format!("<include filename=\"{}.xml\"/>\n", i + 1).repeat(8);
        folder.write(&format!("{i}.xml"), format!("<scene>{next}</scene>").as_bytes());
    }
    folder.write("14.xml", b"<scene/>");
    let message = refusal(&folder, "scene.xml");
    assert!(message.contains(".xml:") && message.contains("includes more than 4096 files"), "{message}");
}

/// The parser of XML compares each attribute of an element with all others.
#[test]
fn attributes_without_end() {
    let attributes: String = (0..100_000).map(|i| format!(" a{i}=\"\"")).collect();
    let text = with_sensor(&format!("<bsdf{attributes}/>"));
    refuse(&[("scene.xml", &text)], &["scene.xml:2: ", "more than 64 attributes"]);
    let spaces: String = (0..50).map(|i| format!(" xmlns:n{i}=\"u\"")).collect();
    let text = with_sensor(&format!("<bsdf{spaces}/><bsdf{spaces}/>"));
    refuse(&[("scene.xml", &text)], &["scene.xml:2: ", "more than 64 namespaces"]);
}

/// A million instances, which the old limit on a file's length refused.
#[test]
fn a_file_longer_than_the_old_limit_is_read() {
    let instance = r#"<shape type="instance"><ref id="g"/></shape>"#;
    let text = with_sensor(&format!("<!--{}--><shape type=\"disk\"/>", instance.repeat(1_600_000)));
    assert!(text.len() > 64 << 20);
    assert_eq!(Folder::new(&[("scene.xml", &text)]).load(&[]).unwrap().primitives.len(), 1);
}

/// A document type that defines nothing is skipped, as in Mitsuba.
#[test]
fn a_document_type_is_skipped() {
    let text =
        with_sensor("<shape type=\"disk\"/>").replacen("<scene", "<!DOCTYPE scene\nSYSTEM \"s.dtd\">\n<scene", 1);
    assert_eq!(Folder::new(&[("scene.xml", &text)]).load(&[]).unwrap().primitives.len(), 1);
    let text = text.replace("type=\"disk\"", "type=\"velvet\"");
    refuse(&[("scene.xml", &text)], &["scene.xml:4: ", "velvet"]);
}

/// The four forms in which Mitsuba reads XML.
#[test]
fn texts_in_other_encodings() {
    let text = with_sensor("<shape type=\"disk\" id=\"\u{e4}\"/>");
    let folder = Folder::new(&[]);
    let units = text.encode_utf16();
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    for bytes in [
        [&b"\xef\xbb\xbf"[..], text.as_bytes()].concat(),
        [vec![0xff, 0xfe], units.clone().flat_map(u16::to_le_bytes).collect()].concat(),
        [vec![0xfe, 0xff], units.flat_map(u16::to_be_bytes).collect()].concat(),
        [&b"<?xml version='1.0' encoding='iso-8859-1'?>"[..], &latin].concat(),
    ] {
        folder.write("scene.xml", &bytes);
        assert_eq!(folder.load(&[]).unwrap().primitives.len(), 1);
    }
    folder.write("scene.xml", &latin);
    assert!(refusal(&folder, "scene.xml").contains("scene.xml:2: the text is neither UTF-8"));
}

const PBRT: &str = "Camera \"perspective\" WorldBegin\n";

#[test]
fn parameters_without_end() {
    let parameters: String = (0..100_000).map(|i| format!("\"float a{i}\" 1\n")).collect();
    let text = format!("{PBRT}Shape \"sphere\" {parameters}");
    refuse(&[("scene.pbrt", &text)], &["scene.pbrt:2: ", "more than 256 parameters"]);
    let attribute = |i| format!("Attribute \"shape\" \"float a{i}\" 1 Shape \"sphere\"\n");
    let text = PBRT.to_owned() + &(0..100_000).map(attribute).collect::<String>();
    refuse(&[("scene.pbrt", &text)], &["scene.pbrt:258: ", "more than 256"]);
}

/// One file of a megabyte, included again and again.
#[test]
fn files_that_repeat() {
    let text = format!("{PBRT}{}", "Include \"part.pbrt\"\n".repeat(20_000));
    let comment = format!("#{}", "x".repeat(1 << 20));
    let files = [("scene.pbrt", &text[..]), ("part.pbrt", &comment)];
    refuse(&files, &["part.pbrt", "again and again have more than 268435456 bytes", "ObjectInstance"]);
}

/// Zeros become a thousand times shorter.
#[test]
fn compressed_files_that_grow() {
    let folder = Folder::new(&[]);
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut gzip, PBRT.as_bytes()).unwrap();
    for _ in 0..100 {
        std::io::Write::write_all(&mut gzip, &[b'\n'; 1 << 20]).unwrap();
    }
    folder.write("scene.pbrt", &gzip.finish().unwrap());
    let message = refusal(&folder, "scene.pbrt");
    assert!(message.contains("its content is more than 100 times as long as the compressed file"), "{message}");
    let body = r#"<shape type="serialized"><string name="filename" value="a.serialized"/></shape>"#;
    folder.write("scene.xml", with_sensor(body).as_bytes());
    let mut content =
        [&0x1000u32.to_le_bytes()[..], b"\0", &(20_000_000u64).to_le_bytes(), &1u64.to_le_bytes()].concat();
    content.resize(content.len() + 240_000_000, 0);
    let mesh = crate::meshes::compressed(4, &content);
    folder.write("a.serialized", &crate::meshes::serialized(4, &[mesh]));
    let message = refusal(&folder, "scene.xml");
    assert!(message.contains("a.serialized: its content is more than 100 times as long"), "{message}");
}

/// Texts of the kind that nobody would show to others.
fn secrets() -> [Vec<u8>; 3] {
    let hash = "$y$j9T$".to_owned() + &"Kf8sZ2".repeat(14);
    let shadow =
        format!("root:{hash}:19000:0:99999:7:::\ndaemon:*:19000:0:99999:7:::\nuser:{hash}:19001:0:99999:7:::\n");
    let environ = format!("HOME=/root\0TOKEN={}\0PATH=/usr/local/bin:/usr/bin:/bin\0", "s3cr3t".repeat(12));
    let key = format!("-----BEGIN OPENSSH PRIVATE KEY-----\n{}\n", "b3BlbnNzaC1r".repeat(6)).repeat(3);
    [shadow.into_bytes(), environ.into_bytes(), key.into_bytes()]
}

/// Fails if a message has more than a word of a file, or a character that no terminal should get.
#[track_caller]
fn check_silence(message: &str, secret: &[u8]) {
    const MOST: usize = 40;
    let message = message.as_bytes();
    let told = secret.windows(MOST + 1).find(|window| message.windows(MOST + 1).any(|found| found == *window));
    assert_eq!(told, None, "{}", String::from_utf8_lossy(message));
    let line = secret
        .split(|&byte| byte == b'\n')
        .find(|line| line.len() > 24 && message.windows(line.len()).any(|found| found == *line));
    assert_eq!(line, None, "{}", String::from_utf8_lossy(message));
    assert!(!message.iter().any(|&byte| byte < b' ' && byte != b'\n'), "{}", String::from_utf8_lossy(message));
}

/// Every reader of a file that a scene names, with beginnings that lead into its parts.
#[test]
fn no_message_repeats_a_file() {
    let shape = |plugin: &str| {
        with_sensor(&format!(r#"<shape type="{plugin}"><string name="filename" value="secret"/></shape>"#))
    };
    let texture = |name: &str| {
        let texture =
            format!(r#"<texture type="bitmap" name="reflectance"><string name="filename" value="{name}"/></texture>"#);
        with_sensor(&format!(r#"<shape type="disk"><bsdf type="diffuse">{texture}</bsdf></shape>"#))
    };
    let spectrum = r#"<spectrum name="reflectance" filename="secret"/>"#;
    let mut scenes = vec![
        ("scene.xml", with_sensor(r#"<include filename="secret"/>"#)),
        ("scene.xml", with_sensor(&format!(r#"<shape type="disk"><bsdf type="diffuse">{spectrum}</bsdf></shape>"#))),
        ("scene.xml", with_sensor(r#"<emitter type="envmap"><string name="filename" value="secret"/></emitter>"#)),
        ("scene.pbrt", format!("{PBRT}Include \"secret\"")),
        ("scene.pbrt", format!("{PBRT}Shape \"plymesh\" \"string filename\" \"secret\"")),
        ("scene.pbrt", format!("{PBRT}LightSource \"distant\" \"spectrum L\" \"secret\"")),
        ("scene.pbrt", format!("{PBRT}LightSource \"infinite\" \"string filename\" \"secret\"")),
    ];
    scenes
        .extend(["obj", "ply", "serialized", "linearcurve", "bsplinecurve"].map(|plugin| ("scene.xml", shape(plugin))));
    scenes.extend(
        ["png", "jpg", "tga", "bmp", "hdr", "pfm", "exr"].map(|kind| ("scene.xml", texture(&format!("secret.{kind}")))),
    );
    let begins: [&[u8]; 22] = [
        b"",
        b"<scene>",
        b"<scene version='",
        b"<scene><",
        b"<scene>&",
        b"v ",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 ",
        b"ply\n",
        b"ply\nformat ",
        b"ply\nformat ascii 1.0\nelement ",
        b"ply\nformat ascii 1.0\nelement vertex 3\nproperty ",
        b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        b"\x1c\x04\x04\x00",
        b"0 0 0 ",
        b"400 1\n500 ",
        b"Shape \"",
        b"Shape \"sphere\" \"float radius\" ",
        b"Shape \"sphere\" \"",
        b"#?RADIANCE\nFORMAT=",
        b"PF\n",
        b"BM",
        b"\x76\x2f\x31\x01",
    ];
    for secret in secrets() {
        for begin in begins {
            let content = [begin, &secret].concat();
            for (name, scene) in &scenes {
                let folder = Folder::new(&[(name, scene)]);
                for name in [
                    "secret",
                    "secret.png",
                    "secret.jpg",
                    "secret.tga",
                    "secret.bmp",
                    "secret.hdr",
                    "secret.pfm",
                    "secret.exr",
                ] {
                    folder.write(name, &content);
                }
                match load(&folder.path(name), &LoadOptions::default()) {
                    Ok(scene) => scene.warnings.iter().for_each(|warning| check_silence(warning, &secret)),
                    Err(error) => check_silence(&error.to_string(), &secret),
                }
            }
            // As the scene itself.
            for name in ["scene.xml", "scene.pbrt", "scene.gltf", "scene.glb"] {
                let folder = Folder::new(&[]);
                folder.write(name, &content);
                check_silence(&refusal(&folder, name), &secret);
            }
        }
    }
}

/// A JSON file may have a text where a number should be.
#[test]
fn no_message_repeats_a_model() {
    let long = "s3cr3t".repeat(12);
    for text in [
        format!(r#"{{"asset":{{"version":"2.0"}},"scene":"{long}"}}"#),
        format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":"{long}"}}]}}"#),
        format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":4,"uri":"http://{long}"}}]}}"#),
        format!(
            r#"{{"asset":{{"version":"2.0"}},"accessors":[{{"componentType":"{long}","count":1,"type":"{long}"}}]}}"#
        ),
        format!(r#"{{"asset":{{"version":"{long}"}}}}"#),
        format!(r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":["{long}\u0007\"x"]}}]}}"#),
    ] {
        let folder = Folder::new(&[("scene.gltf", &text)]);
        check_silence(&refusal(&folder, "scene.gltf"), long.as_bytes());
    }
}
