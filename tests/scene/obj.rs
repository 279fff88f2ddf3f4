//! OBJ files: meshes written as text in many ways and read back, and lines that `tobj` alone reads differently.

use glam::{DVec3, Vec2, Vec3};
use lodestar::scene::{Primitive, Scene};
use proptest::prelude::*;

use super::load_mesh;

const PLAIN_UVS: &str = r#"<boolean name="flip_tex_coords" value="false"/>"#;
/// Numbers of positions, texture coordinates and normals of a random mesh.
const COUNTS: [u32; 3] = [12, 5, 4];

/// Corner: position, texture coordinates and normal. The last two are zero if the file has none.
type Corner = (Vec3, Vec2, Vec3);

/// Random choices, and the text that they produce.
struct Writer<'a> {
    words: std::iter::Cycle<std::iter::Copied<std::slice::Iter<'a, u32>>>,
    text: String,
}

impl Writer<'_> {
    fn one_of(&mut self, words: &[&'static str]) -> &'static str {
        words[self.below(words.len() as u32) as usize]
    }

    fn below(&mut self, limit: u32) -> u32 {
        self.words.next().unwrap_or(0) % limit
    }

    /// Writes a number in one of several ways.
    fn number(&mut self) -> f32 {
        let (value, word) = match self.below(4) {
            0 => {
                let value = self.below(2000) as f32 / 64.0 - 9.0;
                (value, format!("{value}"))
            }
            1 => {
                let value = self.below(1 << 30) as f32 / 3.0e8;
                (value, format!("{value:e}"))
            }
            2 => {
                let millionths = self.below(10_000_000);
                let value = -(f64::from(millionths) / 1.0e6) as f32;
                (value, format!("-{}.{:06}", millionths / 1_000_000, millionths % 1_000_000))
            }
            _ => {
                let value = self.below(100);
                (value as f32, format!("+{value}."))
            }
        };
        let blank = self.one_of(&[" ", "\t", "  "]);
        self.text += &format!("{blank}{word}");
        value
    }

    fn row(&mut self, keyword: &str, size: usize) -> Vec3 {
        self.text += keyword;
        let mut row = Vec3::ZERO;
        (0..size).for_each(|i| row[i] = self.number());
        let end = self.one_of(&["\n", "\r\n", " 2\n"]);
        self.text += end;
        row
    }

    /// Writes an index, counted from 1 or from the end. The returned index counts from 0.
    fn index(&mut self, count: u32) -> usize {
        let index = self.below(count);
        let is_relative = self.below(2) == 0;
        self.text += &if is_relative { format!("-{}", count - index) } else { (index + 1).to_string() };
        index as usize
    }

    /// Writes one corner. In `kinds`, 0 gives texture coordinates or normals to no corner, 1 to some, 2 to all.
    fn corner(&mut self, kinds: [u32; 2], rows: &[Vec<Vec3>; 3]) -> Corner {
        self.text += " ";
        let position = rows[0][self.index(COUNTS[0])];
        let [has_uv, has_normal] = kinds.map(|kind| kind == 2 || kind == 1 && self.below(2) == 0);
        let (mut uv, mut normal) = (Vec3::ZERO, Vec3::ZERO);
        if has_uv || has_normal {
            self.text += "/";
        }
        if has_uv {
            uv = rows[1][self.index(COUNTS[1])];
        }
        if has_normal {
            self.text += "/";
            normal = rows[2][self.index(COUNTS[2])];
        }
        (position, uv.truncate(), normal)
    }
}

/// Whether no corner turns back, so that the polygon is cut as a fan.
fn is_convex(polygon: &[Corner]) -> bool {
    let at = |i: usize| polygon[i % polygon.len()].0.as_dvec3();
    let normal: DVec3 = (1..polygon.len() - 1).map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0))).sum();
    (0..polygon.len()).all(|i| (at(i + 1) - at(i)).cross(at(i + 2) - at(i + 1)).dot(normal) >= 0.0)
}

