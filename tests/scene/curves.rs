//! `linearcurve` and `bsplinecurve`, against plain geometry and Mitsuba 3.9.1's answers for rays (noted by hand).

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use lodestar::Result;
use lodestar::scene::{Primitive, Scene};

use super::cylinder::{hit, nearest};
use super::{Folder, with_sensor};

/// Largest distance from the true surface, in radii.
const DEVIATION: f32 = 0.01;

fn load(plugin: &str, points: &str, parameters: &str) -> Result<Scene> {
    let shape = format!(r#"<shape type="{plugin}"><string name="filename" value="curves.txt"/>{parameters}</shape>"#);
    Folder::new(&[("scene.xml", &with_sensor(&shape)), ("curves.txt", points)]).load(&[])
}

fn triangles(plugin: &str, points: &str) -> Vec<Primitive> {
    load(plugin, points, "").unwrap().primitives
}

/// Corner of a triangle.
#[derive(Debug, Clone, Copy)]
struct Corner {
    place: Vec3,
    normal: Vec3,
    uv: Vec2,
}

fn corners(triangles: &[Primitive]) -> Vec<Corner> {
    let of = |triangle: &Primitive| {
        let Primitive { origin, edge_u, edge_v, normals, uvs, .. } = *triangle;
        let (places, normals) = ([origin, origin + edge_u, origin + edge_v], normals.unwrap());
        [0, 1, 2].map(|i| Corner { place: places[i], normal: normals[i], uv: uvs[i] })
    };
    triangles.iter().flat_map(of).collect()
}

/// Corners, centers and middles of sides.
fn points(triangles: &[Primitive]) -> Vec<Vec3> {
    let of = |triangle: &Primitive| {
        let Primitive { origin, edge_u, edge_v, .. } = *triangle;
        let shares = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (1.0 / 3.0, 1.0 / 3.0)];
        shares.map(|(u, v)| origin + u * edge_u + v * edge_v)
    };
    triangles.iter().flat_map(of).collect()
}

/// Distance from the segment from `a` to `b`.
fn from_segment(p: Vec3, a: Vec3, b: Vec3) -> f32 {
    let share = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, share))
}

/// Mean over all directions around the axis `z` of the distance to the mesh, at a height.
fn mean_radius(triangles: &[Primitive], z: f32) -> f32 {
    const COUNT: u32 = 1000;
    let radius = |at: u32| {
        let (sine, cosine) = (TAU * (at as f32 + 0.5) / COUNT as f32).sin_cos();
        let direction = Vec3::new(cosine, sine, 0.0);
        hit(triangles, Vec3::Z * z + 10.0 * direction, -direction).0.truncate().length()
    };
    (0..COUNT).map(radius).sum::<f32>() / COUNT as f32
}

/// A straight curve is a cylinder between two half spheres.
#[test]
fn a_straight_linear_curve_is_a_capsule() {
    let mesh = triangles("linearcurve", "0 0 0 0.5\n0 0 3 0.5\n");
    for point in points(&mesh) {
        let off = from_segment(point, Vec3::ZERO, 3.0 * Vec3::Z) / 0.5 - 1.0;
        assert!(off.abs() < DEVIATION, "{point} is {off} radii off");
    }
    for corner in corners(&mesh) {
        let axis = Vec3::Z * corner.place.z.clamp(0.0, 3.0);
        assert!((corner.normal - (corner.place - axis).normalize()).length() < DEVIATION, "{corner:?}");
    }
    let (low, high) = (mesh.iter().map(|p| p.bounds().0.z), mesh.iter().map(|p| p.bounds().1.z));
    assert_eq!((low.fold(0.0, f32::min), high.fold(0.0, f32::max)), (-0.5, 3.5));
    let mean = mean_radius(&mesh, 1.3);
    assert!((mean / 0.5 - 1.0).abs() < 1e-4, "{mean}");
}

