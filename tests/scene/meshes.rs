//! PLY and serialized meshes, groups and instances, against plain geometry and Mitsuba 3.9's answers (noted by hand).

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::{Vec2, Vec3};
use lodestar::Result;
use lodestar::scene::{Primitive, PrimitiveShape, Scene};

use super::{Folder, load_body, with_sensor};

/// Loads a shape `plugin` whose file `mesh` has this content.
pub fn load_bytes(plugin: &str, content: &[u8], parameters: &str) -> Result<Scene> {
    let shape = format!(r#"<shape type="{plugin}"><string name="filename" value="mesh"/>{parameters}</shape>"#);
    let folder = Folder::new(&[("scene.xml", &with_sensor(&shape))]);
    folder.write("mesh", content);
    folder.load(&[])
}

#[track_caller]
fn refuse(plugin: &str, content: &[u8], parameters: &str, parts: &[&str]) {
    let error = load_bytes(plugin, content, parameters).map(drop).expect_err("this should be refused").to_string();
    for part in parts {
        assert!(error.contains(part), "`{part}` is missing in: {error}");
    }
}

/// Vertices of two triangles that share two of them: position, normal, texture coordinates.
const VERTICES: [[f32; 8]; 4] = [
    [0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.1, 0.2],
    [1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.3, 0.4],
    [1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.6],
    [0.0, 1.0, 0.5, 0.25, 0.0, 1.0, 0.7, 0.8],
];

fn assert_is_the_mesh(scene: &Scene) {
    let vertex = |i: usize| VERTICES[i];
    let position = |i: usize| Vec3::from_slice(&vertex(i)[..3]);
    assert_eq!(scene.primitives.len(), 2);
    for (p, [a, b, c]) in scene.primitives.iter().zip([[0, 1, 2], [0, 2, 3]]) {
        assert_eq!([p.origin, p.edge_u, p.edge_v], [position(a), position(b) - position(a), position(c) - position(a)]);
        for (own, i) in p.normals.unwrap().into_iter().zip([a, b, c]) {
            assert!(own.abs_diff_eq(Vec3::from_slice(&vertex(i)[3..6]).normalize(), 1.0e-6));
        }
        assert_eq!(p.uvs, [a, b, c].map(|i| Vec2::from_slice(&vertex(i)[6..])));
    }
}

const PLY_HEADER: &str = "comment of no weight\nelement remark 2\nproperty uchar a\nproperty list uchar short b\n\
    element vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\nproperty float nx\n\
    property float ny\nproperty float nz\nproperty float s\nproperty float t\nelement face 1\n\
    property list uchar int vertex_indices\nproperty float quality\nelement end 1\nproperty int c\nend_header\n";

pub fn ascii_ply() -> Vec<u8> {
    let mut text = format!("ply\r\nformat ascii 1.0\r\n{PLY_HEADER}7 0\n8 2 -5 -6\n");
    for [x, y, z, nx, ny, nz, u, v] in VERTICES {
        text += &format!("{x} {y} {z} 255 {nx} {ny} {nz}\n{u} {v}\n");
    }
    (text + "4 0 1 2 3 0.5\n9\n").into_bytes()
}

pub fn binary_ply(is_big_endian: bool) -> Vec<u8> {
    let order = if is_big_endian { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{PLY_HEADER}").into_bytes();
    let mut put = |little: &[u8]| match is_big_endian {
        true => bytes.extend(little.iter().rev()),
        false => bytes.extend(little),
    };
    [&[7][..], &[0], &[8], &[2], &(-5_i16).to_le_bytes(), &(-6_i16).to_le_bytes()].into_iter().for_each(&mut put);
    for [x, y, z, nx, ny, nz, u, v] in VERTICES {
        [x, y].iter().for_each(|number| put(&number.to_le_bytes()));
        put(&f64::from(z).to_le_bytes());
        put(&[255]);
        [nx, ny, nz, u, v].iter().for_each(|number| put(&number.to_le_bytes()));
    }
    put(&[4]);
    [0_i32, 1, 2, 3].iter().for_each(|index| put(&index.to_le_bytes()));
    put(&0.5_f32.to_le_bytes());
    put(&9_i32.to_le_bytes());
    bytes
}

#[test]
fn ply_of_any_encoding() {
    for bytes in [ascii_ply(), binary_ply(false), binary_ply(true)] {
        assert_is_the_mesh(&load_bytes("ply", &bytes, "").unwrap());
    }
    let flip = r#"<boolean name="flip_tex_coords" value="true"/>"#;
    assert_eq!(load_bytes("ply", &ascii_ply(), flip).unwrap().primitives[0].uvs[0], Vec2::new(0.1, 1.0 - 0.2));
}

#[test]
fn ply_files_that_lie() {
    let text = |from: &str, to: &str| String::from_utf8(ascii_ply()).unwrap().replace(from, to);
    let early = "too early";
    for (element, from, says) in
        [("vertex", "vertex 4", early), ("face", "face 1", "the header promises"), ("end", "end 1", early)]
    {
        let lie = text(from, &format!("{element} 18446744073709551615"));
        refuse("ply", lie.as_bytes(), "", &["mesh:3", says, "18446744073709551615", element]);
    }
    let header = PLY_HEADER.replace("remark 2", "remark 18446744073709551615");
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let lie = format!("ply\nformat {format} 1.0\n{header}");
        refuse("ply", lie.as_bytes(), "", &["mesh", "too early", "18446744073709551615 of the element `remark`"]);
    }
    let cut = &binary_ply(false)[..binary_ply(false).len() - 12];
    refuse("ply", cut, "", &["mesh", "too early", "`face`"]);
    refuse("ply", text("4 0 1 2 3", "4294967295 0 1 2 3").as_bytes(), "", &["mesh:33: ", "0.5 is not"]);
    refuse("ply", text("4 0 1 2 3", "4 0 1 2 4").as_bytes(), "", &["mesh:33: ", "vertex index 4"]);
    refuse("ply", text("4 0 1 2 3", "4 0 1 2 -3").as_bytes(), "", &["mesh:33: ", "-3"]);
    refuse("ply", text("4 0 1 2 3", "2 0 1").as_bytes(), "", &["the 1 faces of the mesh are points or lines"]);
    refuse("ply", text("1 0 0 255", "1 nan 0 255").as_bytes(), "", &["mesh:27: ", "`NaN`"]);
    refuse("ply", text("float x", "real x").as_bytes(), "", &["mesh:8: ", "`real`"]);
    refuse("ply", text("property float x\n", "").as_bytes(), "", &["lacks x"]);
    refuse("ply", text("end_header", "end").as_bytes(), "", &["mesh:", "`end`"]);
    refuse("ply", text("ascii", "gzip").as_bytes(), "", &["mesh:2: ", "`gzip`"]);
    refuse("ply", b"solid cube\n", "", &["not a PLY file"]);
    refuse("ply", b"ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n", "", &["no faces"]);
}

/// Mesh of a serialized file. `flags` selects its arrays.
fn serialized_mesh(version: u16, flags: u32) -> Vec<u8> {
    compressed(version, &serialized_content(version, flags))
}

pub fn serialized_content(version: u16, flags: u32) -> Vec<u8> {
    let mut bytes = flags.to_le_bytes().to_vec();
    if version == 4 {
        bytes.extend(b"name\0");
    }
    bytes.extend(4_u64.to_le_bytes());
    bytes.extend(2_u64.to_le_bytes());
    let mut put = |range: std::ops::Range<usize>| {
        for number in VERTICES.iter().flat_map(|vertex| &vertex[range.clone()]) {
            match flags & 0x2000 {
                0 => bytes.extend(number.to_le_bytes()),
                _ => bytes.extend(f64::from(*number).to_le_bytes()),
            }
        }
    };
    put(0..3);
    if flags & 1 != 0 {
        put(3..6);
    }
    if flags & 2 != 0 {
        put(6..8);
    }
    if flags & 8 != 0 {
        put(3..6);
    }
    [0_u32, 1, 2, 0, 2, 3].iter().for_each(|index| bytes.extend(index.to_le_bytes()));
    bytes
}

pub fn compressed(version: u16, content: &[u8]) -> Vec<u8> {
    let header = [0x041c_u16.to_le_bytes(), version.to_le_bytes()].concat();
    let mut encoder = ZlibEncoder::new(header, Compression::default());
    encoder.write_all(content).unwrap();
    encoder.finish().unwrap()
}

pub fn serialized(version: u16, meshes: &[Vec<u8>]) -> Vec<u8> {
    let (mut bytes, mut table) = (Vec::new(), Vec::new());
    for mesh in meshes {
        match version {
            3 => table.extend((bytes.len() as u32).to_le_bytes()),
            _ => table.extend((bytes.len() as u64).to_le_bytes()),
        }
        bytes.extend(mesh);
    }
    [bytes, table, (meshes.len() as u32).to_le_bytes().to_vec()].concat()
}

fn shape_index(index: u32) -> String {
    format!(r#"<integer name="shape_index" value="{index}"/>"#)
}

#[test]
fn serialized_meshes() {
    for version in [3, 4] {
        for flags in [0x1003, 0x100b, 0x2003, 0x200b, 0x1013] {
            let bytes = serialized(version, &[serialized_mesh(version, 0x1000), serialized_mesh(version, flags)]);
            let scene = load_bytes("serialized", &bytes, &shape_index(1)).unwrap();
            assert_is_the_mesh(&scene);
        }
        let one = serialized_mesh(version, 0x1000);
        let scene = load_bytes("serialized", &one, "").unwrap();
        // The normals are Mitsuba's smooth normals of these two triangles.
        let expected = [Vec3::new(0.2270, -0.2270, 0.9470), Vec3::Z, Vec3::new(0.2270, -0.2270, 0.9470)];
        for (own, expected) in scene.primitives[0].normals.unwrap().into_iter().zip(expected) {
            assert!(own.abs_diff_eq(expected, 1.0e-4), "{own}");
        }
    }
}

#[test]
fn serialized_files_that_lie() {
    let good = serialized(4, &[serialized_mesh(4, 0x1003), serialized_mesh(4, 0x1003)]);
    refuse("serialized", &good[..60], "", &["too early or is damaged"]);
    refuse("serialized", &good, &shape_index(2), &["`shape_index` 2", "2 meshes"]);
    refuse("serialized", &good[..good.len() - 2], &shape_index(1), &["mesh"]);
    refuse("serialized", &[&good[..], &[255; 4]].concat(), &shape_index(1), &["cut short"]);
    refuse("serialized", b"ply", "", &["not a serialized mesh"]);
    refuse("serialized", &[&[0x1c, 4, 9, 0][..], &good[4..]].concat(), "", &["version 9"]);
    let counts = |vertices: u64, triangles: u64| {
        compressed(
            4,
            &[&0x1000_u32.to_le_bytes()[..], b"\0", &vertices.to_le_bytes(), &triangles.to_le_bytes()].concat(),
        )
    };
    refuse("serialized", &counts(u64::MAX, 1), "", &["18446744073709551615 vertices"]);
    refuse("serialized", &counts(3, u64::MAX), "", &["18446744073709551615 triangles"]);
    refuse("serialized", &counts(100_000_000, 1), "", &["too early"]);
    refuse("serialized", &counts(0, 0), "", &["no faces"]);
}

#[test]
fn a_million_bad_indices() {
    let text =
        format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 4000000000\nf -9 99999999999999999999 0\n".repeat(500_000));
    refuse("obj", text.as_bytes(), "", &["mesh:4: ", "vertex index 4000000000", "the file has 3"]);
}

fn normal(p: &Primitive) -> Vec3 {
    let normal = p.edge_u.cross(p.edge_v).normalize();
    if p.flip_normal { -normal } else { normal }
}

fn instance(member: &str, transform: &str) -> Vec<Primitive> {
    let body = format!(
        r#"<shape type="instance"><ref id="group"/><transform name="to_world">{transform}</transform></shape>
           <shape type="shapegroup" id="group">{member}</shape>"#
    );
    let folder =
        Folder::new(&[("scene.xml", &with_sensor(&body)), ("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
    folder.load(&[]).unwrap().primitives
}

#[test]
fn instances_are_copies_in_their_places() {
    let body = r#"<shape type="shapegroup" id="group">
            <bsdf type="diffuse" id="red"/>
            <shape type="rectangle"><ref id="red"/><transform name="to_world"><scale value="2"/></transform></shape>
            <shape type="sphere"/></shape>
        <shape type="instance"><ref id="group"/></shape>
        <shape type="instance"><ref id="group"/><transform name="to_world"><scale value="3"/><translate z="5"/></transform></shape>"#;
    // A group holds shapes. Materials stand outside or within shapes.
    assert!(load_body(body).is_err());
    let body = body.replace(r#"<bsdf type="diffuse" id="red"/>"#, "");
    let scene = load_body(&format!(r#"<bsdf type="diffuse" id="red"/>{body}"#)).unwrap();
    let places: Vec<_> = scene.primitives.iter().map(|p| (p.origin, p.edge_u.length(), p.material)).collect();
    let far = Vec3::new(0.0, 0.0, 5.0);
    assert_eq!(places, [(Vec3::ZERO, 2.0, 0), (Vec3::ZERO, 1.0, 1), (far, 6.0, 0), (far, 3.0, 1)]);
}

/// Mirrored instances face as in Mitsuba, which transforms normals with an instance, even those that a mirrored mesh
/// has computed.
#[test]
fn mirrored_instances_face_as_in_mitsuba() {
    let mirror = r#"<scale x="-1"/>"#;
    let mesh = |parameters: &str| {
        format!(r#"<shape type="obj"><string name="filename" value="mesh.obj"/>{parameters}</shape>"#)
    };
    let own = format!(r#"<transform name="to_world">{mirror}</transform>"#);
    let face_normals = r#"<boolean name="face_normals" value="true"/>"#;
    for (member, expected) in [
        (mesh(""), Vec3::Z),
        (mesh(face_normals), Vec3::Z),
        (mesh(&own), -Vec3::Z),
        (mesh(&[&own, face_normals].concat()), -Vec3::Z),
        (r#"<shape type="rectangle"/>"#.to_string(), Vec3::Z),
        (r#"<shape type="disk"><boolean name="flip_normals" value="true"/></shape>"#.to_string(), -Vec3::Z),
    ] {
        let copies = instance(&member, mirror);
        assert!(normal(&copies[0]).abs_diff_eq(expected, 1.0e-6), "{member}");
        assert!(copies[0].normals.is_none_or(|normals| normals[0].abs_diff_eq(expected, 1.0e-6)), "{member}");
    }
    assert!(!instance(r#"<shape type="sphere"/>"#, mirror)[0].flip_normal);
}

#[test]
fn instances_and_groups_that_make_no_sense() {
    let refused = |body: &str, part: &str| {
        let error = load_body(body).map(drop).expect_err("this should be refused").to_string();
        assert!(error.contains(part), "`{part}` is missing in: {error}");
    };
    refused(r#"<shape type="instance"/>"#, "needs a <ref> to a `shapegroup`");
    refused(r#"<shape type="disk" id="a"/><shape type="instance"><ref id="a"/></shape>"#, "needs a <ref>");
    let group = |member: &str| format!(r#"<shape type="shapegroup" id="a">{member}</shape>"#);
    refused(&group(r#"<shape type="shapegroup"/>"#), "cannot stand inside");
    refused(&group(r#"<shape type="instance"><ref id="a"/></shape>"#), "cannot stand inside");
    let moving = r#"<shape type="disk"><animation name="to_world"><transform time="0"/></animation></shape>"#;
    refused(&group(moving), "a shape in a `shapegroup` cannot move; move the `instance`");
    let uneven = r#"<shape type="instance"><ref id="a"/><transform name="to_world"><scale x="2"/></transform></shape>"#;
    refused(&[&group(r#"<shape type="sphere"/>"#), uneven].concat(), "unevenly");
    // Spheres are always copied. A thousand instances of slightly more than a thousand exceed the limit of 2^20 shapes.
    let many = group(&r#"<shape type="sphere"/>"#.repeat(1100));
    refused(&(many + &r#"<shape type="instance"><ref id="a"/></shape>"#.repeat(1000)), "more than 1048576 shapes");
}

/// Folder of a scene of this body, and a mesh of so many triangles.
fn with_mesh(body: &str, triangles: usize) -> Folder {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_string() + &"f 1 2 3\n".repeat(triangles);
    Folder::new(&[("scene.xml", &with_sensor(body)), ("mesh.obj", &mesh)])
}

const MESH: &str = r#"<shape type="obj"><string name="filename" value="mesh.obj"/></shape>"#;

#[test]
fn more_triangles_than_fit_are_refused_before_they_are_made() {
    // Each mesh is mirrored, so that it is a copy of its own.
    let mirrored = MESH.replace("</shape>", r#"<transform name="to_world"><scale x="-1"/></transform></shape>"#);
    let error = with_mesh(&mirrored.repeat(1000), 40_000).load(&[]).map(drop);
    let error = error.expect_err("40 million are too many").to_string();
    assert!(error.contains("no more than 33554432 fit"), "{error}");
}

/// Headers of PLY files tell that there are too many faces, before a file is read. The files end after their headers.
#[test]
fn ply_files_of_too_many_faces_are_refused_by_their_headers() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
               element face 15000000\nproperty list uchar int vertex_indices\nend_header\n";
    let shape = |name: &str| format!(r#"<shape type="ply"><string name="filename" value="{name}"/></shape>"#);
    let names = ["a.ply", "b.ply", "c.ply", "d.ply"];
    let body = names.map(shape).join("\n");
    let scene = with_sensor(&body);
    let files: Vec<_> = [("scene.xml", &scene[..])].into_iter().chain(names.map(|name| (name, ply))).collect();
    let folder = Folder::new(&files);
    let error = folder.load(&[]).map(drop).expect_err("60 million are too many").to_string();
    let sentence = "c.ply the scene has 45000000 triangles or more, and 60000000 or more with all meshes; no more than 33554432 fit";
    assert!(error.contains("scene.xml:") && error.contains(sentence), "{error}");
    // A file that alone has too many says so.
    let alone = ply.replace("15000000", "40000000") + "0 0 0\n";
    let body = shape("a.ply");
    let error = Folder::new(&[("scene.xml", &with_sensor(&body)), ("a.ply", &alone)]).load(&[]).map(drop);
    let error = error.expect_err("40 million are too many").to_string();
    assert!(error.contains("the header promises 40000000 faces; no more than 33554432 fit a scene"), "{error}");
    // A file counts once, whatever number of shapes shows it.
    let body = shape("a.ply").repeat(10);
    let error = Folder::new(&[("scene.xml", &with_sensor(&body)), ("a.ply", ply)]).load(&[]).map(drop);
    let error = error.expect_err("the file ends too early").to_string();
    assert!(error.contains("a.ply") && !error.contains("fit"), "{error}");
}

/// The head of a serialized mesh tells its number of triangles, too.
#[test]
fn serialized_meshes_of_too_many_triangles_are_refused_by_their_heads() {
    let counts = [3_u64, 40_000_000].map(u64::to_le_bytes).concat();
    let content = [&0x1000_u32.to_le_bytes()[..], &counts].concat();
    let error = load_bytes("serialized", &compressed(3, &content), "").map(drop).unwrap_err().to_string();
    assert!(error.contains("40000000 triangles or more, and 40000000 or more with all meshes"), "{error}");
}

/// Instances of a large group are kept, but for those that have no inverse. Spheres are copied.
#[test]
fn instances_of_large_groups_are_kept() {
    let group =
        format!(r#"<shape type="shapegroup" id="a">{MESH}<shape type="sphere"/><shape type="rectangle"/></shape>"#);
    let instance = |transform: &str| {
        format!(r#"<shape type="instance"><ref id="a"/><transform name="to_world">{transform}</transform></shape>"#)
    };
    let body = group + &instance(r#"<translate x="7"/>"#).repeat(999) + &instance(r#"<scale x="-1"/>"#);
    let scene = with_mesh(&body, 40_000).load(&[]).unwrap();
    assert_eq!((scene.primitives.len(), scene.groups.len(), scene.instances.len()), (1000, 1, 1000));
    assert!(scene.primitives.iter().all(|primitive| primitive.shape == PrimitiveShape::Sphere));
    assert_eq!(scene.groups[0].primitives.len(), 40_001);
    assert_eq!(scene.shown_primitives(), 1000 + 1000 * 40_001);
    assert_eq!(scene.instances[0].origin, Vec3::new(7.0, 0.0, 0.0));
    assert_eq!(scene.instances[999].axes[0], -Vec3::X);
    assert_eq!(scene.bounds().unwrap().1, Vec3::new(8.0, 1.0, 1.0));
    // A transform that flattens the group leaves a copy, without what has no area.
    let group = format!(r#"<shape type="shapegroup" id="a">{MESH}<shape type="rectangle"/></shape>"#);
    let flattened = instance(r#"<scale z="0"/>"#);
    let body = group + &instance("").repeat(100) + &flattened;
    let scene = with_mesh(&body, 20_000).load(&[]).unwrap();
    assert_eq!((scene.primitives.len(), scene.instances.len()), (20_001, 100));
}

/// Shapes that show the same mesh become instances where copies would be many: not those that are mirrored, have another material, emit
/// or are invisible to the camera.
#[test]
fn shapes_that_share_a_mesh_become_instances() {
    let shape = |inside: &str| MESH.replace("</shape>", &format!("{inside}</shape>"));
    let moved = shape(r#"<transform name="to_world"><scale value="2"/><translate y="3"/></transform>"#);
    let others = [
        shape(r#"<transform name="to_world"><scale y="-1"/></transform>"#),
        shape(r#"<bsdf type="conductor"/>"#),
        shape(r#"<emitter type="area"/>"#),
        shape(r#"<boolean name="face_normals" value="true"/>"#),
        shape(r#"<boolean name="visible_to_camera" value="false"/>"#),
    ];
    let body = moved.repeat(300) + &others.concat();
    let scene = with_mesh(&body, 4000).load(&[]).unwrap();
    assert_eq!((scene.primitives.len(), scene.groups.len(), scene.instances.len()), (5 * 4000, 1, 300));
    assert_eq!(scene.primitives.iter().filter(|primitive| primitive.unseen).count(), 4000);
    assert_eq!((scene.instances[5].origin, scene.instances[5].axes[1]), (3.0 * Vec3::Y, 2.0 * Vec3::Y));
    // Few stay copies.
    let scene = with_mesh(&moved.repeat(200), 4000).load(&[]).unwrap();
    assert_eq!((scene.primitives.len(), scene.instances.len()), (200 * 4000, 0));
}

/// A mesh is met from both sides, unless it says otherwise. One that bounds a medium cannot.
#[test]
fn meshes_may_be_met_from_their_front_only() {
    for (value, is_front) in [("", false), ("false", false), ("true", true)] {
        let parameter = match value {
            "" => String::new(),
            value => format!(r#"<boolean name="front_only" value="{value}"/>"#),
        };
        let scene = with_mesh(&MESH.replace("</shape>", &format!("{parameter}</shape>")), 2).load(&[]).unwrap();
        assert!(scene.primitives.iter().all(|primitive| primitive.front_only == is_front), "{value}");
        assert!(scene.warnings.iter().all(|warning| !warning.contains("front_only")), "{:?}", scene.warnings);
        let medium = r#"<medium name="interior" type="homogeneous"/>"#;
        let body = MESH.replace("</shape>", &format!("{parameter}{medium}</shape>"));
        let error = with_mesh(&body, 2).load(&[]).map(drop).err().map(|error| error.to_string()).unwrap_or_default();
        assert_eq!(error.contains("`front_only`"), is_front, "{error}");
    }
}

/// A normal that is no number counts as none: the vertex has the face's.
#[test]
fn normals_that_are_no_numbers() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    let ply = format!("{header}0 0 0 nan nan nan\n1 0 0 0 0.6 0.8\n0 1 0 0 inf 0\n3 0 1 2\n");
    let scene = load_bytes("ply", ply.as_bytes(), "").unwrap();
    let normals = scene.primitives[0].normals.unwrap();
    assert_eq!([normals[0], normals[2]], [glam::Vec3::Z; 2]);
    assert!((normals[1] - glam::Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
}