/// Text of a random mesh, and its triangles with area.
fn random_mesh(seed: &[u32], kinds: [u32; 2]) -> (String, Vec<[Corner; 3]>) {
    let mut writer = Writer { words: seed.iter().copied().cycle(), text: String::new() };
    let rows = [("v", 3, COUNTS[0]), ("vt", 2, COUNTS[1]), ("vn", 3, COUNTS[2])]
        .map(|(keyword, size, count)| (0..count).map(|_| writer.row(keyword, size)).collect::<Vec<_>>());
    let mut triangles = Vec::new();
    for _ in 0..6 {
        let others = ["g a\n", "o b\n", "usemtl c\n", "mtllib gone.mtl\n", "# remark\n", "l 1 2 3\n", "p 1\n", "\n"];
        let other = writer.one_of(&others);
        writer.text += other;
        writer.text += "f";
        let begin = writer.text.len();
        let polygon = (0..8).find_map(|tries| {
            writer.text.truncate(begin);
            let count = if tries == 7 { 3 } else { 3 + writer.below(4) };
            let polygon: Vec<_> = (0..count).map(|_| writer.corner(kinds, &rows)).collect();
            (count == 3 || is_convex(&polygon)).then_some(polygon)
        });
        let polygon = polygon.expect("a triangle at last");
        let end = writer.one_of(&["\n", "\r\n", " # remark\n"]);
        writer.text += end;
        triangles.extend((2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]));
    }
    let has_area = |[a, b, c]: &[Corner; 3]| (b.0 - a.0).cross(c.0 - a.0).length_squared() >= f32::MIN_POSITIVE;
    triangles.retain(has_area);
    (writer.text, triangles)
}

/// Difference between a scene and the expected triangles, if there is one.
fn difference(scene: &Scene, expected: &[[Corner; 3]], [has_uvs, has_normals]: [bool; 2]) -> Option<String> {
    if scene.primitives.len() != expected.len() {
        return Some(format!("{} triangles, not {}", scene.primitives.len(), expected.len()));
    }
    let pairs = scene.primitives.iter().zip(expected);
    let differs = |(p, [a, b, c]): &(&Primitive, &[Corner; 3])| {
        let normal_differs = |(own, corner): (Vec3, &Corner)| {
            let length = corner.2.length();
            length > 0.0 && (own - corner.2 / length).length() >= 1.0e-6
        };
        [p.origin, p.edge_u, p.edge_v] != [a.0, b.0 - a.0, c.0 - a.0]
            || has_uvs && p.uvs != [a.1, b.1, c.1]
            || has_normals && p.normals.is_none_or(|normals| normals.into_iter().zip([a, b, c]).any(normal_differs))
    };
    pairs.into_iter().find(differs).map(|(p, expected)| format!("{p:?} is not {expected:?}"))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    #[test]
    fn meshes_are_read_as_they_were_written(
        seed in prop::collection::vec(any::<u32>(), 400), kinds in prop::array::uniform2(0_u32..3)
    ) {
        let (text, expected) = random_mesh(&seed, kinds);
        let scene = load_mesh(&text, PLAIN_UVS).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let found = difference(&scene, &expected, kinds.map(|kind| kind > 0));
        prop_assert!(found.is_none(), "{found:?}\n{text}");
    }

    /// The twin must fail: a file in which one corner of a triangle is moved.
    #[test]
    fn a_mesh_of_another_file_is_told_apart(seed in prop::collection::vec(any::<u32>(), 400)) {
        let (text, mut expected) = random_mesh(&seed, [2, 2]);
        let scene = load_mesh(&text, PLAIN_UVS).unwrap();
        prop_assume!(!expected.is_empty());
        let triangle = seed[0] as usize % expected.len();
        match seed[1] % 3 {
            0 => expected[triangle][1].0.x += 1.0,
            1 => expected[triangle][1].1.y += 0.5,
            _ => expected[triangle].swap(0, 1),
        }
        prop_assert!(difference(&scene, &expected, [true, true]).is_some());
    }
}