/// Segments with different radii are cones that touch the spheres at both ends, also where the curve bends and where one
/// sphere holds the next.
#[test]
fn a_linear_curve_is_the_hull_of_its_spheres() {
    let controls = [
        (Vec3::ZERO, 0.5),
        (Vec3::new(0.2, 0.1, 2.0), 0.25),
        (Vec3::new(1.5, 0.0, 2.2), 0.4),
        (Vec3::new(1.6, 0.1, 2.2), 0.1),
        (Vec3::new(1.4, 1.6, 1.0), 0.0),
    ];
    let text: String = controls.map(|(p, radius)| format!("{} {} {} {radius}\n", p.x, p.y, p.z)).concat();
    // Distance from the nearest sphere of a segment: its spheres' centers and radii change linearly.
    let from_spheres = |point: Vec3, (a, from): (Vec3, f32), (b, to): (Vec3, f32)| {
        let distance = |share: f32| point.distance(a.lerp(b, share)) - (from + share * (to - from));
        (0..=1000).map(|step| distance(step as f32 / 1000.0)).fold(f32::MAX, f32::min)
    };
    for point in points(&triangles("linearcurve", &text)).into_iter().step_by(5) {
        let distance = controls.windows(2).map(|pair| from_spheres(point, pair[0], pair[1])).fold(f32::MAX, f32::min);
        // Inside a bend, parts of the mesh are hidden. No part is farther out than the surface.
        assert!(distance < DEVIATION * 0.5, "{point} is {distance} off");
    }
    // Rays find the surface wherever they come from: the sphere at the bend, the cones, both ends.
    for (from, to) in [
        (Vec3::new(-3.0, 0.3, 3.0), Vec3::new(0.2, 0.1, 2.0)),
        (Vec3::new(0.1, -4.0, 1.0), Vec3::new(0.1, 0.05, 1.0)),
        (Vec3::new(0.1, 0.2, -4.0), Vec3::ZERO),
        (Vec3::new(5.0, -1.0, 3.0), Vec3::new(1.5, 0.0, 2.2)),
        (Vec3::new(2.0, 3.0, 4.0), Vec3::new(1.5, 0.9, 1.6)),
    ] {
        let (point, ..) = hit(&triangles("linearcurve", &text), from, (to - from).normalize());
        let distance = controls.windows(2).map(|pair| from_spheres(point, pair[0], pair[1])).fold(f32::MAX, f32::min);
        assert!(distance.abs() < DEVIATION * 0.5, "{point} is {distance} off");
    }
}

/// A bend of a linear curve is a sphere.
#[test]
fn a_bend_of_a_linear_curve_is_round() {
    let mesh = triangles("linearcurve", "-2 0 0 0.3\n0 0 0 0.3\n0 0 2 0.3\n");
    for degrees in [2.0_f32, 20.0, 45.0, 70.0, 88.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let outward = Vec3::new(sine, 0.0, -cosine);
        let (point, normal, _) = hit(&mesh, 3.0 * outward, -outward);
        assert!((point.length() / 0.3 - 1.0).abs() < DEVIATION, "{degrees}: {point}");
        assert!((normal - outward).length() < 2.0 * DEVIATION, "{degrees}: {normal}");
    }
}

/// B-spline of points on a line: an open cylinder from the second point to the last but one, if they are evenly spaced.
#[test]
fn a_straight_spline_is_an_open_cylinder() {
    let mesh = triangles("bsplinecurve", "0 0 0 0.5\n0 0 1 0.5\n0 0 2 0.5\n0 0 3 0.5\n0 0 4 0.5\n");
    for point in points(&mesh) {
        let off = point.truncate().length() / 0.5 - 1.0;
        assert!(off.abs() < DEVIATION, "{point} is {off} radii off");
    }
    for Corner { place, normal, uv } in corners(&mesh) {
        assert!((normal - place.with_z(0.0).normalize()).length() < 1e-5, "{place}: {normal}");
        assert!((place.z - (1.0 + 2.0 * uv.y)).abs() < 1e-5, "{place}: {uv}");
    }
    let mean = mean_radius(&mesh, 1.3);
    assert!((mean / 0.5 - 1.0).abs() < 1e-4, "{mean}");
}

/// Control points of a bent spline of constant radius.
const BENT: [[f32; 3]; 6] =
    [[-1.0, 0.0, 0.0], [0.0, 0.5, 0.2], [1.0, -0.5, 1.0], [0.5, 0.5, 2.0], [0.0, -0.3, 2.5], [-0.5, 0.0, 2.0]];

fn bent(radius: impl Fn(usize) -> f32) -> String {
    let line = |(at, [x, y, z]): (usize, [f32; 3])| format!("{x} {y} {z} {}\n", radius(at));
    BENT.into_iter().enumerate().map(line).collect()
}

