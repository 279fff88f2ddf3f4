//! Twin of `glsl/include/texture/voronoi.glsl`, in double precision.

use glam::{DVec3, DVec4, IVec4};

use super::hashed::{of_cell, of_floats, white_noise};

/// Settings of a Voronoi diagram.
#[derive(Debug, Clone, Copy)]
pub struct Voronoi {
    pub dimensions: usize,
    pub feature: u32,
    pub metric: u32,
    pub normalized: bool,
    pub exponent: f64,
    pub detail: f64,
    pub roughness: f64,
    pub lacunarity: f64,
    pub smoothness: f64,
    pub randomness: f64,
}

/// Distance, color and position.
type Found = (f64, DVec3, DVec4);

impl Voronoi {
    fn distance(&self, d: DVec4) -> f64 {
        let d = d.abs().to_array();
        let used = &d[..self.dimensions];
        match self.metric {
            1 => used.iter().sum(),
            2 => used.iter().fold(0.0, |most, &x| most.max(x)),
            3 => used.iter().map(|x| x.powf(self.exponent)).sum::<f64>().powf(1.0 / self.exponent),
            _ => used.iter().map(|x| x * x).sum::<f64>().sqrt(),
        }
    }

    fn point(&self, cell: IVec4) -> DVec4 {
        let jitter = match self.dimensions {
            1 => DVec4::new(of_floats(&[f64::from(cell.x)]), 0.0, 0.0, 0.0),
            count => of_cell(count, cell),
        };
        let used = DVec4::from_array([0, 1, 2, 3].map(|axis| if axis < self.dimensions { 1.0 } else { 0.0 }));
        cell.as_dvec4() + self.randomness * jitter * used
    }

    fn color(&self, cell: IVec4) -> DVec3 {
        match self.dimensions {
            1 => white_noise(&[f64::from(cell.x)]),
            count => of_cell(count.max(3), cell).truncate(),
        }
    }

    /// Cells around one, x first.
    fn around(&self, center: IVec4, reach: i32) -> Vec<IVec4> {
        let side = 2 * reach + 1;
        (0..side.pow(self.dimensions as u32))
            .map(|number| {
                let digit = |axis: u32| {
                    if (axis as usize) < self.dimensions { number / side.pow(axis) % side - reach } else { 0 }
                };
                center + IVec4::new(digit(0), digit(1), digit(2), digit(3))
            })
            .collect()
    }

    fn octave(&self, p: DVec4) -> Found {
        let cell = p.floor().as_ivec4();
        let sorted = |voronoi: &Self, at: DVec4, cells: Vec<IVec4>| {
            let mut cells: Vec<(f64, IVec4)> =
                cells.into_iter().map(|cell| (voronoi.distance(voronoi.point(cell) - at), cell)).collect();
            cells.sort_by(|a, b| a.0.total_cmp(&b.0));
            cells
        };
        let plain = Self { metric: 0, ..*self };
        match self.feature {
            0 | 1 => {
                let (distance, cell) = sorted(self, p, self.around(cell, 1))[self.feature as usize];
                (distance, self.color(cell), self.point(cell))
            }
            2 => {
                let mut smooth: Option<Found> = None;
                for cell in self.around(cell, 2) {
                    let next = (self.distance(self.point(cell) - p), self.color(cell), self.point(cell));
                    let Some(before) = smooth else {
                        smooth = Some(next);
                        continue;
                    };
                    let t = (0.5 + 0.5 * (before.0 - next.0) / self.smoothness).clamp(0.0, 1.0);
                    let h = t * t * (3.0 - 2.0 * t);
                    let less = self.smoothness * h * (1.0 - h);
                    let little = less / (1.0 + 3.0 * self.smoothness);
                    let used =
                        DVec4::from_array([0, 1, 2, 3].map(|axis| if axis < self.dimensions { 1.0 } else { 0.0 }));
                    smooth = Some((
                        before.0 + (next.0 - before.0) * h - less,
                        before.1.lerp(next.1, h) - little,
                        before.2.lerp(next.2, h) - little * used,
                    ));
                }
                smooth.unwrap_or_default()
            }
            3 if self.dimensions == 1 => {
                let at = |by: i32| self.point(cell + IVec4::new(by, 0, 0, 0)).x;
                let to = |by: i32| (0.5 * (at(0) + at(by)) - p.x).abs();
                (to(-1).min(to(1)), DVec3::ZERO, DVec4::ZERO)
            }
            3 => {
                let nearest = self.point(sorted(&plain, p, self.around(cell, 1))[0].1);
                let edge = |other: DVec4| {
                    let across = other - nearest;
                    let far = across.length_squared() > 0.0001;
                    if far { (0.5 * (nearest + other) - p).dot(across.normalize()) } else { f64::INFINITY }
                };
                let least =
                    self.around(cell, 1).into_iter().map(|cell| edge(self.point(cell))).fold(f64::INFINITY, f64::min);
                (least, DVec3::ZERO, DVec4::ZERO)
            }
            _ => {
                let nearest = sorted(&plain, p, self.around(cell, 1))[0].1;
                let others = self.around(nearest, 1).into_iter().filter(|&other| other != nearest).collect();
                (0.5 * sorted(&plain, self.point(nearest), others)[0].0, DVec3::ZERO, DVec4::ZERO)
            }
        }
    }

    /// Sum of octaves.
    pub fn value(mut self, p: DVec4) -> Found {
        self.detail = self.detail.clamp(0.0, 15.0);
        self.roughness = self.roughness.clamp(0.0, 1.0);
        self.randomness = self.randomness.clamp(0.0, 1.0);
        self.smoothness = (0.5 * self.smoothness).clamp(0.0, 0.5);
        if self.feature == 2 && self.smoothness == 0.0 {
            self.feature = 0;
        }
        let side = 0.5 + 0.5 * self.randomness;
        let reach = match self.feature {
            3 => side,
            1 => 2.0 * self.distance(DVec4::splat(side)),
            _ => self.distance(DVec4::splat(side)),
        };
        if self.detail == 0.0 || self.roughness == 0.0 || self.feature == 4 {
            let (distance, color, position) = self.octave(p);
            let most = if self.normalized && self.feature != 4 { reach } else { 1.0 };
            // The first octave of distances to edges is compared with 8 otherwise.
            return (distance / most, color, position);
        }
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let (mut distance, mut color, mut position) =
            (if self.feature == 3 { 8.0 } else { 0.0 }, DVec3::ZERO, DVec4::ZERO);
        let mut amplitudes = if self.feature == 3 { reach } else { 0.0 };
        for at in 0..=self.detail.ceil() as i32 {
            let (scale, amplitude) = (self.lacunarity.powi(at), self.roughness.powi(at));
            let whole = f64::from(at) <= self.detail;
            let share = if whole { 1.0 } else { self.detail.fract() };
            let found = self.octave(scale * p);
            if self.feature == 3 {
                let nearer = mix(distance, distance.min(found.0 / scale), amplitude);
                distance = mix(distance, if whole { nearer } else { distance.min(nearer) }, share);
                amplitudes = mix(amplitudes, mix(amplitudes, reach / scale, amplitude), share);
            } else {
                distance += share * amplitude * found.0;
                color += share * amplitude * found.1;
                position = position.lerp(position.lerp(found.2 / scale, amplitude), share);
                amplitudes += share * amplitude;
            }
        }
        match (self.normalized, self.feature) {
            (false, _) => (distance, color, position),
            (true, 3) => (distance / amplitudes, color, position),
            (true, _) => (distance / (amplitudes * reach), color / amplitudes, position),
        }
    }
}
