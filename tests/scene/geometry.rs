//! Geometry of loaded shapes, against Mitsuba 3.9's answers for the same XML (noted by hand) and against plain
//! geometry.

use glam::{Vec2, Vec3};
use lodestar::scene::{Primitive, PrimitiveShape};

use super::{Folder, load_body, load_mesh, with_sensor};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const TRIANGLE_WITH_NORMALS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nf 1//1 2//1 3//1\n";
const MIRROR: &str = r#"<transform name="to_world"><scale x="-1"/></transform>"#;
const FLIP: &str = r#"<boolean name="flip_normals" value="true"/>"#;

fn normal(primitive: &Primitive) -> Vec3 {
    let normal = primitive.edge_u.cross(primitive.edge_v).normalize();
    if primitive.flip_normal { -normal } else { normal }
}

fn shape(plugin: &str, parameters: &str) -> Vec<Primitive> {
    load_body(&format!(r#"<shape type="{plugin}">{parameters}</shape>"#)).unwrap().primitives
}

#[test]
fn operations_apply_in_the_order_they_are_written() {
    let transform = r#"<transform name="to_world">
        <matrix value="1 0 0 0, 0 1 0 0, 0 0 1 -1.0e-000, 0 0 0 1"/>
        <scale value="2"/><rotate z="1" angle="90"/><translate x="1" y="2" z="3"/></transform>"#;
    let [rectangle] = shape("rectangle", transform)[..] else { panic!() };
    assert!(rectangle.origin.abs_diff_eq(Vec3::new(1.0, 2.0, 1.0), 1e-6));
    assert!(rectangle.edge_u.abs_diff_eq(Vec3::new(0.0, 2.0, 0.0), 1e-6));
    assert!(rectangle.edge_v.abs_diff_eq(Vec3::new(-2.0, 0.0, 0.0), 1e-6));
}

#[test]
fn a_matrix_is_given_by_rows() {
    let by_nine = shape("rectangle", r#"<transform name="to_world"><matrix value="0 -1 0 1 0 0 0 0 1"/></transform>"#);
    assert_eq!(by_nine[0].edge_u, Vec3::Y);
    assert_eq!(by_nine[0].edge_v, -Vec3::X);
}

/// Flat shapes face along their shading normal (0, 0, 1), as in Mitsuba. Only `flip_normals` negates it.
#[test]
fn flat_shapes_face_where_their_normal_goes() {
    for plugin in ["rectangle", "disk"] {
        for (parameters, expected) in [
            (String::new(), Vec3::Z),
            (MIRROR.into(), Vec3::Z),
            (FLIP.into(), -Vec3::Z),
            ([MIRROR, FLIP].concat(), -Vec3::Z),
        ] {
            assert_eq!(normal(&shape(plugin, &parameters)[0]), expected, "{plugin} {parameters}");
        }
    }
}

#[test]
fn a_cube_faces_outward_also_in_a_mirror() {
    for parameters in ["", MIRROR] {
        let faces = shape("cube", parameters);
        assert_eq!(faces.len(), 6);
        for face in faces {
            assert_eq!(face.shape, PrimitiveShape::Parallelogram);
            assert_eq!(normal(&face), face.origin);
        }
    }
}

/// Textures lie on a cube as in Mitsuba 3.9: the vertices with uv (0, 0), (1, 0) and (0, 1) of each face.
#[test]
fn textures_lie_on_a_cube_as_in_mitsuba() {
    let corners = [
        [(-1, -1, -1), (-1, -1, 1), (1, -1, -1)],
        [(1, 1, 1), (-1, 1, 1), (1, 1, -1)],
        [(1, -1, 1), (1, 1, 1), (1, -1, -1)],
        [(-1, -1, 1), (-1, 1, 1), (1, -1, 1)],
        [(-1, -1, -1), (-1, 1, -1), (-1, -1, 1)],
        [(-1, 1, -1), (-1, -1, -1), (1, 1, -1)],
    ];
    for (face, corners) in shape("cube", "").iter().zip(corners) {
        let corners = corners.map(|(x, y, z)| Vec3::new(x as f32, y as f32, z as f32));
        for (corner, (u, v)) in corners.into_iter().zip([(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]) {
            assert_eq!(face.origin + u * face.edge_u + v * face.edge_v, corner);
        }
    }
}

#[test]
fn spheres() {
    let parameters = r#"<point name="center" x="1" y="2" z="3"/><float name="radius" value="0.5"/>
        <transform name="to_world"><scale value="4"/><translate z="1"/></transform>"#;
    let [sphere] = shape("sphere", parameters)[..] else { panic!() };
    assert_eq!(
        (sphere.origin, sphere.edge_u, sphere.edge_v),
        (Vec3::new(4.0, 8.0, 13.0), 2.0 * Vec3::X, 2.0 * Vec3::Z)
    );
    assert_eq!(sphere.bounds(), (Vec3::new(2.0, 6.0, 11.0), Vec3::new(6.0, 10.0, 15.0)));
    let flips =
        ["", MIRROR, FLIP, &[MIRROR, FLIP].concat()].map(|parameters| shape("sphere", parameters)[0].flip_normal);
    assert_eq!(flips, [false, true, true, false]);
}

/// A mirrored mesh faces as in Mitsuba: a mirror turns computed normals, but not normals from the file.
#[test]
fn a_mirrored_mesh_faces_as_in_mitsuba() {
    for (obj, parameters, expected) in [
        (TRIANGLE, "", Vec3::Z),
        (TRIANGLE, MIRROR, -Vec3::Z),
        (TRIANGLE, FLIP, -Vec3::Z),
        (TRIANGLE_WITH_NORMALS, "", Vec3::Z),
        (TRIANGLE_WITH_NORMALS, MIRROR, Vec3::Z),
        (TRIANGLE_WITH_NORMALS, FLIP, -Vec3::Z),
    ] {
        let [triangle] = load_mesh(obj, parameters).unwrap().primitives[..] else { panic!() };
        assert_eq!(triangle.normals, Some([expected; 3]), "{obj} {parameters}");
        assert_eq!(normal(&triangle), expected);
    }
    let face_normals = r#"<boolean name="face_normals" value="true"/>"#;
    let scene = load_mesh(TRIANGLE_WITH_NORMALS, &[MIRROR, face_normals].concat()).unwrap();
    assert_eq!(scene.primitives[0].normals, None);
    assert_eq!(normal(&scene.primitives[0]), -Vec3::Z);
}

#[test]
fn normals_go_by_the_inverse_transpose() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 1 0\nf 1//1 2//1 3//1\n";
    let scene = load_mesh(obj, r#"<transform name="to_world"><scale x="2"/></transform>"#).unwrap();
    let expected = Vec3::new(0.5, 1.0, 0.0).normalize();
    assert!(scene.primitives[0].normals.unwrap()[0].abs_diff_eq(expected, 1e-6));
}

/// Smooth normals and texture coordinates are Mitsuba 3.9's. Normals are smooth across `o` and `g` and the shared
/// vertex 2/1, but not across the seam at vertex 3. The coordinate v is flipped.
#[test]
fn smooth_normals_are_mitsubas() {
    let obj = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nvt 0 0\nvt 0.25 0.125\nvt 1 1\n\
               f 1/1 2/1 3/1\ng b\nusemtl none\nf 2/1 4/2 3/3\n";
    let scene = load_mesh(obj, "").unwrap();
    let [first, second] = scene.primitives[..] else { panic!() };
    let shared = Vec3::new(-0.370_482_77, -0.370_482_77, 0.851_754_07);
    let lone = Vec3::new(-0.577_350_26, -0.577_350_26, 0.577_350_26);
    for (computed, expected) in first.normals.unwrap().iter().chain(&second.normals.unwrap()).zip([
        Vec3::Z,
        shared,
        Vec3::Z,
        shared,
        lone,
        lone,
    ]) {
        assert!(computed.abs_diff_eq(expected, 1e-6), "{computed} {expected}");
    }
    assert_eq!(second.uvs, [Vec2::new(0.0, 1.0), Vec2::new(0.25, 0.875), Vec2::new(1.0, 0.0)]);
    let scene = load_mesh(obj, r#"<boolean name="flipTexCoords" value="false"/>"#).unwrap();
    assert_eq!(scene.primitives[1].uvs, [Vec2::ZERO, Vec2::new(0.25, 0.125), Vec2::ONE]);
}

#[test]
fn polygons_are_cut_and_empty_triangles_dropped() {
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -0.5 0.5 0\nf 1 2 3 4 5\nf 1 1 2\nf -5 -4 -3\n";
    let scene = load_mesh(obj, "").unwrap();
    assert_eq!(scene.primitives.len(), 4);
    assert!(scene.primitives.iter().all(|triangle| triangle.normals.unwrap().iter().all(|n| n.is_finite())));
    assert_eq!(scene.bounds(), Some((Vec3::new(-0.5, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0))));
    assert_eq!(scene.primitives[0].uvs, [Vec2::ZERO, Vec2::X, Vec2::Y]);
}

#[test]
fn a_normal_of_length_zero_gives_way_to_the_geometric_one() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n";
    assert_eq!(load_mesh(obj, "").unwrap().primitives[0].normals, Some([Vec3::Z; 3]));
}

#[test]
fn shapes_without_area_do_no_harm() {
    let flat = r#"<transform name="to_world"><scale x="0"/></transform>"#;
    assert!(shape("rectangle", flat).is_empty());
    assert_eq!(shape("cube", flat).len(), 2);
    assert!(load_mesh(TRIANGLE, flat).unwrap().primitives.is_empty());
}

#[test]
fn one_file_in_two_places() {
    let mesh = |x: i32| {
        format!(
            r#"<shape type="obj"><string name="filename" value="a.obj"/>
               <transform name="to_world"><translate x="{x}"/></transform></shape>"#
        )
    };
    let body = [mesh(0), mesh(5)].concat();
    let scene = Folder::new(&[("scene.xml", &with_sensor(&body)), ("a.obj", TRIANGLE)]).load(&[]).unwrap();
    assert_eq!(scene.primitives[1].origin, Vec3::new(5.0, 0.0, 0.0));
    assert_eq!(scene.primitives[1].edge_u, scene.primitives[0].edge_u);
}