/// Weighted sums of control points at `v` of the whole spline: the point, and the derivative in the segment.
fn spline(v: f32) -> (Vec3, Vec3) {
    let along = 3.0 * v;
    let segment = (along.floor() as usize).min(2);
    let u = along - segment as f32;
    let w = 1.0 - u;
    // The cubic B-spline's basis, by the recursion of Cox and de Boor for even knots.
    let basis = [w * w * w, 4.0 - 6.0 * u * u + 3.0 * u * u * u, 4.0 - 6.0 * w * w + 3.0 * w * w * w, u * u * u];
    let change = [-w * w, 3.0 * u * u - 4.0 * u, 4.0 * w - 3.0 * w * w, u * u];
    let sum = |weights: [f32; 4]| (0..4).map(|i| Vec3::from(BENT[segment + i]) * weights[i]).sum::<Vec3>();
    (sum(basis) / 6.0, sum(change) / 2.0)
}

/// The middle of each ring is the point of the spline, and normals are unit vectors across it.
#[test]
fn a_spline_is_where_its_basis_says() {
    let mesh = triangles("bsplinecurve", &bent(|_| 0.05));
    let mut rings: Vec<(f32, Vec<Corner>)> = Vec::new();
    for corner in corners(&mesh) {
        match rings.iter_mut().find(|(v, _)| *v == corner.uv.y) {
            Some((_, ring)) => ring.push(corner),
            None => rings.push((corner.uv.y, vec![corner])),
        }
    }
    let knots =
        rings.iter().filter(|(v, _)| [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].iter().any(|knot| (v - knot).abs() < 1e-6));
    assert_eq!(knots.count(), 4);
    assert!((30..600).contains(&rings.len()), "{}", rings.len());
    for (v, ring) in rings {
        let (point, change) = spline(v);
        for Corner { place, normal, .. } in ring {
            assert!((normal.length() - 1.0).abs() < 1e-5, "{v}: {normal}");
            assert!(normal.dot(change.normalize()).abs() < 1e-4, "{v}: {normal}");
            // The corner lies on the normal through the spline's point, a little farther out than the radius.
            let off = (place - point).dot(normal) / 0.05;
            assert!((1.0..1.0 + DEVIATION).contains(&off), "{v}: {off} radii");
            assert!((place - point).cross(normal).length() < 1e-5, "{v}: {place}");
        }
    }
}

/// Radii follow the same basis, and normals lean where the radius changes.
#[test]
fn a_spline_with_changing_radius_has_the_slope_in_its_normals() {
    // On evenly spaced points, a linear radius stays linear: a cone with the slope 0.1.
    let mesh = triangles("bsplinecurve", "0 0 0 0.1\n0 0 1 0.2\n0 0 2 0.3\n0 0 3 0.4\n");
    for Corner { place, normal, .. } in corners(&mesh) {
        let radius = 0.1 + 0.1 * place.z;
        let off = place.truncate().length() / radius - 1.0;
        assert!((0.0..DEVIATION).contains(&off), "{place} is {off} radii off");
        let expected = (place.with_z(0.0).normalize() - 0.1 * Vec3::Z).normalize();
        assert!((normal - expected).length() < 1e-4, "{place}: {normal}");
    }
}

/// Every point of the mesh is as near to the swept circle as the warning says, and a mesh of another radius is not.
#[test]
fn a_bent_spline_is_near_its_circle() {
    let farthest = |radius: f32| {
        let mesh = triangles("bsplinecurve", &bent(|_| radius));
        let axis: Vec<Vec3> = (0..=3000).map(|step| spline(step as f32 / 3000.0).0).collect();
        let off = |point: &Vec3| {
            let nearest = axis.iter().map(|at| at.distance_squared(*point)).fold(f32::MAX, f32::min).sqrt();
            (nearest / 0.05 - 1.0).abs()
        };
        points(&mesh).iter().step_by(7).map(off).fold(0.0, f32::max)
    };
    assert!(farthest(0.05) < DEVIATION + 1e-3, "{}", farthest(0.05));
    assert!(farthest(0.051) > 0.02, "{}", farthest(0.051));
}

