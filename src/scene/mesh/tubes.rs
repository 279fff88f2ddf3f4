//! Meshes of tubes: rings of flat sides, joined by triangles.
//!
//! A frame turns as little as possible from ring to ring (Wang et al. 2008, "Computation of Rotation Minimizing Frames"), so
//! that the sides do not twist. The corners of a ring lie outside its circle and the middles of its sides inside, so that
//! the mean distance from the center, over all directions, is the radius. That is also the mean half width of the tube
//! as seen from any side: it ends where the interpolated normal is perpendicular to the view.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, DVec4, Vec2};

use super::rings::{self, Bounds, Curve, Kind, Ring, TooMany};
use super::triangles::{MAX_TRIANGLES, Mesh};

/// Largest distances between mesh and surface, as shares of the radius, the preferred one first.
const DEVIATIONS: [f64; 6] = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32];

/// Number of triangles of a file above which a larger distance is taken.
const MANY_TRIANGLES: usize = 1 << 21;

/// Control points of the uniform cubic B-splines that lie one after the other along a strand, each a place and a radius.
pub(in crate::scene) type Strand = Vec<Vec<DVec4>>;

/// Mesh of strands. Texture coordinates are those of [`mesh`], except that `v` runs from 0 to 1 along each strand.
pub(in crate::scene) fn of_strands(strands: Vec<Strand>) -> Result<Mesh, String> {
    let lengths: Vec<usize> = strands.iter().map(Vec::len).collect();
    let curve = |points| Curve { kind: Kind::BSpline, points };
    let curves: Vec<_> = strands.into_iter().flatten().map(curve).collect();
    mesh_of(&curves, &lengths)
}

/// Makes a mesh of curves, with normals and Mitsuba's texture coordinates. The error says why there is none.
pub(super) fn mesh(curves: &[Curve]) -> Result<Mesh, String> {
    mesh_of(curves, &[curves.len()])
}

/// Mesh of strands that have these numbers of curves.
fn mesh_of(curves: &[Curve], lengths: &[usize]) -> Result<Mesh, String> {
    let last = DEVIATIONS.len() - 1;
    for (level, &deviation) in DEVIATIONS.iter().enumerate() {
        let limit = if level == last { MAX_TRIANGLES } else { MANY_TRIANGLES };
        let quality = Quality::new(deviation);
        match quality.count(curves, limit) {
            Ok(0) => {
                return Err(
                    "the curves have no surface: all radii are 0, or all control points of a curve are equal".into()
                );
            }
            Ok(count) => return Ok(quality.mesh(curves, lengths, count)),
            Err(TooMany) => {}
        }
    }
    Err(format!("even as coarse tubes, the curves have more than {MAX_TRIANGLES} triangles; use fewer control points"))
}

/// Number of sides and distances of rings.
struct Quality {
    sides: u32,
    bounds: Bounds,
    /// Distance from the center to the corners of a ring, in radii.
    corner: f64,
    deviation: f64,
}

impl Quality {
    /// Quality at which no point is farther than `deviation` radii from the surface. Half of it is due to the sides, the rest
    /// to the distance of rings and to their turning.
    fn new(deviation: f64) -> Self {
        // For half the angle x of a side, corners are farther out by x^2 / 3 radii, and the middles of sides nearer by half that.
        let sides = (PI / (1.5 * deviation).sqrt()).ceil();
        let half = PI / sides;
        // The distance to a side is cos x / cos a in the direction a. Its mean is cos x times the mean of 1 / cos a.
        let mean = half.cos() * (half.tan() + 1.0 / half.cos()).ln() / half;
        let bounds = Bounds { sag: deviation / 4.0, turn: 2.0 * (1.0 - deviation / 4.0).acos() };
        Self { sides: sides as u32, bounds, corner: 1.0 / mean, deviation }
    }

