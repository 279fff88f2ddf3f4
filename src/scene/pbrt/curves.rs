//! Curves: control points of tubes, or strips.

use glam::{DVec3, DVec4, Vec2};

use super::tokens::brief;
use super::world::Entity;
use crate::Result;
use crate::scene::mesh::{Mesh, Strand};

/// Steps of a strip in each segment.
const STEPS: usize = 8;

/// Curve as it is rendered.
pub(super) enum Curve {
    /// Tubes, one after the other.
    Tubes(Strand),
    Strip(Mesh),
}

/// Reads a curve of degree 2 or 3 in the basis of Bézier or of uniform B-splines.
pub(super) fn read(entity: &Entity) -> Result<Curve> {
    let parameters = &entity.parameters;
    parameters.ignore(&["splitdepth"]);
    let width = parameters.number("width", 1.0)?;
    let widths = [parameters.number("width0", width)?, parameters.number("width1", width)?];
    if let Some(width) = widths.iter().find(|width| **width < 0.0) {
        return Err(entity.error(format!("the width of a curve must not be negative, as {width} is")));
    }
    let degree = parameters.integer("degree", 2..=3)?.unwrap_or(3) as usize;
    let points: Vec<DVec3> = parameters.points("P")?.iter().map(|point| point.as_dvec3()).collect();
    let count = points.len();
    let is_bezier = match parameters.text("basis")?.unwrap_or("bezier") {
        "bezier" => true,
        "bspline" => false,
        other => {
            let message = format!("the basis `{}` is not known; use `bezier` or `bspline`", brief(other));
            return Err(entity.error(message));
        }
    };
    let segments = match is_bezier {
        true if count > degree && (count - 1).is_multiple_of(degree) => (count - 1) / degree,
        false if count > degree => count - degree,
        _ => {
            let more = if is_bezier { format!(", and {degree} more for each further segment") } else { String::new() };
            let needed = degree + 1;
            return Err(
                entity.error(format!("a curve of degree {degree} needs {needed} points in `P`{more}, not {count}"))
            );
        }
    };
    // Radius at a place along the curve, in segments.
    let radius = |at: f64| 0.5 * (widths[0] + (widths[1] - widths[0]) * at / segments as f64);
    let control = |segment: usize| match is_bezier {
        true => of_bezier(&points[degree * segment..=degree * (segment + 1)]),
        false => of_spline(&points[segment..=segment + degree]),
    };
    match parameters.text("type")?.unwrap_or("flat") {
        "flat" | "cylinder" => {
            parameters.ignore(&["N"]);
            let strand = |places: &mut dyn Iterator<Item = DVec3>, first: f64| -> Vec<DVec4> {
                (0..).zip(places).map(|(at, place)| place.extend(radius(first + f64::from(at)))).collect()
            };
            if !is_bezier && degree == 3 {
                return Ok(Curve::Tubes(vec![strand(&mut points.iter().copied(), -1.0)]));
            }
            let tube = |segment: usize| {
                let [a, b, c, d] = control(segment);
                let spline = [6.0 * a - 7.0 * b + 2.0 * c, 2.0 * b - c, 2.0 * c - b, 2.0 * b - 7.0 * c + 6.0 * d];
                strand(&mut spline.into_iter(), segment as f64 - 1.0)
            };
            Ok(Curve::Tubes((0..segments).map(tube).collect()))
        }
        "ribbon" => {
            let normals: Vec<DVec3> = parameters.points("N")?.iter().map(|normal| normal.as_dvec3()).collect();
            if normals.len() != segments + 1 {
                let needed = segments + 1;
                let found = normals.len();
                return Err(
                    entity.error(format!("a ribbon of {segments} segments needs {needed} normals `N`, not {found}"))
                );
            }
            Ok(Curve::Strip(strip(segments, control, &normals, radius)))
        }
        other => {
            let message =
                format!("the type `{}` of curves is not known; use `flat`, `cylinder` or `ribbon`", brief(other));
            Err(entity.error(message))
        }
    }
}

/// Control points of degree 3 of a Bézier segment of degree 2 or 3.
fn of_bezier(points: &[DVec3]) -> [DVec3; 4] {
    match *points {
        [a, b, c] => [a, a.lerp(b, 2.0 / 3.0), c.lerp(b, 2.0 / 3.0), c],
        _ => std::array::from_fn(|at| points[at]),
    }
}

/// Bézier control points of degree 3 of a segment of a uniform B-spline of degree 2 or 3.
fn of_spline(points: &[DVec3]) -> [DVec3; 4] {
    match *points {
        [a, b, c] => of_bezier(&[a.midpoint(b), b, b.midpoint(c)]),
        _ => {
            let inner = [points[1].lerp(points[2], 1.0 / 3.0), points[1].lerp(points[2], 2.0 / 3.0)];
            let before = points[0].lerp(points[1], 2.0 / 3.0);
            let after = points[2].lerp(points[3], 1.0 / 3.0);
            [before.midpoint(inner[0]), inner[0], inner[1], inner[1].midpoint(after)]
        }
    }
}

/// Strip that faces the normals, which are interpolated from one end of a segment to the other.
fn strip(
    segments: usize,
    control: impl Fn(usize) -> [DVec3; 4],
    normals: &[DVec3],
    radius: impl Fn(f64) -> f64,
) -> Mesh {
    let mut mesh = Mesh::default();
    for (segment, step) in (0..segments).flat_map(|segment| (0..=STEPS).map(move |step| (segment, step))) {
        let t = step as f64 / STEPS as f64;
        let [a, b, c, d] = control(segment);
        let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
        let (abc, bcd) = (ab.lerp(bc, t), bc.lerp(cd, t));
        let tangent = (bcd - abc).normalize_or(DVec3::X);
        let [from, to] = [normals[segment], normals[segment + 1]].map(|normal| normal.normalize_or(DVec3::Z));
        let side = from.lerp(to, t).cross(tangent).normalize_or(tangent.any_orthonormal_vector());
        let along = segment as f64 + t;
        for across in [-1.0, 1.0] {
            mesh.positions.push((abc.lerp(bcd, t) + across * radius(along) * side).as_vec3());
            mesh.normals.push(tangent.cross(side).as_vec3());
            mesh.uvs.push(Vec2::new((along / segments as f64) as f32, (0.5 + 0.5 * across) as f32));
        }
        if step > 0 {
            let last = mesh.positions.len() as u32 - 1;
            mesh.triangles.extend([[last - 3, last - 1, last], [last - 3, last, last - 2]]);
        }
    }
    mesh
}
