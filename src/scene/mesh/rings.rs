//! Rings of tubes: the circles of which the surface of a curve consists, at places where straight lines between them stay
//! near the surface.
//!
//! Both kinds of surface are those of Mitsuba 3. A linear curve is the hull of the spheres at the two ends of each segment:
//! a cone between two spheres, with a sphere at each joint and at both ends. A B-spline curve is a circle that is
//! swept along the spline, perpendicular to it, without caps.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, DVec4, Vec4Swizzles};

/// Most halvings of a segment of a spline.
const MAX_HALVINGS: u32 = 12;

/// Largest change of the radius from one ring to the next, as a share of the segment's largest radius. Normals are
/// interpolated well only on triangles whose corners are about as far apart on both rings.
const MAX_TAPER: f64 = 0.125;

/// Share of a spline's size below which its derivative counts as 0.
const NO_SPEED: f64 = 1e-9;

/// Step from a place without a tangent to one that has it, as a share of the segment.
const NUDGE: f64 = 1.0 / 4096.0;

/// Cosine of the angle between two tangents that are the same but for rounding.
const SAME_DIRECTION: f64 = 1.0 - 1e-9;

/// Kinds of curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::scene) enum Kind {
    Linear,
    /// Uniform cubic B-spline.
    BSpline,
}

impl Kind {
    /// Name of Mitsuba's plugin.
    pub fn plugin(self) -> &'static str {
        match self {
            Self::Linear => "linearcurve",
            Self::BSpline => "bsplinecurve",
        }
    }

    /// Least number of control points, with which a curve has one segment.
    pub fn least_points(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::BSpline => 4,
        }
    }
}

/// Curve with its control points: place and radius.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    pub kind: Kind,
    pub points: Vec<DVec4>,
}

impl Curve {
    /// Number of segments.
    pub fn segment_count(&self) -> usize {
        self.points.len() + 1 - self.kind.least_points()
    }
}

/// Circle of a surface.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ring {
    /// Point of the curve.
    pub place: DVec3,
    /// Direction of the curve, to which the circle is perpendicular, of length 1.
    pub tangent: DVec3,
    /// Distance from the point of the curve to the center of the circle, along the tangent.
    pub offset: f64,
    pub radius: f64,
    /// Terms of the normal: at the point in direction `d` from the center, it is `across(d) d + slope tangent`.
    pub slope: f64,
    pub share: f64,
    pub bend: DVec3,
    /// Number of segments of the curve up to here.
    pub v: f64,
    /// Whether no surface joins it to the ring before it.
    pub is_first: bool,
}

impl Ring {
    /// Normal of the surface at the point in direction `outward` from the center, not of unit length. It points outward.
    pub fn normal(&self, outward: DVec3) -> DVec3 {
        let across = self.share - outward.dot(self.bend);
        // Where the surface folds over, because it bends more than its radius allows, the bend is left out. So does Embree,
        // with which Mitsuba tells the outside.
        let across = if across > 0.0 { across } else { self.share };
        across * outward + self.slope * self.tangent
    }
}

/// Bounds on the distance between surface and mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Largest distance between the surface and straight lines along it, as a share of the radius.
    pub sag: f64,
    /// Largest turn from one ring to the next, in radians.
    pub turn: f64,
}

/// Error of a receiver of rings that takes no more.
pub(super) struct TooMany;

type Result<T> = std::result::Result<T, TooMany>;

/// Receiver of the rings of a curve, from its beginning to its end.
pub(super) type Receiver<'a> = dyn FnMut(&Ring) -> Result<()> + 'a;

/// Makes the rings of a curve. Returns the largest distance between surface and lines, as a share of the radius: that of
/// `bounds`, or more where segments would have to be halved too often.
pub(super) fn make(curve: &Curve, bounds: Bounds, receiver: &mut Receiver) -> Result<f64> {
    let mut rings = Rings { bounds, receiver, last: None, sag: bounds.sag };
    match curve.kind {
        Kind::Linear => rings.add_linear(&curve.points)?,
        Kind::BSpline => rings.add_spline(&curve.points)?,
    }
    Ok(rings.sag)
}

/// Rings of one curve while they are made.
struct Rings<'r, 'a> {
    bounds: Bounds,
    receiver: &'r mut Receiver<'a>,
    last: Option<Ring>,
    /// Largest distance between surface and lines so far, at least that of the bounds.
    sag: f64,
}

impl Rings<'_, '_> {
    fn push(&mut self, ring: Ring) -> Result<()> {
        (self.receiver)(&ring)?;
        self.last = Some(ring);
        Ok(())
    }

    /// Adds the rings of cones and spheres.
    fn add_linear(&mut self, points: &[DVec4]) -> Result<()> {
        let balls = balls(points);
        let cones = cones(&balls);
        let (Some(first), Some(last)) = (cones.first(), cones.last()) else { return Ok(()) };
        let front = Cone { angle: -FRAC_PI_2, ..*first };
        let back = Cone { angle: FRAC_PI_2, ..*last };
        self.push(Ring { is_first: true, ..balls[0].ring(&front) })?;
        for (index, ball) in balls.iter().enumerate() {
            let before = if index == 0 { &front } else { &cones[index - 1] };
            let after = cones.get(index).unwrap_or(&back);
            if index > 0 {
                self.add_cone(&balls[index - 1], ball, before)?;
            }
            self.add_joint(ball, before, after)?;
        }
        Ok(())
    }