    /// Number of triangles of all curves, at most `limit`.
    fn count(&self, curves: &[Curve], limit: usize) -> Result<usize, TooMany> {
        let mut count = 0;
        for curve in curves {
            let mut last = None;
            rings::make(curve, self.bounds, &mut |ring| {
                let before = last.replace(ring.radius).filter(|_| !ring.is_first);
                let radii = before.map_or([0.0; 2], |before| [before, ring.radius]);
                count += self.sides as usize * radii.iter().filter(|radius| **radius > 0.0).count();
                if count > limit { Err(TooMany) } else { Ok(()) }
            })?;
        }
        Ok(count)
    }

    fn mesh(&self, mut curves: &[Curve], lengths: &[usize], triangles: usize) -> Mesh {
        let mut mesh = Mesh { triangles: Vec::with_capacity(triangles), ..Mesh::default() };
        let mut sag = self.bounds.sag;
        for &length in lengths {
            let (strand, others) = curves.split_at(length);
            let segments: usize = strand.iter().map(Curve::segment_count).sum();
            let mut before = 0;
            for curve in strand {
                let mut tube = Tube { mesh: &mut mesh, quality: self, last: None };
                let made = rings::make(curve, self.bounds, &mut |ring| {
                    tube.add(ring, (before as f64 + ring.v) / segments as f64);
                    Ok(())
                });
                sag = sag.max(made.unwrap_or(0.0));
                before += curve.segment_count();
            }
            curves = others;
        }
        mesh.deviation = (self.deviation + sag - self.bounds.sag) as f32;
        mesh
    }
}

/// Directions across a tube.
#[derive(Clone, Copy)]
struct Frame {
    /// Direction of the first corner.
    first: DVec3,
    /// Angle from there to the direction in which Mitsuba's u is 0. It does not jump from ring to ring.
    zero: f64,
}

impl Frame {
    /// Frame of a tube's first ring, whose first corner has u = 0.
    fn begin(ring: &Ring) -> Self {
        Self { first: direction_of_zero(ring.tangent), zero: 0.0 }
    }

    /// Frame of the ring `next`, moved from the ring `last` by two reflections.
    fn moved(self, last: &Ring, next: &Ring) -> Self {
        let step = next.place - last.place;
        // Where the curve turns on the spot, the first reflection is that of a step ahead.
        let step = if step == DVec3::ZERO { last.tangent } else { step };
        let [first, tangent] = [self.first, last.tangent].map(|vector| reflected(vector, step));
        let first = reflected(first, next.tangent - tangent);
        // Rounding does not add up.
        let first = first.reject_from_normalized(next.tangent).try_normalize();
        let first = first.unwrap_or_else(|| next.tangent.any_orthonormal_vector());
        let zero = direction_of_zero(next.tangent);
        let angle = zero.dot(next.tangent.cross(first)).atan2(zero.dot(first));
        Self { first, zero: angle + TAU * ((self.zero - angle) / TAU).round() }
    }
}

/// Reflection of a vector in the plane through the origin with this normal, of any length; the vector itself where the
/// normal is 0.
fn reflected(vector: DVec3, normal: DVec3) -> DVec3 {
    let normal = normal.normalize_or_zero();
    vector - 2.0 * vector.dot(normal) * normal
}

/// Direction across a tube in which Mitsuba's u is 0.
fn direction_of_zero(tangent: DVec3) -> DVec3 {
    let quarter = DVec3::Z.reject_from_normalized(tangent).try_normalize().unwrap_or(DVec3::Y);
    quarter.cross(tangent)
}

/// Tube that is being added to a mesh.
struct Tube<'a> {
    mesh: &'a mut Mesh,
    quality: &'a Quality,
    last: Option<(Ring, Frame)>,
}

