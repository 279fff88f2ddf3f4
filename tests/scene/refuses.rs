//! Invalid input is refused with one sentence that names the file, the line and the cause.

use super::{Folder, load_body, load_mesh, with_sensor};

/// Asserts that the error has one line and contains all `parts`.
#[track_caller]
fn assert_says(result: lodestar::Result<lodestar::scene::Scene>, parts: &[&str]) {
    let message = result.map(drop).expect_err("this should be refused").to_string();
    assert!(!message.contains('\n'), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

#[track_caller]
fn refuse(body: &str, parts: &[&str]) {
    assert_says(load_body(body), &[&["scene.xml:2: "], parts].concat());
}

#[track_caller]
fn refuse_mesh(obj: &str, parts: &[&str]) {
    assert_says(load_mesh(obj, ""), parts);
}

#[track_caller]
fn refuse_text(text: &str, parts: &[&str]) {
    assert_says(Folder::new(&[("scene.xml", text)]).load(&[]), parts);
}

#[test]
fn malformed_xml() {
    refuse_text("<scene>\n<sensor type=\"perspective\">\n", &["scene.xml:3: ", "malformed XML"]);
    refuse_text("<scene>\n<sensor type=\"persp", &["scene.xml:2: ", "malformed XML"]);
    refuse_text("<scene>\n</sensor></scene>", &["scene.xml:2: ", "malformed XML"]);
    refuse_text("", &["scene.xml:1: ", "it is no XML"]);
    refuse_text("<!DOCTYPE a [<!ENTITY b \"c\">]>\n<scene/>", &["scene.xml:1: ", "the definitions of a <!DOCTYPE>"]);
    refuse_text("<html/>", &["scene.xml:1: ", "<html>"]);
    refuse_text(&"<scene>".repeat(100_000), &["scene.xml:1: ", "nested more than 64 deep"]);
    refuse(&format!("{}{}", "<bsdf type=\"twosided\">".repeat(99), "</bsdf>".repeat(99)), &["nested"]);
    let folder = Folder::new(&[]);
    folder.write("scene.xml", b"<scene>\n\xff</scene>");
    assert_says(folder.load(&[]), &["scene.xml:2: ", "UTF-8"]);
}

#[test]
fn missing_files() {
    assert_says(Folder::new(&[]).load(&[]), &["scene.xml", "cannot be read"]);
    refuse(r#"<shape type="obj"><string name="filename" value="gone.obj"/></shape>"#, &["`gone.obj`"]);
    refuse(r#"<shape type="obj"/>"#, &["`filename`"]);
    refuse(r#"<include filename="gone.xml"/>"#, &["`gone.xml`"]);
}

#[test]
fn includes_that_never_end() {
    let folder = Folder::new(&[
        ("scene.xml", &with_sensor(r#"<include filename="a.xml"/>"#)),
        ("a.xml", "<scene>\n\n<include filename=\"scene.xml\"/></scene>"),
    ]);
    assert_says(folder.load(&[]), &["a.xml:3: ", "`scene.xml` includes itself"]);
    let folder = Folder::new(&[("scene.xml", &with_sensor(r#"<include filename="0.xml"/>"#))]);
    for i in 0..20 {
        let text = format!(r#"<scene><include filename="{}.xml"/></scene>"#, i + 1);
        folder.write(&format!("{i}.xml"), text.as_bytes());
    }
    assert_says(folder.load(&[]), &["14.xml:1: ", "nested more than 16 deep"]);
}

#[test]
fn parameters_of_the_scene() {
    refuse(r#"<shape type="$kind"/>"#, &["$kind", "not defined"]);
    let folder = Folder::new(&[("scene.xml", &with_sensor(""))]);
    assert_says(folder.load(&[("wdith", "7")]), &["scene.xml", "-D wdith"]);
}

#[test]
fn unknown_plugins_are_named_with_what_there_is() {
    for (body, name, known) in [
        (r#"<bsdf type="velvet"/>"#, "bsdf plugin `velvet`", "`diffuse`"),
        (r#"<shape type="disk"><bsdf type="velvet"/></shape>"#, "bsdf plugin `velvet`", "`diffuse`"),
        (r#"<bsdf type="twosided"><bsdf type="velvet"/></bsdf>"#, "bsdf plugin `velvet`", "`diffuse`"),
        (r#"<shape type="teapot"/>"#, "shape plugin `teapot`", "`obj`"),
        (r#"<emitter type="sky"/>"#, "emitter plugin `sky`", "`constant`"),
        (r#"<integrator type="amazing"/>"#, "integrator plugin `amazing`", "`path`"),
        (r#"<shape type="disk"><emitter type="projector"/></shape>"#, "emitter plugin `projector`", "`area`"),
    ] {
        refuse(body, &[name, "not supported", known]);
    }
    refuse_text("<scene>\n<sensor type=\"fisheye\"/></scene>", &["scene.xml:2: ", "`fisheye`", "`perspective`"]);
    refuse(r#"<medium type="smoke"/>"#, &["medium plugin `smoke`", "`homogeneous`", "`heterogeneous`"]);
    refuse("<teapot/>", &["<teapot>"]);
    refuse(r#"<bsdf type="null"><medium type="homogeneous"/></bsdf>"#, &["<medium>", "bsdf `null`"]);
}

#[test]
fn sensors_and_films() {
    let film = |parameters: &str| {
        format!("<scene><sensor type=\"perspective\">\n<film type=\"hdrfilm\">{parameters}</film></sensor></scene>")
    };
    let at = "scene.xml:2: ";
    refuse_text(&film(r#"<integer name="width" value="0"/>"#), &[at, "`width`", "not 0"]);
    refuse_text(&film(r#"<integer name="height" value="-4"/>"#), &[at, "`height`", "not -4"]);
    refuse_text(&film(r#"<integer name="width" value="wide"/>"#), &[at, "`width`", "`wide`"]);
    refuse_text(&film(r#"<integer name="crop_offset_x" value="768"/>"#), &[at, "`crop_offset_x`"]);
    refuse_text(&film(r#"<rfilter type="sinc"/>"#), &[at, "rfilter plugin `sinc`"]);
    refuse_text("<scene/>", &["scene.xml", "<sensor>"]);
    let sensor = |parameters: &str| format!("<scene>\n<sensor type=\"perspective\">{parameters}</sensor></scene>");
    refuse_text(&sensor(r#"<float name="fov" value="180"/>"#), &[at, "`fov`"]);
    refuse_text(&sensor(r#"<float name="fov" value="nan"/>"#), &[at, "`nan`"]);
    refuse_text(&sensor(r#"<float name="near_clip" value="0"/>"#), &[at, "`near_clip`"]);
    refuse_text(&sensor(r#"<float name="far_clip" value="0.001"/>"#), &[at, "`far_clip`"]);
    refuse_text(&sensor(r#"<string name="focal_length" value="long"/>"#), &[at, "`long`"]);
    let lens = |parameters: &str| format!("<scene>\n<sensor type=\"thinlens\">{parameters}</sensor></scene>");
    refuse_text(&lens(""), &[at, "`aperture_radius`"]);
    refuse_text(&lens(r#"<float name="aperture_radius" value="-1"/>"#), &[at, "`aperture_radius`", "-1"]);
    refuse_text(&lens(r#"<float name="focus_distance" value="0"/>"#), &[at, "`focus_distance`"]);
    let flat = r#"<transform name="to_world"><scale z="0"/></transform>"#;
    let flat = format!("<scene>\n<sensor type=\"orthographic\">{flat}</sensor></scene>");
    refuse_text(&flat, &[at, "`to_world`"]);
    let scaled = r#"<transform name="to_world"><scale value="2"/></transform>"#;
    refuse_text(&sensor(scaled), &[at, "`to_world`"]);
}

#[test]
fn colors_and_textures() {
    let bsdf = |color: &str| format!(r#"<bsdf type="diffuse">{color}</bsdf>"#);
    refuse(&bsdf(r#"<rgb name="reflectance" value="0.1, -0.2, 0"/>"#), &["negative"]);
    refuse(&bsdf(r#"<rgb name="reflectance" value="nan"/>"#), &["`nan`"]);
    refuse(&bsdf(r#"<rgb name="reflectance" value="1 2"/>"#), &["`1 2`"]);
    refuse(&bsdf(r#"<spectrum name="reflectance" value="700:1, 400:0"/>"#), &["wavelengths", "increase"]);
    refuse(&bsdf(r#"<spectrum name="reflectance" value="400:1"/>"#), &["two or more"]);
    refuse(&bsdf(r#"<spectrum name="reflectance" value="400:1, 700"/>"#), &["`700`"]);
    refuse(&bsdf(r#"<spectrum name="reflectance" filename="a.spd"/>"#), &["`a.spd`", "does not exist"]);
    let texture = r#"<texture name="reflectance" type="bitmap"><string name="filename" value="a.png"/></texture>"#;
    refuse(&bsdf(texture), &["`a.png`", "does not exist"]);
}

#[test]
fn names_and_transforms() {
    refuse(r#"<shape type="disk"><ref id="nobody"/></shape>"#, &["`nobody`"]);
    refuse("<shape type=\"disk\" id=\"a\"/><shape type=\"cube\" id=\"a\"/>", &["`a`", "already used"]);
    let twice = r#"<float name="radius" value="1"/><float name="radius" value="2"/>"#;
    refuse(&format!(r#"<shape type="sphere">{twice}</shape>"#), &["`radius`", "twice"]);
    let disk =
        |transform: &str| format!(r#"<shape type="disk"><transform name="to_world">{transform}</transform></shape>"#);
    refuse(&disk(r#"<matrix value="1 2 3"/>"#), &["16 or 9", "not 3"]);
    refuse(&disk(r#"<matrix value="1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1"/>"#), &["last row"]);
    refuse(&disk(r#"<rotate angle="1"/>"#), &["axis"]);
    refuse(&disk(r#"<lookat origin="0,0,0" target="0,1,0" up="0,1,0"/>"#), &["`up`"]);
    refuse(&disk(r#"<translate x="1e30"/><scale value="1e30"/>"#), &["range"]);
    refuse(&disk(r#"<scale value="1e30"/><scale value="1e30"/>"#), &["range"]);
    let uneven = r#"<shape type="sphere"><transform name="to_world"><scale x="2"/></transform></shape>"#;
    refuse(uneven, &["sphere"]);
}

#[test]
fn meshes() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    refuse_mesh(&format!("{vertices}f 1 2 4\n"), &["mesh.obj:4: ", "vertex index 4"]);
    refuse_mesh(&format!("{vertices}f 1 2 0\n"), &["mesh.obj:4: ", "vertex index 0"]);
    refuse_mesh(&format!("{vertices}f 1 2 -4\n"), &["mesh.obj:4: ", "vertex index -4"]);
    refuse_mesh(&format!("{vertices}vn 0 0 1\nf 1//1 2//1 3//2\n"), &["mesh.obj:5: ", "normal index 2"]);
    refuse_mesh(&format!("{vertices}vt 0 0\nf 1/1 2/1 3/9\n"), &["mesh.obj:5: ", "texture coordinate index 9"]);
    refuse_mesh(&format!("{vertices}f 1 2 3x\n"), &["mesh.obj:4: ", "`3x`"]);
    refuse_mesh("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", &["mesh.obj:2: ", "`nan`"]);
    refuse_mesh("v 0 0 0\nv 1 0 1e99\nv 0 1 0\nf 1 2 3\n", &["mesh.obj:2: ", "`1e99`"]);
    refuse_mesh("v 0 0 0\nv 1 0\n", &["mesh.obj:2: ", "3 numbers"]);
    refuse_mesh(vertices, &["mesh.obj: ", "no faces"]);
    refuse_mesh("# nothing\n", &["mesh.obj: ", "no faces: is the file cut short?"]);
}

/// One message lists every fault once, in the order of the lines.
#[test]
fn all_faults_are_listed_at_once() {
    let body = r#"<bsdf type="hk" id="a"/>
<shape type="sdfgrid"><ref id="a"/></shape>
<shape type="sphere"><bsdf type="twosided"><bsdf type="measured"/><bsdf type="irawan"/></bsdf><emitter type="laser"/></shape>
<emitter type="sky"/>
<shape type="obj"><string name="filename" value="gone.obj"/></shape>
<wheel/>
<integrator type="depth"/>
<shape type="ply"><string name="filename" value="bad.ply"/></shape>"#;
    let folder = Folder::new(&[("scene.xml", &with_sensor(body)), ("bad.ply", "no mesh")]);
    let message = folder.load(&[]).map(drop).expect_err("this should be refused").to_string();
    let lines: Vec<_> = message.lines().collect();
    assert_eq!(lines[0], "the scene has 10 faults:", "{message}");
    let expected = [
        ("bad.ply", "bad.ply"),
        ("scene.xml:2: ", "`hk`"),
        ("scene.xml:3: ", "`sdfgrid`"),
        ("scene.xml:4: ", "`measured`"),
        ("scene.xml:4: ", "`irawan`"),
        ("scene.xml:4: ", "`laser`"),
        ("scene.xml:5: ", "`sky`"),
        ("scene.xml:6: ", "`gone.obj`"),
        ("scene.xml:7: ", "<wheel>"),
        ("scene.xml:8: ", "`depth`"),
    ];
    assert_eq!(lines.len(), 1 + expected.len(), "{message}");
    for (line, (place, word)) in lines[1..].iter().zip(expected) {
        assert!(line.starts_with("  ") && line.contains(place) && line.contains(word), "{place} {word}: {line}");
    }
}
