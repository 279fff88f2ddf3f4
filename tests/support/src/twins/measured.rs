//! Twin of `glsl/include/bsdf/measured.glsl`.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3, dvec2};
use lodestar::scene::measured::{Grids, Measured};

/// Measured material.
#[derive(Debug)]
pub struct MeasuredSurface {
    tables: Measured,
    /// Brightness and density of visible normals, of which each grid has the integral 1 over the unit square.
    brightness: Grids,
    visible: Grids,
}

/// Measured directions between which numbers are interpolated, with their weights.
type Nearest = Vec<(usize, f64)>;

/// Integral of a piecewise linear function through points of the distance 1 up to each of its points.
fn trapezoids(values: &[f64]) -> Vec<f64> {
    (0..values.len()).map(|end| (0..end).map(|i| 0.5 * (values[i] + values[i + 1])).sum()).collect()
}

fn number(grids: &Grids, nearest: &Nearest, row: usize, column: usize) -> f64 {
    let one = |at: usize| f64::from(grids.values[at * grids.area() + row * grids.size[0] + column]);
    nearest.iter().map(|(at, weight)| weight * one(*at)).sum()
}

/// Cell of a grid that has a point of the unit square, and the place of the point within it.
fn cell(grids: &Grids, u: DVec2) -> ([usize; 2], DVec2) {
    let position = u.clamp(DVec2::ZERO, DVec2::ONE) * dvec2((grids.size[0] - 1) as f64, (grids.size[1] - 1) as f64);
    let cell = [0, 1].map(|axis| (position[axis] as usize).min(grids.size[axis] - 2));
    (cell, position - dvec2(cell[0] as f64, cell[1] as f64))
}

fn mix(a: f64, b: f64, share: f64) -> f64 {
    (1.0 - share) * a + share * b
}

fn bilinear(grids: &Grids, nearest: &Nearest, u: DVec2) -> f64 {
    let ([column, row], share) = cell(grids, u);
    let along = |row| mix(number(grids, nearest, row, column), number(grids, nearest, row, column + 1), share.x);
    mix(along(row), along(row + 1), share.y)
}

/// The grids with the integral 1 each.
fn normalized(grids: &Grids) -> Grids {
    let [columns, rows] = grids.size;
    let mut values = Vec::new();
    for grid in grids.values.chunks(grids.area()) {
        let totals = grid.chunks(columns).map(|row| {
            let row: Vec<_> = row.iter().map(|&number| f64::from(number)).collect();
            trapezoids(&row)[columns - 1]
        });
        let total = trapezoids(&totals.collect::<Vec<_>>())[rows - 1] / ((columns - 1) * (rows - 1)) as f64;
        values.extend(grid.iter().map(|number| (f64::from(*number) / total) as f32));
    }
    Grids { size: grids.size, values }
}

/// The square's point of a direction (Dupuy and Jakob 2018, equation 14).
fn square(w: DVec3) -> DVec2 {
    let theta = w.truncate().length().atan2(w.z);
    dvec2((theta / FRAC_PI_2).sqrt(), (w.y.atan2(w.x) + PI) / TAU)
}