/// Lines that `tobj` alone reads differently, each beside a plain file with the same meaning.
#[test]
fn lines_that_tobj_takes_otherwise() {
    let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let expected = load_mesh(plain, "").unwrap().primitives;
    for text in [
        // A fourth number is a divisor. Six numbers are a color, which all vertices then need. Other counts are
        // refused.
        "v 0 0 0\nv 1 0 0 2\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv 1 0 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv 1 0 0 .5 .5 .5\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0 1 1\nv 1 0 0 # here\nv 0 1 0\nf 1 2 3\n",
        // `tobj` alone reads `l` lines as faces.
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\nf 1 2 3\nl 1 2\n",
        // Indices refer to later vertices, across an object.
        "f 1 2 3\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\n",
        // Some names are missing.
        "usemtl\nmtllib\ng\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 # remark\n",
        // White space differs.
        "v\x010 0 0\nv 1\x0b0 0\nv 0 1 0\r\nf 1\t2 3\r\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1",
    ] {
        let scene = load_mesh(text, "").unwrap_or_else(|error| panic!("{error}\n{text}"));
        let corners = |p: &Primitive| (p.origin, p.edge_u, p.edge_v, p.normals, p.uvs);
        assert_eq!(scene.primitives.iter().map(corners).collect::<Vec<_>>(), [corners(&expected[0])], "{text}");
    }
}

#[test]
fn what_tobj_passes_over_is_refused() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
    for (lines, part) in [
        ("f 1/0/1 2/1/1 3/1/1", "texture coordinate index 0"),
        ("f 1/1/1 2/1/1 3/1/-2", "normal index -2"),
        ("f 1/1/1/ 2/1/1 3/1/1", "too many indices"),
        ("f 1/9223372036854775808/1 2/1/1 3/1/1", "texture coordinate index 9223372036854775808"),
        ("f 1/1/6148914691236517207 2/1/1 3/1/1", "normal index 6148914691236517207"),
        ("vt inf 0", "`inf`"),
        ("vn 0 0 1000000000000000000000000000000000000000", "is not a finite number"),
    ] {
        let error = load_mesh(&format!("{vertices}{lines}\nf 1 2 3\n"), "").map(drop).expect_err(lines).to_string();
        assert!(error.contains("mesh.obj:6: ") && error.contains(part), "{lines}: {error}");
    }
    // Without texture coordinates, `tobj` ignores indices of them.
    let error = load_mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n", "").map(drop).expect_err("none").to_string();
    assert!(error.contains("mesh.obj:4: texture coordinate index 1 is out of range; the file has 0"), "{error}");
}

#[test]
fn a_face_may_refer_to_what_stands_below() {
    let scene = load_mesh("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", "").unwrap();
    assert_eq!(scene.primitives.len(), 1);
}

#[test]
fn many_vertices_at_one_position() {
    let mut text = "v 0 0 0\n".to_string();
    for i in 0..100 {
        let angle = i as f32 * 0.01;
        text += &format!("v {} {} 0\nvt 0.5 {}\n", angle.cos(), angle.sin(), i as f32 / 128.0);
    }
    for i in 0..99 {
        text += &format!("f 1/{0} {1}/{0} {2}/{0}\n", i + 1, i + 2, i + 3);
        text += &format!("f 1/{0} {2}/{0} {1}/{0}\n", i + 1, i + 2, i + 3);
    }
    let scene = load_mesh(&text, r#"<boolean name="flip_tex_coords" value="false"/>"#).unwrap();
    assert_eq!(scene.primitives.len(), 198);
    for (i, pair) in scene.primitives.chunks(2).enumerate() {
        assert!(pair.iter().all(|p| p.uvs[0] == Vec2::new(0.5, i as f32 / 128.0)));
        // The two faces at each seam cancel, so no vertex there has a smooth normal.
        assert!(pair[0].normals.unwrap().iter().all(|n| n.abs_diff_eq(Vec3::Z, 1.0e-6)));
    }
}