/// In a plane, the normal of the plane stays at the same corner, also where the curve climbs straight up, where Mitsuba's
/// own direction of u = 0 turns over.
#[test]
fn sides_do_not_twist() {
    for plugin in ["linearcurve", "bsplinecurve"] {
        let mesh = triangles(plugin, "-1 0 0 0.1\n0 0 0 0.1\n1 0 1 0.1\n1 0 2 0.1\n0 0 3 0.1\n-1 0 3 0.1\n");
        for triangle in &mesh {
            let [a, b, c]: [Corner; 3] = corners(std::slice::from_ref(triangle)).try_into().unwrap();
            // Caps become narrower.
            if [a, b, c].iter().all(|corner| corner.uv.y == 0.0) || [a, b, c].iter().all(|corner| corner.uv.y == 1.0) {
                continue;
            }
            // Two of the corners lie in one column.
            let along = [(a, b), (b, c), (c, a)].map(|(from, to)| (from.place.y - to.place.y).abs());
            assert!(along.into_iter().fold(f32::MAX, f32::min) < 1e-5, "{plugin}: {along:?}");
        }
    }
}

/// Places, normals and texture coordinates are Mitsuba's: on segments and caps of linear curves, on cones, on splines.
#[test]
fn points_normals_and_texture_coordinates_are_mitsubas() {
    let straight = "0 0 0 .5\n0 0 3 .5\n";
    let even = "0 0 0 .5\n0 0 1 .5\n0 0 2 .5\n0 0 3 .5\n0 0 4 .5\n";
    let bend = "-2 0 0 .3\n0 0 0 .3\n0 0 2 .3\n";
    let bent = "-1 0 0 .3\n0 .5 .2 .3\n1 -.5 1 .2\n.5 .5 2 .25\n0 -.3 2.5 .3\n-.5 0 2 .3\n";
    for (points, from, to, point, normal, uv) in [
        (straight, [3.0, 0.2, 1.25], [-1.0, 0.0, 0.0], [0.45826, 0.2, 1.25], [0.91652, 0.4, 0.0], [0.06549, 0.41667]),
        (
            straight,
            [2.0, 0.1, -2.0],
            [-1.0, 0.0, 0.9],
            [0.24752, 0.1, -0.42277],
            [0.49504, 0.2, -0.84554],
            [0.06111, 0.0],
        ),
        (
            straight,
            [1.0, 0.1, 6.0],
            [-0.3, 0.0, -0.8],
            [0.05744, 0.1, 3.48652],
            [0.11489, 0.2, 0.97304],
            [0.16701, 1.0],
        ),
        (bend, [-1.0, 3.0, 0.1], [0.0, -1.0, 0.0], [-1.0, 0.28284, 0.1], [0.0, 0.94281, 0.33333], [0.05409, 0.25]),
        (bend, [-1.0, -3.0, -0.1], [0.0, 1.0, 0.0], [-1.0, -0.28284, -0.1], [0.0, -0.94281, -0.33333], [0.55409, 0.25]),
        (
            "0 0 0 .5\n0 0 2 .1\n",
            [3.0, 0.1, 1.0],
            [-1.0, 0.0, 0.0],
            [0.2894, 0.1, 1.0],
            [0.92607, 0.32, 0.2],
            [0.05295, 0.46875],
        ),
        (even, [3.0, 0.2, 1.75], [-1.0, 0.0, 0.0], [0.45826, 0.2, 1.75], [0.91652, 0.4, 0.0], [0.06549, 0.375]),
        (bent, [5.0, 0.1, 0.5], [-1.0, 0.0, 0.0], [0.6719, 0.1, 0.5], [0.79266, 0.37116, -0.48367], [0.8871, 0.17197]),
        (
            bent,
            [0.5, 5.0, 1.0],
            [0.0, -1.0, 0.0],
            [0.5, -0.06672, 1.0],
            [-0.73659, 0.27618, 0.61738],
            [0.27453, 0.27123],
        ),
        (
            bent,
            [0.6, -0.2, 9.0],
            [0.0, 0.0, -1.0],
            [0.6, -0.2, 1.49147],
            [-0.59931, -0.76793, 0.22608],
            [0.07748, 0.4788],
        ),
        (
            bent,
            [-5.0, 0.1, 1.5],
            [1.0, 0.0, 0.0],
            [0.46973, 0.1, 1.5],
            [-0.86139, 0.10945, -0.49601],
            [0.85492, 0.54221],
        ),
        (
            bent,
            [0.3, -5.0, 2.2],
            [0.0, 1.0, 0.0],
            [0.3, -0.22628, 2.2],
            [0.56573, -0.75121, -0.34004],
            [0.94377, 0.8995],
        ),
    ] {
        let plugin = if points == even || points == bent { "bsplinecurve" } else { "linearcurve" };
        let found = hit(&triangles(plugin, points), from.into(), Vec3::from(to).normalize());
        assert!(found.0.abs_diff_eq(point.into(), 6e-3), "{plugin} {from:?}: the point {}", found.0);
        assert!(found.1.abs_diff_eq(normal.into(), 1.5e-2), "{plugin} {from:?}: the normal {}", found.1);
        let off = found.2 - Vec2::from(uv);
        let off = Vec2::new(off.x - off.x.round(), off.y);
        assert!(off.abs_diff_eq(Vec2::ZERO, 5e-3), "{plugin} {from:?}: the coordinates {}", found.2);
    }
}

