//! Curves (`BasisCurves`) as tubes.

use std::iter;

use glam::{DVec3, DVec4};

use super::asset::Prim;
use super::budget::Made;
use super::values;
use crate::Result;
use crate::scene::mesh::{Mesh, Strand, of_strands};

/// Mesh of the tubes of a prim's curves; `None` where it has none.
pub(super) fn mesh(prim: &Prim, made: &mut Made) -> Result<Option<Mesh>> {
    let fault = |message: &str| prim.asset.prim_error(&prim.path, message);
    let points = prim.read("points", values::triples)?.unwrap_or_default();
    let lengths = prim.read("curveVertexCounts", values::indices)?.unwrap_or_default();
    let widths = prim.read("widths", values::numbers)?.unwrap_or_default();
    if points.is_empty() || lengths.is_empty() {
        return Ok(None);
    }
    made.corners(points.len()).map_err(|message| fault(&message))?;
    if lengths.iter().try_fold(0_usize, |sum, &length| sum.checked_add(length)).is_none_or(|sum| sum > points.len()) {
        return Err(fault("`curveVertexCounts` ask for more points than `points` has"));
    }
    let radius = |curve: usize, point: usize| match widths.len() {
        0 => 0.5,
        count if count >= points.len() => 0.5 * widths[point],
        count if count == lengths.len() => 0.5 * widths[curve],
        _ => 0.5 * widths[0],
    };
    let is_linear = prim.text("type")?.as_deref() == Some("linear");
    let basis = prim.text("basis")?.unwrap_or_else(|| "bezier".to_owned());
    let wrap = prim.text("wrap")?.unwrap_or_else(|| "nonperiodic".to_owned());
    let mut strands: Vec<Strand> = Vec::new();
    let mut first = 0;
    for (curve, &length) in lengths.iter().enumerate() {
        let control: Vec<DVec4> = (first..first + length)
            .map(|point| DVec3::from_array(points[point]).extend(radius(curve, point).abs()))
            .collect();
        first += length;
        if !control.iter().all(|point| point.is_finite()) {
            return Err(fault("a point or a width of its curves is not finite"));
        }
        let basis = if is_linear { "linear" } else { &*basis };
        let Some(strand) = strand(&control, basis, &wrap) else {
            return Err(fault("the basis of its curves is not known"));
        };
        if !strand.is_empty() {
            strands.push(strand);
        }
    }
    if strands.is_empty() {
        return Ok(None);
    }
    of_strands(strands).map(Some).map_err(|message| fault(&message))
}

/// Segments of a curve as those of B-splines; `None` where the basis is not known.
fn strand(control: &[DVec4], basis: &str, wrap: &str) -> Option<Strand> {
    let mut points = control.to_vec();
    let (Some(&first), Some(&last)) = (control.first(), control.last()) else { return Some(Vec::new()) };
    let overlap = match basis {
        "linear" | "bezier" => 1,
        _ => 3,
    };
    match wrap {
        "periodic" => points.extend(control.iter().cycle().take(overlap)),
        // Points beyond both ends, so that the curve reaches them.
        "pinned" if overlap == 3 && control.len() > 1 => {
            points.push(2.0 * last - control[control.len() - 2]);
            points = iter::once(2.0 * first - control[1]).chain(points).collect();
        }
        _ => {}
    }
    let segments = |size: usize, step: usize| points.windows(size).step_by(step).map(<[DVec4]>::to_vec);
    let thin = |point: DVec4| point.truncate().extend(point.w.max(0.0));
    Some(match basis {
        "linear" => {
            let bezier = |ends: Vec<DVec4>| {
                [ends[0], ends[0].lerp(ends[1], 1.0 / 3.0), ends[0].lerp(ends[1], 2.0 / 3.0), ends[1]]
            };
            segments(2, 1).map(|ends| of_bezier(bezier(ends))).collect()
        }
        "bezier" => segments(4, 3).map(|c| of_bezier([c[0], c[1], c[2], c[3]])).collect(),
        "bspline" => segments(4, 1).map(|c| c.into_iter().map(thin).collect()).collect(),
        "catmullRom" => segments(4, 1)
            .map(|c| of_bezier([c[1], c[1] + (c[2] - c[0]) / 6.0, c[2] - (c[3] - c[1]) / 6.0, c[2]]))
            .collect(),
        _ => return None,
    })
}

/// Control points of the B-spline that is a Bezier curve.
fn of_bezier([a, b, c, d]: [DVec4; 4]) -> Vec<DVec4> {
    vec![6.0 * a - 7.0 * b + 2.0 * c, 2.0 * b - c, 2.0 * c - b, 2.0 * b - 7.0 * c + 6.0 * d]
}

/// A Bezier curve and its B-spline are the same where they begin, in the middle, and where they end.
#[test]
fn a_spline_is_its_bezier_curve() {
    let control = [[0.0, 0.0, 1.0, 0.5], [1.0, 2.0, 0.0, 0.25], [3.0, -1.0, 2.0, 0.75], [4.0, 0.0, 0.0, 1.0]];
    let bezier = control.map(DVec4::from_array);
    let spline = of_bezier(bezier);
    let sum = |points: &[DVec4], weights: [f64; 4]| -> DVec4 { points.iter().zip(weights).map(|(p, w)| *p * w).sum() };
    for (weights, others) in [
        ([1.0, 4.0, 1.0, 0.0].map(|w| w / 6.0), [1.0, 0.0, 0.0, 0.0]),
        ([1.0, 23.0, 23.0, 1.0].map(|w| w / 48.0), [0.125, 0.375, 0.375, 0.125]),
        ([0.0, 1.0, 4.0, 1.0].map(|w| w / 6.0), [0.0, 0.0, 0.0, 1.0]),
    ] {
        assert!((sum(&spline, weights) - sum(&bezier, others)).length() < 1.0e-12);
    }
}
