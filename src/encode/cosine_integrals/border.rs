//! Integrals of a clamped cosine over a part of the sphere, computed along the part's border.
//!
//! By Stokes' theorem, the integral of n.w over a part is half the integral of n.(r x dr) around it, counterclockwise
//! (Lambert's formula for the illumination by a polygon). Where the horizon cuts the part, an arc of the horizon closes
//! the border above it; the integral along the arc is its angle.

use glam::DVec3;

/// Border of a part of the sphere that is smaller than a hemisphere and has curved edges.
pub(super) struct Border {
    pieces: Vec<Piece>,
}

/// Short curve, approximated by a parabola. The error of its integrals is of the fourth power of its length.
struct Piece {
    ends: [DVec3; 2],
    linear: DVec3,
    quadratic: DVec3,
}

/// Number of bisections that find where a piece meets the horizon, to the last bit of a double.
const HALVINGS: u32 = 52;

impl Border {
    /// Border through points around a part, counterclockwise seen from outside. Every second point is the middle of a
    /// piece.
    pub fn new(points: &[DVec3]) -> Self {
        let next = |at: usize| points[at % points.len()];
        Self {
            pieces: (0..points.len()).step_by(2).map(|at| Piece::new(points[at], next(at + 1), next(at + 2))).collect(),
        }
    }

    /// Integral of max(0, n.w) over the part, sr.
    pub fn cosine_integral(&self, n: DVec3) -> f64 {
        let mut twice = 0.0;
        // First point where the border meets the horizon; angles are measured from it.
        let mut origin = None;
        for piece in &self.pieces {
            let [begins_above, ends_above] = piece.ends.map(|end| end.dot(n) > 0.0);
            if begins_above && ends_above {
                twice += piece.moment(1.0).dot(n);
            } else if begins_above != ends_above {
                let t = piece.horizon(n);
                let point = piece.at(t);
                let angle = angle_about(n, *origin.get_or_insert(point), point);
                let before = piece.moment(t).dot(n);
                twice += if begins_above { before - angle } else { piece.moment(1.0).dot(n) - before + angle };
            }
        }
        0.5 * twice
    }
}

impl Piece {
    fn new(start: DVec3, middle: DVec3, end: DVec3) -> Self {
        let linear = 4.0 * middle - 3.0 * start - end;
        Self { ends: [start, end], linear, quadratic: 2.0 * (start + end) - 4.0 * middle }
    }

    /// Point of the piece at `t` in [0, 1].
    fn at(&self, t: f64) -> DVec3 {
        self.ends[0] + t * (self.linear + t * self.quadratic)
    }

    /// Integral of r x dr from the start of the piece to `t`.
    fn moment(&self, t: f64) -> DVec3 {
        let Self { ends: [start, _], linear, quadratic } = *self;
        t * (start.cross(linear) + t * (start.cross(quadratic) + t / 3.0 * linear.cross(quadratic)))
    }

    /// Parameter `t` at which the piece meets the horizon. Its ends must lie on either side.
    fn horizon(&self, n: DVec3) -> f64 {
        let begins_above = self.ends[0].dot(n) > 0.0;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let as_begun = (self.at(middle).dot(n) > 0.0) == begins_above;
            (low, high) = if as_begun { (middle, high) } else { (low, middle) };
        }
        low
    }
}

/// Angle of the turn about `n` from one point of the horizon to another, in (-pi, pi].
fn angle_about(n: DVec3, from: DVec3, to: DVec3) -> f64 {
    n.dot(from.cross(to)).atan2(from.dot(to))
}