/// Index of the measured angle before an angle, and the share of the next one.
fn interval(angles: &[f32], angle: f64) -> [(usize, f64); 2] {
    let after = angles.iter().position(|&measured| f64::from(measured) > angle).unwrap_or(angles.len());
    let first = after.clamp(1, (angles.len() - 1).max(1)) - 1;
    let second = (first + 1).min(angles.len() - 1);
    let [start, end] = [first, second].map(|at| f64::from(angles[at]));
    let share = if end > start { ((angle - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
    [(first, 1.0 - share), (second, share)]
}

/// What the viewer and the light see of each other.
struct Meeting {
    nearest: Nearest,
    /// The viewer's direction in the unit square.
    viewer: DVec2,
    /// The facets' normal in the unit square.
    normal: DVec2,
    /// The sample that leads to the normal, and the normal's density.
    sample: DVec2,
    density: f64,
    jacobian: f64,
}

impl MeasuredSurface {
    pub fn new(tables: Measured) -> Self {
        Self { brightness: normalized(&tables.luminance), visible: normalized(&tables.vndf), tables }
    }

    pub fn tables(&self) -> &Measured {
        &self.tables
    }

    fn meeting(&self, wo: DVec3, wi: DVec3) -> Meeting {
        let parts = self.tables.parts();
        let below = |x: f64| if x > 0.0 { -1.0 } else { 1.0 };
        // A half turn, or mirrors, bring the viewer to the measured part.
        let mirror = match parts {
            0 | 1 => DVec2::ONE,
            4 => dvec2(below(wo.x), below(wo.y)),
            _ => DVec2::splat(below(wo.y)),
        };
        let [wo, wi] = [wo, wi].map(|w| (mirror * w.truncate()).extend(w.z));
        let viewer = square(wo);
        let angles = [(2.0 * viewer.y - 1.0) * PI, wo.truncate().length().atan2(wo.z)];
        let azimuths = interval(&self.tables.phi, angles[0]);
        let elevations = interval(&self.tables.theta, angles[1]);
        let pairs = azimuths.iter().flat_map(|a| elevations.iter().map(move |e| (*a, *e)));
        let nearest = pairs.map(|((i, x), (j, y))| (i * self.tables.theta.len() + j, x * y)).collect();
        let m = (wo + wi).normalize();
        let mut normal = square(m);
        if self.tables.is_isotropic() {
            normal.y += 0.5 - viewer.y;
        }
        normal.y -= normal.y.floor();
        let sine = m.truncate().length();
        let jacobian = (2.0 * PI * PI * normal.x * sine).max(1.0e-6) * 4.0 * wo.dot(m);
        let (sample, density) = self.inverse(&nearest, normal);
        Meeting { nearest, viewer, normal, sample, density, jacobian }
    }

    /// Shares of the visible normals before a point: in its row, and of the rows; and the density there.
    fn inverse(&self, nearest: &Nearest, u: DVec2) -> (DVec2, f64) {
        let grids = &self.visible;
        let [columns, rows] = grids.size;
        let ([column, row], share) = cell(grids, u);
        let line = |row: usize| (0..columns).map(|column| number(grids, nearest, row, column)).collect::<Vec<_>>();
        let [first, second] = [line(row), line(row + 1)];
        let mixed: Vec<_> = first.iter().zip(&second).map(|(a, b)| mix(*a, *b, share.y)).collect();
        let area = |values: &[f64], at: usize, share: f64| {
            let end = mix(values[at], values[at + 1], share);
            trapezoids(values)[at] + 0.5 * share * (values[at] + end)
        };
        let along = area(&mixed, column, share.x) / trapezoids(&mixed)[columns - 1];
        let totals: Vec<_> = (0..rows).map(|row| trapezoids(&line(row))[columns - 1]).collect();
        let down = area(&totals, row, share.y) / trapezoids(&totals)[rows - 1];
        (dvec2(along, down), mix(mixed[column], mixed[column + 1], share.x))
    }

    /// Value f cos.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return DVec3::ZERO;
        }
        let at = self.meeting(wo, wi);
        if at.density <= 0.0 {
            return DVec3::ZERO;
        }
        let one = vec![(0, 1.0)];
        let color = DVec3::from([0, 1, 2].map(|i| bilinear(&self.tables.colors[i], &at.nearest, at.sample)));
        color * bilinear(&self.tables.ndf, &one, at.normal) / (4.0 * bilinear(&self.tables.sigma, &one, at.viewer))
    }

    /// Density of samples.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let at = self.meeting(wo, wi);
        at.density * bilinear(&self.brightness, &at.nearest, at.sample) / at.jacobian
    }
}
