//! `cloud`: a density that pbrt computes from noise, sampled on a grid.

use glam::{DVec3, UVec3};
use rayon::prelude::*;

use crate::math::perlin::noise;

/// Voxels along each axis. pbrt's finest noise has 78 cells along a unit at its default frequency.
pub(super) const SIDE: u32 = 128;

/// Shape of a cloud.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cloud {
    pub density: f64,
    pub wispiness: f64,
    pub frequency: f64,
}

impl Cloud {
    /// Densities at the centers of voxels of a box, x fastest, then y, then z.
    pub fn values(self, low: DVec3, high: DVec3) -> Vec<f32> {
        let side = f64::from(SIDE);
        let layer = |z: u32| {
            (0..SIDE * SIDE).map(move |at| {
                let voxel = UVec3::new(at % SIDE, at / SIDE, z).as_dvec3();
                self.at(low + (voxel + 0.5) / side * (high - low)) as f32
            })
        };
        (0..SIDE).into_par_iter().flat_map_iter(layer).collect()
    }

    /// Density at a point, in [0, 1].
    fn at(self, point: DVec3) -> f64 {
        let mut place = self.frequency * point;
        if self.wispiness > 0.0 {
            let (mut strength, mut scale) = (0.05 * self.wispiness, 10.0);
            for _ in 0..2 {
                place += strength * gradient(scale * place);
                strength *= 0.5;
                scale *= 1.99;
            }
        }
        let octaves = (0..5).map(|octave| 0.5_f64.powi(octave + 1) * noise(1.99_f64.powi(octave) * place));
        let above = (1.0 - point.y) * 4.5 * self.density * octaves.sum::<f64>();
        (above.clamp(0.0, 1.0) + 2.0 * (0.5 - point.y).max(0.0)).clamp(0.0, 1.0)
    }
}

/// Gradient of noise by differences, as pbrt takes it.
fn gradient(point: DVec3) -> DVec3 {
    const STEP: f64 = 0.01;
    let here = noise(point);
    DVec3::from_array(DVec3::AXES.map(|axis| (noise(point + STEP * axis) - here) / STEP))
}
