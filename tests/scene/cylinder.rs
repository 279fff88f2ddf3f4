//! `cylinder`, against Mitsuba 3.9.1's answers for rays (noted by hand) and against plain geometry.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use lodestar::scene::Primitive;

use super::load_body;

const MIRROR: &str = r#"<transform name="to_world"><scale x="-1"/></transform>"#;
const FLIP: &str = r#"<boolean name="flip_normals" value="true"/>"#;

fn cylinder(parameters: &str) -> Vec<Primitive> {
    load_body(&format!(r#"<shape type="cylinder">{parameters}</shape>"#)).unwrap().primitives
}

/// First point of the ray on the triangles: its place, shading normal and texture coordinates.
pub fn hit(triangles: &[Primitive], origin: Vec3, direction: Vec3) -> (Vec3, Vec3, Vec2) {
    nearest(triangles, origin, direction).expect("the ray should hit the triangles")
}

/// Point, normal and texture coordinates of the nearest hit; `None` for a ray that hits nothing, or only backs that let it pass.
pub fn nearest(triangles: &[Primitive], origin: Vec3, direction: Vec3) -> Option<(Vec3, Vec3, Vec2)> {
    let on = |triangle: &Primitive| {
        let across = direction.cross(triangle.edge_v);
        let determinant = triangle.edge_u.dot(across);
        let from = origin - triangle.origin;
        let u = from.dot(across) / determinant;
        let v = direction.dot(from.cross(triangle.edge_u)) / determinant;
        let t = triangle.edge_v.dot(from.cross(triangle.edge_u)) / determinant;
        let shares = [1.0 - u - v, u, v];
        let [n0, n1, n2] = triangle.normals.unwrap();
        let normal = (shares[0] * n0 + shares[1] * n1 + shares[2] * n2).normalize();
        let uv = shares[0] * triangle.uvs[0] + shares[1] * triangle.uvs[1] + shares[2] * triangle.uvs[2];
        let is_solid = !triangle.front_only || normal.dot(direction) < 0.0;
        let is_met = t > 0.0 && is_solid && shares.iter().all(|&share| share >= -1e-6);
        is_met.then_some((t, (origin + t * direction, normal, uv)))
    };
    let nearest = triangles.iter().filter_map(on).min_by(|(a, _), (b, _)| a.total_cmp(b));
    nearest.map(|(_, found)| found)
}

/// Places, normals and texture coordinates are Mitsuba's, from both sides, mirrored, flipped and between any two points.
#[test]
fn points_normals_and_texture_coordinates_are_mitsubas() {
    let outside = (Vec3::new(3.0, 0.6, 0.25), -Vec3::X);
    let place = |p1: &str| format!(r#"<float name="radius" value="0.5"/><point name="p1" value="{p1}"/>"#);
    let scaled = r#"<transform name="to_world"><scale x="2" y="2" z="5"/></transform>"#;
    let mirrored_along = r#"<transform name="to_world"><scale z="-1"/></transform>"#;
    for (parameters, (origin, direction), point, normal, uv) in [
        (String::new(), outside, [0.8, 0.6, 0.25], [0.8, 0.6, 0.0], [0.10242, 0.25]),
        (
            String::new(),
            (Vec3::new(0.2, 0.1, 0.25), -Vec3::Y),
            [0.2, -0.9798, 0.25],
            [0.2, -0.9798, 0.0],
            [0.78205, 0.25],
        ),
        (MIRROR.into(), outside, [0.8, 0.6, 0.25], [0.8, 0.6, 0.0], [0.39758, 0.25]),
        (
            mirrored_along.into(),
            (Vec3::new(3.0, 0.6, -0.25), -Vec3::X),
            [0.8, 0.6, -0.25],
            [0.8, 0.6, 0.0],
            [0.10242, 0.25],
        ),
        (FLIP.into(), outside, [0.8, 0.6, 0.25], [-0.8, -0.6, 0.0], [0.10242, 0.25]),
        ([MIRROR, FLIP].concat(), outside, [0.8, 0.6, 0.25], [-0.8, -0.6, 0.0], [0.39758, 0.25]),
        (scaled.into(), outside, [1.90788, 0.6, 0.25], [0.95394, 0.3, 0.0], [0.04849, 0.05]),
        (
            place("1,0,0"),
            (Vec3::new(0.51, 0.02, -0.01), Vec3::new(0.0, -0.813_733_5, 0.581_238_2)),
            [0.51, -0.40483, 0.29345],
            [0.0, -0.80966, 0.5869],
            [0.65017, 0.51],
        ),
        (
            place("0,0,-1"),
            (Vec3::new(0.01, 0.02, -0.51), Vec3::new(0.857_492_9, -0.514_495_8, 0.0)),
            [0.43979, -0.23787, -0.51],
            [0.87958, -0.47575, 0.0],
            [0.07891, 0.51],
        ),
        (
            place("0,1,0"),
            (Vec3::new(0.01, 0.52, -0.01), Vec3::new(0.919_145, 0.0, -0.393_919_3)),
            [0.45748, 0.52, -0.20178],
            [0.91496, 0.0, -0.40355],
            [0.06611, 0.52],
        ),
        (
            place("1,2,3"),
            (Vec3::new(0.51, 1.02, 1.49), Vec3::new(-0.408_248_3, 0.816_496_6, -0.408_248_3)),
            [0.31267, 1.41467, 1.29267],
            [-0.37752, 0.82362, -0.42324],
            [0.30096, 0.50143],
        ),
        (
            place("-1,-2,-3"),
            (Vec3::new(-0.49, -0.98, -1.51), Vec3::new(0.408_248_3, -0.816_496_6, 0.408_248_3)),
            [-0.27933, -1.40133, -1.29933],
            [0.43848, -0.80838, 0.39276],
            [0.18792, 0.49857],
        ),
    ] {
        let found = hit(&cylinder(&parameters), origin, direction);
        // The strips are up to 2e-4 radii off, which moves a point further where the ray is oblique.
        assert!(found.0.abs_diff_eq(point.into(), 8e-4), "{parameters} {origin}: the point {}", found.0);
        assert!(found.1.abs_diff_eq(normal.into(), 4e-4), "{parameters} {origin}: the normal {}", found.1);
        assert!(found.2.abs_diff_eq(uv.into(), 1e-4), "{parameters} {origin}: the coordinates {}", found.2);
    }
}

/// The strips have the area of the cylinder, and every point is within 2e-4 radii of its place.
#[test]
fn the_strips_are_as_near_as_the_documents_say() {
    let (radius, length) = (0.5, 3.0);
    let triangles = cylinder(r#"<float name="radius" value="0.5"/><point name="p1" z="3"/>"#);
    assert_eq!(triangles.len(), 256);
    let area: f32 = triangles.iter().map(|triangle| 0.5 * triangle.edge_u.cross(triangle.edge_v).length()).sum();
    assert!((area / (TAU * radius * length) - 1.0).abs() < 1e-5, "{area}");
    let mut range = (f32::MAX, 0.0_f32);
    for triangle in &triangles {
        let (a, b, c) = (triangle.origin, triangle.origin + triangle.edge_u, triangle.origin + triangle.edge_v);
        for point in [a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (a + c)] {
            let distance = point.truncate().length() / radius;
            range = (range.0.min(distance), range.1.max(distance));
        }
    }
    assert!(range.0 > 1.0 - 2.1e-4 && range.0 < 1.0 - 1.9e-4, "{range:?}");
    assert!(range.1 < 1.0 + 1.1e-4 && range.1 > 1.0 + 0.9e-4, "{range:?}");
}

#[test]
fn a_cylinder_that_is_none_is_refused() {
    let refuse = |parameters: &str, word: &str| {
        let error = load_body(&format!(r#"<shape type="cylinder">{parameters}</shape>"#)).map(drop).unwrap_err();
        let message = error.to_string();
        assert!(message.contains("scene.xml:2: ") && message.contains(word), "{message}");
    };
    refuse(r#"<transform name="to_world"><scale x="2"/></transform>"#, "unevenly");
    let shear = r#"<transform name="to_world"><matrix value="1 0 0.5 0 1 0 0 0 1"/></transform>"#;
    refuse(shear, "shear");
    refuse(r#"<point name="p0" x="1"/><point name="p1" x="1"/>"#, "`p0` and `p1`");
    refuse(r#"<float name="radius" value="0"/>"#, "`radius`");
}

/// Instances may scale a cylinder unevenly, because triangles stay triangles.
#[test]
fn an_instance_may_scale_a_cylinder_unevenly() {
    let body = r#"<shape type="shapegroup" id="g"><shape type="cylinder"/></shape>
        <shape type="instance"><transform name="to_world"><scale x="3"/></transform><ref id="g"/></shape>"#;
    let triangles = load_body(body).unwrap().primitives;
    let (point, normal, _) = hit(&triangles, Vec3::new(9.0, 0.6, 0.25), -Vec3::X);
    assert!(point.abs_diff_eq(Vec3::new(2.4, 0.6, 0.25), 2e-3), "{point}");
    assert!(normal.abs_diff_eq(Vec3::new(0.8 / 3.0, 0.6, 0.0).normalize(), 1e-3), "{normal}");
}