    /// Adds the rings of a cone after the first.
    fn add_cone(&mut self, begin: &Ball, end: &Ball, cone: &Cone) -> Result<()> {
        let taper = (begin.radius - end.radius).abs() / begin.radius.max(end.radius).max(f64::MIN_POSITIVE);
        let steps = if cone.angle.abs() < FRAC_PI_2 { (taper / MAX_TAPER).ceil().max(1.0) } else { 1.0 };
        for step in 1..=steps as u32 {
            self.push(begin.towards(end, f64::from(step) / steps).ring(cone))?;
        }
        Ok(())
    }

    /// Adds the rings on a sphere from the circle at which a cone before it ends up to the circle at which a cone after it
    /// begins. What no cone hides of the sphere lies between the two.
    fn add_joint(&mut self, ball: &Ball, before: &Cone, after: &Cone) -> Result<()> {
        let turn = before.tangent.angle_between(after.tangent);
        let largest = turn.max((after.angle - before.angle).abs());
        if ball.radius == 0.0 || largest < 1e-12 {
            return Ok(());
        }
        let axis = before.tangent.cross(after.tangent).try_normalize();
        let axis = axis.unwrap_or_else(|| before.tangent.any_orthonormal_vector());
        let sideways = axis.cross(before.tangent);
        let steps = (largest / self.bounds.turn).ceil();
        for step in 1..=steps as u32 {
            let share = f64::from(step) / steps;
            let (sine, cosine) = (share * turn).sin_cos();
            let tangent = (cosine * before.tangent + sine * sideways).normalize();
            let angle = before.angle + share * (after.angle - before.angle);
            self.push(ball.ring(&Cone { tangent, angle }))?;
        }
        Ok(())
    }

    /// Adds the rings of a swept circle.
    fn add_spline(&mut self, points: &[DVec4]) -> Result<()> {
        let size = points.iter().map(|point| (*point - points[0]).xyz().length()).fold(0.0, f64::max);
        for (index, controls) in points.windows(4).enumerate() {
            let span = Span { controls: [controls[0], controls[1], controls[2], controls[3]], index, size };
            // Equal control points make no surface.
            let Some(tangent) = span.tangent(0.0) else { continue };
            // Where the spline stops and goes on in another direction, the surface is open.
            if self.last.as_ref().is_none_or(|last| last.tangent.dot(tangent) < SAME_DIRECTION) {
                self.push(Ring { is_first: true, ..span.ring(0.0, None) })?;
            }
            self.add_span(&span, 0.0, 1.0, MAX_HALVINGS)?;
        }
        Ok(())
    }

    /// Adds the rings after `begin` up to `end`.
    fn add_span(&mut self, span: &Span, begin: f64, end: f64, halvings: u32) -> Result<()> {
        let middle = 0.5 * (begin + end);
        let [first, center, last] = [begin, middle, end].map(|u| span.at(u));
        let radius = first.w.max(center.w).max(last.w);
        let [turn_before, turn_after] = [(begin, middle), (middle, end)].map(|(a, b)| span.turn(a, b));
        let turn = turn_before + turn_after;
        // The second derivative of a cubic is linear, so that it is largest at an end.
        let second = [begin, end].map(|u| span.second(u)).map(|second| second.xyz().length() + second.w.abs());
        let sag = second[0].max(second[1]) * (end - begin).powi(2) / 8.0 + (last.w - first.w).abs() * turn / 4.0;
        let is_even = (last.w - first.w).abs() <= MAX_TAPER * span.largest_radius();
        let is_near = radius == 0.0 || is_even && sag <= self.bounds.sag * radius && turn <= self.bounds.turn;
        if is_near || halvings == 0 {
            self.sag = if radius > 0.0 { self.sag.max(sag / radius) } else { self.sag };
            let ring = span.ring(end, self.last.as_ref());
            return self.push(ring);
        }
        self.add_span(span, begin, middle, halvings - 1)?;
        self.add_span(span, middle, end, halvings - 1)
    }
}

/// Sphere at a control point of a linear curve.
struct Ball {
    center: DVec3,
    radius: f64,
    v: f64,
}

impl Ball {
    /// Sphere between this one and another, at a share of the way.
    fn towards(&self, other: &Self, share: f64) -> Self {
        let lerp = |a: f64, b: f64| a + share * (b - a);
        let center = if share < 1.0 { self.center.lerp(other.center, share) } else { other.center };
        Self { center, radius: lerp(self.radius, other.radius), v: lerp(self.v, other.v) }
    }

