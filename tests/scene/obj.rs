//! OBJ files, against `tobj`'s reading of the same text.

use glam::{Vec2, Vec3};
use proptest::prelude::*;

use super::load_mesh;

/// A mesh as text, whose faces have three to six corners, each with the indices that `kinds` asks for.
fn text(seed: &[u32], kinds: (bool, bool), grouped: bool) -> String {
    let mut words = seed.iter().copied().cycle();
    let mut next = |limit: u32| words.next().unwrap_or(0) % limit;
    let mut text = String::new();
    let number = |next: &mut dyn FnMut(u32) -> u32| match next(4) {
        0 => format!("{}", next(2000) as f32 / 64.0 - 9.0),
        1 => format!("{:e}", f64::from(next(1 << 30)) / 3.0e8),
        2 => format!("-{}.{:06}", next(10), next(1_000_000)),
        _ => format!("+{}.", next(100)),
    };
    for (keyword, count, size) in [("v", 12, 3), ("vt", 5, 2), ("vn", 4, 3)] {
        for _ in 0..count {
            let numbers: Vec<_> = (0..size).map(|_| number(&mut next)).collect();
            text += &format!("{keyword}  {}\n", numbers.join("\t"));
        }
    }
    for _ in 0..6 {
        if grouped {
            text += ["g a\n", "s 1\n", "# remark\n", "\n"][next(4) as usize];
        }
        text += "f";
        for _ in 0..3 + next(4) {
            let index = |next: &mut dyn FnMut(u32) -> u32, count: u32| match next(2) {
                0 => (1 + next(count)).to_string(),
                _ => format!("-{}", 1 + next(count)),
            };
            text += &match kinds {
                (false, false) => format!(" {}", index(&mut next, 12)),
                (true, false) => format!(" {}/{}", index(&mut next, 12), index(&mut next, 5)),
                (false, true) => format!(" {}//{}", index(&mut next, 12), index(&mut next, 4)),
                (true, true) => {
                    format!(" {}/{}/{}", index(&mut next, 12), index(&mut next, 5), index(&mut next, 4))
                }
            };
        }
        text += "\r\n";
    }
    text
}

/// Corners (position, texture coordinates, normal) of all triangles that have area, in `tobj`'s reading.
fn oracle(text: &str) -> Vec<[(Vec3, Vec2, Vec3); 3]> {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let (models, _) =
        tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| Ok(Default::default())).expect("tobj reads it");
    let corner = |mesh: &tobj::Mesh, at: usize| {
        let take = |values: &[f32], index: Option<&u32>, size: usize| {
            let first = index.map_or(0, |&index| index as usize * size);
            values.get(first..first + size).map_or([0.0; 3], |v| [v[0], v[1], v.get(2).copied().unwrap_or(0.0)])
        };
        let position: Vec3 = take(&mesh.positions, mesh.indices.get(at), 3).into();
        let uv: Vec3 = take(&mesh.texcoords, mesh.texcoord_indices.get(at), 2).into();
        (position, uv.truncate(), Vec3::from(take(&mesh.normals, mesh.normal_indices.get(at), 3)))
    };
    let triangles = models
        .iter()
        .flat_map(|model| (0..model.mesh.indices.len() / 3).map(|i| [0, 1, 2].map(|k| corner(&model.mesh, 3 * i + k))));
    let has_area =
        |[a, b, c]: &[(Vec3, Vec2, Vec3); 3]| (b.0 - a.0).cross(c.0 - a.0).length_squared() >= f32::MIN_POSITIVE;
    triangles.filter(has_area).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    #[test]
    fn meshes_are_those_of_tobj(
        seed in prop::collection::vec(any::<u32>(), 400), uvs: bool, normals: bool, grouped: bool
    ) {
        let text = text(&seed, (uvs, normals), grouped);
        let expected = oracle(&text);
        let options = r#"<boolean name="flip_tex_coords" value="false"/>"#;
        let scene = match load_mesh(&text, options) {
            Ok(scene) => scene,
            Err(error) => panic!("{error}\n{text}"),
        };
        prop_assert_eq!(scene.primitives.len(), expected.len());
        for (p, [a, b, c]) in scene.primitives.iter().zip(&expected) {
            prop_assert_eq!([p.origin, p.edge_u, p.edge_v], [a.0, b.0 - a.0, c.0 - a.0]);
            if uvs {
                prop_assert_eq!(p.uvs, [a.1, b.1, c.1]);
            }
            if normals {
                for (own, corner) in p.normals.unwrap().iter().zip([a, b, c]) {
                    let length = corner.2.length();
                    prop_assert!(length == 0.0 || (*own - corner.2 / length).length() < 1.0e-6);
                }
            }
        }
    }
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
        // The two faces at each seam cancel out, so none has a smooth normal.
        assert!(pair[0].normals.unwrap().iter().all(|n| n.abs_diff_eq(Vec3::Z, 1.0e-6)));
    }
}