impl Tube<'_> {
    /// Adds a ring, and the triangles between it and the last one.
    fn add(&mut self, ring: &Ring, v: f64) {
        let (sides, begin) = (self.quality.sides, self.mesh.positions.len() as u32);
        let frame = match &self.last {
            Some((last, frame)) => frame.moved(last, ring),
            None => Frame::begin(ring),
        };
        let second = ring.tangent.cross(frame.first);
        // The last column repeats the first, with u one higher.
        for column in 0..=sides {
            let angle = |column: u32| TAU * f64::from(column) / f64::from(sides);
            let (sine, cosine) = angle(column % sides).sin_cos();
            let outward = cosine * frame.first + sine * second;
            let corner = ring.place + ring.offset * ring.tangent + self.quality.corner * ring.radius * outward;
            self.mesh.positions.push(corner.as_vec3());
            self.mesh.normals.push(ring.normal(outward).normalize_or_zero().as_vec3());
            self.mesh.uvs.push(Vec2::new(((angle(column) - frame.zero) / TAU) as f32, v as f32));
        }
        if let Some((last, _)) = self.last.as_ref().filter(|_| !ring.is_first) {
            let (below, above) = (begin - sides - 1, begin);
            for column in 0..sides {
                if last.radius > 0.0 {
                    self.mesh.triangles.push([below + column, below + column + 1, above + column + 1]);
                }
                if ring.radius > 0.0 {
                    self.mesh.triangles.push([below + column, above + column + 1, above + column]);
                }
            }
        }
        self.last = Some((ring.clone(), frame));
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec4;

    use super::super::rings::Kind;
    use super::*;

    fn curve(kind: Kind, radius: f64) -> Curve {
        let point = |at: u32| {
            let (y, x) = (0.9 * f64::from(at)).sin_cos();
            DVec4::new(x, y, 0.3 * f64::from(at), radius * f64::from(1 + at % 3))
        };
        Curve { kind, points: (0..8).map(point).collect() }
    }

    /// Corners and middles of sides are within half the deviation, and the mean distance from the center is the radius.
    #[test]
    fn rings_have_the_radius_on_average() {
        for deviation in DEVIATIONS {
            let Quality { sides, corner, bounds, .. } = Quality::new(deviation);
            let half = PI / f64::from(sides);
            let middle = corner * half.cos();
            assert!(
                corner - 1.0 < 0.55 * deviation && 1.0 - middle < 0.55 * deviation,
                "{deviation}: {corner} {middle}"
            );
            let distance = |step: u32| middle / (half * (f64::from(step) + 0.5) / 1000.0).cos();
            let mean = (0..1000).map(distance).sum::<f64>() / 1000.0;
            assert!((mean - 1.0).abs() < 1e-6, "{deviation}: {mean}");
            assert!(1.0 - (0.5 * bounds.turn).cos() <= 0.2501 * deviation);
        }
    }

    #[test]
    fn triangles_are_counted_before_they_are_made() {
        let curves = [curve(Kind::Linear, 0.1), curve(Kind::BSpline, 0.1), curve(Kind::Linear, 0.0)];
        let mut last = usize::MAX;
        for deviation in DEVIATIONS {
            let quality = Quality::new(deviation);
            let count = quality.count(&curves, MAX_TRIANGLES).ok().unwrap();
            let mesh = quality.mesh(&curves, &[curves.len()], count);
            assert_eq!(mesh.triangles.len(), count);
            assert!((f64::from(mesh.deviation) / deviation - 1.0).abs() < 1e-6);
            assert!(count < last, "{deviation}: {count}");
            assert!(quality.count(&curves, count - 1).is_err() && quality.count(&curves, count).is_ok());
            last = count;
        }
    }

    /// Many curves are coarser, and too many are refused in the time that it takes to count.
    #[test]
    fn many_curves_are_coarser() {
        let made = |count: usize| mesh(&vec![curve(Kind::Linear, 0.1); count]);
        let (few, many) = (made(1).unwrap(), made(600).unwrap());
        assert!((few.deviation - 0.01).abs() < 1e-6 && many.deviation > 0.015, "{}", many.deviation);
        assert!(many.triangles.len() <= MANY_TRIANGLES && many.triangles.len() > 100 * few.triangles.len());
        let error = made(300_000).map(drop).unwrap_err();
        assert!(error.contains(&MAX_TRIANGLES.to_string()), "{error}");
    }

    /// A spline that would need more halvings than there may be says how far it is off.
    #[test]
    fn thin_splines_say_how_far_they_are_off() {
        let mesh = mesh(&[curve(Kind::BSpline, 1e-9)]).unwrap();
        assert!(mesh.deviation > 0.3, "{}", mesh.deviation);
    }
}