    /// Circle in which a cone around the spheres of two control points touches this one.
    fn ring(&self, cone: &Cone) -> Ring {
        let (sine, cosine) = cone.angle.sin_cos();
        // At the pole, the cosine is off 0 by rounding.
        let cosine = if cosine < 1e-12 { 0.0 } else { cosine };
        Ring {
            place: self.center,
            tangent: cone.tangent,
            offset: sine * self.radius,
            radius: cosine * self.radius,
            slope: sine,
            share: cosine,
            bend: DVec3::ZERO,
            v: self.v,
            is_first: false,
        }
    }
}

/// Spheres at the control points. Of equal ones that follow each other, the first is left.
fn balls(points: &[DVec4]) -> Vec<Ball> {
    let mut balls: Vec<Ball> = Vec::with_capacity(points.len());
    for (index, point) in points.iter().enumerate() {
        if balls.last().is_none_or(|last| (last.center, last.radius) != (point.xyz(), point.w)) {
            balls.push(Ball { center: point.xyz(), radius: point.w, v: index as f64 });
        }
    }
    balls
}

/// Direction of a cone, and the angle of its normals with the circle's plane, positive where it becomes narrower.
#[derive(Clone, Copy)]
struct Cone {
    tangent: DVec3,
    angle: f64,
}

/// Cones between the spheres; none around a single sphere, of which Mitsuba shows nothing. Where one sphere holds the next, the cone is the point at which they would touch.
fn cones(balls: &[Ball]) -> Vec<Cone> {
    let direction = |pair: &[Ball]| (pair[1].center - pair[0].center).try_normalize();
    // Spheres with one center have the direction of the segment before them.
    let mut tangent = balls.windows(2).find_map(direction).unwrap_or(DVec3::Z);
    let mut cones: Vec<Cone> = Vec::with_capacity(balls.len());
    for pair in balls.windows(2) {
        tangent = direction(pair).unwrap_or(tangent);
        let (narrowing, length) = (pair[0].radius - pair[1].radius, pair[0].center.distance(pair[1].center));
        let angle = if narrowing.abs() >= length { FRAC_PI_2.copysign(narrowing) } else { (narrowing / length).asin() };
        cones.push(Cone { tangent, angle });
    }
    cones
}

/// Segment of a uniform cubic B-spline, over u from 0 to 1: place and radius.
struct Span {
    controls: [DVec4; 4],
    /// Number of segments before it.
    index: usize,
    /// Size of the whole spline.
    size: f64,
}

impl Span {
    fn sum(&self, weights: [f64; 4]) -> DVec4 {
        self.controls.iter().zip(weights).map(|(control, weight)| *control * weight).sum()
    }

    /// Place and radius.
    fn at(&self, u: f64) -> DVec4 {
        let w = 1.0 - u;
        let inner = |u: f64| (3.0 * u - 6.0) * u * u + 4.0;
        self.sum([w * w * w, inner(u), inner(w), u * u * u]) / 6.0
    }

    fn first(&self, u: f64) -> DVec4 {
        let w = 1.0 - u;
        self.sum([-w * w, (3.0 * u - 4.0) * u, (4.0 - 3.0 * w) * w, u * u]) / 2.0
    }

    fn second(&self, u: f64) -> DVec4 {
        let w = 1.0 - u;
        self.sum([w, 3.0 * u - 2.0, 3.0 * w - 2.0, u])
    }

    fn largest_radius(&self) -> f64 {
        self.controls.iter().map(|control| control.w).fold(0.0, f64::max)
    }

    /// Angle between the tangents at two places; 0 where one has none.
    fn turn(&self, a: f64, b: f64) -> f64 {
        match (self.tangent(a), self.tangent(b)) {
            (Some(a), Some(b)) => a.angle_between(b),
            _ => 0.0,
        }
    }

    /// Direction of the spline; where it stops, the direction close by.
    fn tangent(&self, u: f64) -> Option<DVec3> {
        let nearby = if u < 0.5 { u + NUDGE } else { u - NUDGE };
        let speeds = [u, nearby].map(|u| self.first(u).xyz());
        speeds.into_iter().find(|speed| self.is_moving(*speed)).and_then(DVec3::try_normalize)
    }

    fn is_moving(&self, speed: DVec3) -> bool {
        speed.length() > NO_SPEED * self.size
    }

    /// Ring at `u`. A place without a direction has that of the ring before it.
    fn ring(&self, u: f64, before: Option<&Ring>) -> Ring {
        let (point, first, second) = (self.at(u), self.first(u), self.second(u));
        let tangent = self.tangent(u).or(before.map(|ring| ring.tangent)).unwrap_or(DVec3::Z);
        let (slope, bend) = match self.is_moving(first.xyz()) {
            true => (-first.w / first.xyz().length(), point.w * second.xyz() / first.xyz().length_squared()),
            false => (0.0, DVec3::ZERO),
        };
        Ring {
            place: point.xyz(),
            tangent,
            offset: 0.0,
            radius: point.w,
            slope,
            share: 1.0,
            bend,
            v: self.index as f64 + u,
            is_first: false,
        }
    }
}