/// The transform moves control points. Radii stay, and mirrors turn nothing inside out.
#[test]
fn transforms_do_not_scale_radii() {
    for (scale, plugin) in [("2", "linearcurve"), ("-2", "linearcurve"), ("2", "bsplinecurve"), ("-2", "bsplinecurve")]
    {
        let transform = format!(r#"<transform name="to_world"><scale value="{scale}"/></transform>"#);
        let mesh = load(plugin, "0 0 0 0.5\n0 0 1 0.5\n0 0 2 0.5\n0 0 3 0.5\n", &transform).unwrap().primitives;
        let middle = 1.5 * scale.parse::<f32>().unwrap();
        let (point, normal, _) = hit(&mesh, Vec3::new(4.0, 0.0, middle), -Vec3::X);
        assert!((point.x / 0.5 - 1.0).abs() < DEVIATION && normal.x > 0.999, "{scale}: {point} {normal}");
        let length = mesh.iter().map(|p| p.bounds().1.z).fold(f32::MIN, f32::max)
            - mesh.iter().map(|p| p.bounds().0.z).fold(f32::MAX, f32::min);
        let expected = if plugin == "linearcurve" { 6.0 + 1.0 } else { 2.0 };
        assert!((length - expected).abs() < 1e-5, "{scale} {plugin}: {length}");
    }
}

/// An instance scales the whole tube. One that mirrors it turns nothing inside out.
#[test]
fn instances_scale_radii() {
    for (scale, plugin) in [
        ("value='3'", "linearcurve"),
        ("x='-3' y='3' z='3'", "linearcurve"),
        ("x='-3' y='3' z='3'", "bsplinecurve"),
        ("x='3' y='-3' z='3'", "bsplinecurve"),
    ] {
        let body = format!(
            r#"<shape type="shapegroup" id="g">
            <shape type="{plugin}"><string name="filename" value="curves.txt"/></shape></shape>
            <shape type="instance"><transform name="to_world"><scale {scale}/></transform><ref id="g"/></shape>"#
        );
        let points = "0 0 -1 0.5\n0 0 0 0.5\n0 0 1 0.5\n0 0 2 0.5\n";
        let scene = Folder::new(&[("scene.xml", &with_sensor(&body)), ("curves.txt", points)]).load(&[]).unwrap();
        for sign in [1.0, -1.0] {
            let (point, normal, _) = hit(&scene.primitives, Vec3::new(9.0 * sign, 0.0, 1.0), -sign * Vec3::X);
            assert!((sign * point.x / 1.5 - 1.0).abs() < DEVIATION, "{plugin} {scale}: {point}");
            assert!(sign * normal.x > 0.999, "{plugin} {scale}: {normal}");
            assert!(nearest(&scene.primitives, Vec3::Z, sign * Vec3::X).is_none(), "{plugin} {scale}: from inside");
        }
    }
}

/// Where a B-spline bends within its own radius, its surface folds over. All of it still faces away from the curve.
#[test]
fn folds_face_outward() {
    let points = "-1 0 0 0.8\n-0.5 0 0 0.8\n0 1 0 0.8\n0.5 0 0 0.8\n1 0 0 0.8\n";
    let spline = [[-1.0, 0.0], [-0.5, 0.0], [0.0, 1.0], [0.5, 0.0], [1.0, 0.0]];
    let on_curve = |span: usize, u: f32| {
        let w = 1.0 - u;
        let weights = [w * w * w, (3.0 * u - 6.0) * u * u + 4.0, (3.0 * w - 6.0) * w * w + 4.0, u * u * u];
        let sum = |axis: usize| (0..4).map(|at| weights[at] / 6.0 * spline[span + at][axis]).sum();
        Vec3::new(sum(0), sum(1), 0.0)
    };
    let curve: Vec<_> = (0..2).flat_map(|span| (0..=64).map(move |step| (span, step as f32 / 64.0))).collect();
    let mut folded = 0;
    for corner in corners(&triangles("bsplinecurve", points)) {
        let from_curve = |&(span, u): &(usize, f32)| corner.place - on_curve(span, u);
        // The circle of a corner is about a point of the curve at the distance of the radius.
        let outward = curve.iter().map(from_curve).filter(|out| (out.length() / 0.8 - 1.0).abs() < 0.012);
        let best = outward.map(|out| out.normalize().dot(corner.normal)).fold(f32::MIN, f32::max);
        assert!(best > 0.9, "{} has the normal {}", corner.place, corner.normal);
        folded += usize::from(corner.place.y < -0.2 && corner.place.x.abs() < 0.1);
    }
    assert!(folded > 10, "{folded} corners in the fold");
}

/// A curve shows its material from outside. From inside nothing is there, as in Mitsuba.
#[test]
fn curves_are_seen_from_outside_only() {
    let body = r#"<bsdf type="diffuse" id="red"><rgb name="reflectance" value="1, 0, 0"/></bsdf>
        <shape type="linearcurve"><string name="filename" value="curves.txt"/><ref id="red"/></shape>
        <shape type="bsplinecurve"><string name="filename" value="curves.txt"/><ref id="red"/></shape>
        <shape type="sphere"><ref id="red"/></shape>"#;
    let points = "0 0 0 0.5\n0 0 1 0.5\n0 0 2 0.5\n0 0 3 0.5\n";
    let scene = Folder::new(&[("scene.xml", &with_sensor(body)), ("curves.txt", points)]).load(&[]).unwrap();
    let (ball, curves) = scene.primitives.split_last().unwrap();
    assert!(curves.iter().all(|triangle| triangle.front_only && triangle.material == ball.material));
    assert!(!ball.front_only);
    // Normals and windings agree that the outside is the front.
    for triangle in curves {
        let facing = triangle.edge_u.cross(triangle.edge_v) * if triangle.flip_normal { -1.0 } else { 1.0 };
        assert!(triangle.normals.unwrap().iter().all(|normal| normal.dot(facing.normalize()) > 0.9));
    }
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    let count = format!("curves are rendered as {} triangles, which are at most 1.00 % of the radius", curves.len());
    assert!(scene.warnings[0].contains("scene.xml:3: ") && scene.warnings[0].contains(&count), "{}", scene.warnings[0]);
}

/// Equal points, radii of 0 and turning on the spot leave no numbers that are none.
#[test]
fn odd_curves_are_read() {
    for (plugin, points) in [
        ("linearcurve", "0 0 0 1\n0 0 0 1\n1 0 0 1\n"),
        ("linearcurve", "0 0 0 1\n0 0 0 2\n0 0 0 0.5\n"),
        ("linearcurve", "0 0 0 1\n0 0 1 1\n0 0 0 1\n"),
        ("linearcurve", "0 0 0 0\n0 0 1 1\n0 0 1 0\n1 0 0 0\n"),
        ("linearcurve", "0 0 0 3\n0 0 1 1\n0 0 2 3\n"),
        ("bsplinecurve", "0 0 0 1\n0 0 0 1\n0 0 0 1\n0 0 1 1\n0 0 1 1\n0 0 1 1\n"),
        ("bsplinecurve", "0 0 0 0\n0 0 1 1\n0 0 2 1\n0 0 3 0\n0 0 3 0\n0 0 3 0\n"),
        ("bsplinecurve", "0 0 0 1\n0 0 1 1\n0 0 1 1\n0 0 0 1\n0 0 -1 1\n"),
        ("bsplinecurve", "0 0 0 1\n0 0 0 1\n0 0 0 1\n0 0 0 1\n0 0 0 1\n1 0 0 1\n"),
        ("bsplinecurve", "0 0 0 5\n1 0 0 5\n1 1 0 5\n0 1 0 5\n0 0 0 5\n"),
    ] {
        let scene = load(plugin, points, "").unwrap_or_else(|error| panic!("{plugin} {points:?}: {error}"));
        super::fuzz::check(&scene).unwrap_or_else(|error| panic!("{plugin} {points:?}: {error}"));
        assert!((100..20_000).contains(&scene.primitives.len()), "{plugin} {points:?}: {}", scene.primitives.len());
    }
}

/// Files with any line ends and blanks, several curves, and words after the radius, which Mitsuba ignores.
#[test]
fn files_of_any_form_are_read() {
    let plain = triangles("linearcurve", "0 0 0 1\n0 0 2 1\n\n5 0 0 1\n5 0 2 1\n");
    let odd = triangles("linearcurve", " \t\r\n\r\n0 0 0 1\r\n\t 0 0 2.0 1e0 and more\r\n \t\r\n\n5 0 0 1\n5 0 2 +1");
    assert_eq!(plain, odd);
    let one = triangles("linearcurve", "0 0 0 1\n0 0 2 1\n");
    assert_eq!(plain.len(), 2 * one.len());
    // v goes over the segments of all curves.
    let largest = |triangles: &[Primitive]| corners(triangles).iter().map(|corner| corner.uv.y).fold(0.0, f32::max);
    assert_eq!((largest(&plain), largest(&plain[..one.len()])), (1.0, 0.5));
}

#[track_caller]
fn refuse(plugin: &str, points: &str, parameters: &str, parts: &[&str]) {
    let error = load(plugin, points, parameters).map(drop).expect_err("this should be refused").to_string();
    for part in parts {
        assert!(error.contains(part), "`{part}` is missing in: {error}");
    }
}

#[test]
fn bad_curves_are_refused() {
    let good = "0 0 0 1\n0 0 1 1\n0 0 2 1\n0 0 3 1\n";
    refuse(
        "linearcurve",
        "0 0 0 1\n0 0 1 x\n",
        "",
        &["curves.txt:2: ", "`x` is not a finite number", "`x y z radius`"],
    );
    refuse("linearcurve", "0 0 0 1\n0 0 1\n", "", &["curves.txt:2: ", "4 numbers", "`x y z radius`"]);
    refuse("bsplinecurve", "# hair\n0 0 0 1\n", "", &["curves.txt:1: ", "`#`"]);
    refuse("linearcurve", "0 0 0 1\n0 nan 1 1\n", "", &["curves.txt:2: ", "`nan`"]);
    refuse("linearcurve", "0 0 0 1\n0 0 1 -0.5\n", "", &["curves.txt:2: ", "-0.5", "negative"]);
    refuse("linearcurve", "\n\n0 0 0 1\n\n0 0 1 1\n", "", &["curves.txt:3: ", "`linearcurve`", "at least 2", "has 1"]);
    refuse("bsplinecurve", &(good.to_owned() + "\n" + &good[..24]), "", &["curves.txt:6: ", "at least 4", "has 3"]);
    refuse("bsplinecurve", "", "", &["curves.txt", "no control points"]);
    refuse("linearcurve", " \n\t\n", "", &["curves.txt", "no control points"]);
    refuse("linearcurve", "0 0 0 0\n0 0 1 0\n", "", &["curves.txt", "no surface", "radii are 0"]);
    refuse("linearcurve", "0 0 0 1\n0 0 0 1\n", "", &["curves.txt", "no surface", "equal"]);
    refuse("linearcurve", "0 0 0 1\n3e38 3e38 3e38 3e38\n", "", &["scene.xml:2: ", "single-precision"]);
    let flip = r#"<boolean name="flip_normals" value="true"/>"#;
    refuse("bsplinecurve", good, flip, &["scene.xml:2: ", "`bsplinecurve`", "`flip_normals`", "leave it out"]);
    let area = r#"<emitter type="area"/>"#;
    refuse("linearcurve", good, area, &["scene.xml:2: ", "`area`", "`linearcurve`", "`cylinder`"]);
    let color = r#"<bsdf type="diffuse"><texture type="mesh_attribute" name="reflectance"><string name="name"
        value="vertex_color"/></texture></bsdf>"#;
    refuse("linearcurve", good, color, &["scene.xml:2: ", "`mesh_attribute`", "`ply`"]);
    let shape = |inside: &str| super::load_body(&format!(r#"<shape type="linearcurve">{inside}</shape>"#));
    let missing = shape(r#"<string name="filename" value="no.txt"/>"#).map(drop).unwrap_err().to_string();
    assert!(missing.contains("scene.xml:2: the curve file `no.txt` does not exist"), "{missing}");
    let missing = shape("").map(drop).unwrap_err().to_string();
    assert!(missing.contains("`linearcurve` needs its parameter `filename`"), "{missing}");
}
