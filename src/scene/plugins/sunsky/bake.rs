//! Image of the sky and the sun, for an environment map.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3, dvec3};
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use rayon::prelude::*;

use super::sun_radiance::{ELEVATIONS, RADIANCE};
use crate::scene::texture::{Image, Texels};

/// Sides of the image. The height is even, so that the horizon lies between two rows.
const WIDTH: usize = 2048;
const HEIGHT: usize = 1024;
/// Factor from the model's unit to Mitsuba's, which is the inverse of the integral of the luminous efficiency.
const UNIT: f64 = 1.0 / 106.750_259_399_414_06;
/// Angle in degrees that the sun fills, of which [`RADIANCE`] is the radiance.
pub(super) const DEFAULT_APERTURE: f64 = 0.5358;
/// Points along each side of a texel at which the sun's disk is tested.
const POINTS: usize = 16;

/// Sky and sun. `+z` is up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SunAndSky {
    /// Turbidity of the air, in [1, 10].
    pub turbidity: f64,
    /// Albedo of the ground, each channel in [0, 1].
    pub albedo: Vec3,
    /// Unit direction to the sun. A sun below the horizon leaves all dark.
    pub sun: DVec3,
    /// Angle that the sun fills, in radians. A larger sun is dimmer: its power stays.
    pub aperture: f64,
    pub sun_scale: f64,
    pub sky_scale: f64,
}

/// Latitude-longitude image with `+y` up, whose center lies towards `-z`. Directions `(x, y, z)` of the image are those `(x, -z, y)`
/// of the sky.
pub(super) fn bake(sky: &SunAndSky, name: String) -> Image {
    let mut texels = vec![[0.0, 0.0, 0.0, 1.0]; WIDTH * HEIGHT];
    if sky.sun.z > 0.0 {
        let state = sky.state();
        texels.par_chunks_mut(WIDTH).enumerate().for_each(|(row, texels)| {
            for (column, texel) in texels.iter_mut().enumerate() {
                let [r, g, b] = sky.sky_radiance(state.as_ref(), direction(column as f64, row as f64));
                *texel = [r, g, b, 1.0];
            }
        });
        sky.add_sun(&mut texels);
    }
    Image { name, width: WIDTH as u32, height: HEIGHT as u32, texels: Texels::Floats(texels) }
}

/// Direction of the sky at a place of the image, in texels from the center of the first one.
fn direction(column: f64, row: f64) -> DVec3 {
    let (sin_azimuth, cos_azimuth) = (TAU * (column + 0.5) / WIDTH as f64).sin_cos();
    let (sine, cosine) = (PI * row / (HEIGHT - 1) as f64).sin_cos();
    dvec3(sine * sin_azimuth, sine * cos_azimuth, cosine)
}

/// Solid angle over which a texel of a row counts, for linear interpolation between texels.
fn solid_angle(row: usize) -> f64 {
    let step = PI / (HEIGHT - 1) as f64;
    // Integral of the hat function around the row times the sine.
    let at_pole = 1.0 - step.sin() / step;
    let inside = 2.0 * (1.0 - step.cos()) / step * (row as f64 * step).sin();
    TAU / WIDTH as f64 * if row == 0 || row == HEIGHT - 1 { at_pole } else { inside }
}

impl SunAndSky {
    fn state(&self) -> Option<SkyState> {
        let elevation = self.sun.z.clamp(0.0, 1.0).asin().min(FRAC_PI_2) as f32;
        let turbidity = self.turbidity as f32;
        SkyState::new(&SkyParams { elevation, turbidity, albedo: self.albedo.into() }).ok()
    }

    fn sky_radiance(&self, state: Option<&SkyState>, direction: DVec3) -> [f32; 3] {
        let (Some(state), true) = (state, direction.z >= 0.0) else { return [0.0; 3] };
        let theta = direction.z.min(1.0).acos() as f32;
        let gamma = direction.angle_between(self.sun) as f32;
        [Channel::R, Channel::G, Channel::B]
            .map(|channel| (f64::from(state.radiance(theta, gamma, channel)) * UNIT * self.sky_scale).max(0.0) as f32)
    }

    /// Radiance of the sun's disk. Some of its colors lie outside of sRGB; a negative channel counts as 0.
    pub fn sun_radiance(&self) -> [f64; 3] {
        let below = (self.turbidity as usize).clamp(1, RADIANCE.len() - 1);
        let between = self.turbidity - below as f64;
        let (first, step) = ELEVATIONS;
        let last = RADIANCE[0].len() - 1;
        let at = ((self.sun.z.clamp(0.0, 1.0).asin().to_degrees() - first) / step).clamp(0.0, last as f64);
        let knot = (at as usize).min(last - 1);
        let mix = |a: f64, b: f64, share: f64| a + (b - a) * share;
        let area = |aperture: f64| (0.25 * aperture).sin().powi(2);
        let ratio = area(DEFAULT_APERTURE.to_radians()) / area(self.aperture);
        [0, 1, 2].map(|channel| {
            let of_turbidity = |row: usize| {
                let [low, high] = [knot, knot + 1].map(|knot| f64::from(RADIANCE[row][knot][channel]));
                mix(low, high, at - knot as f64)
            };
            (mix(of_turbidity(below - 1), of_turbidity(below), between) * ratio * self.sun_scale).max(0.0)
        })
    }

    /// Adds the part of the sun above the horizon. Its power is that of its disk, whatever the texels make of its shape.
    fn add_sun(&self, texels: &mut [[f32; 4]]) {
        let radiance = self.sun_radiance();
        if radiance == [0.0; 3] {
            return;
        }
        let covered = self.covered_texels();
        let sum: f64 = covered.iter().map(|&(row, _, share, _)| share * solid_angle(row)).sum();
        let disk = 2.0 * TAU * (0.25 * self.aperture).sin().powi(2);
        let scale = if sum > 0.0 { disk / sum } else { 0.0 };
        for (row, column, _, above) in covered {
            let texel = &mut texels[row * WIDTH + column];
            for channel in 0..3 {
                texel[channel] += (radiance[channel] * above * scale) as f32;
            }
        }
    }

    /// Texels that the sun covers in part: row, column, the share that is covered, and the share of it above the horizon.
    fn covered_texels(&self) -> Vec<(usize, usize, f64, f64)> {
        let half = 0.5 * self.aperture;
        let step = PI / (HEIGHT - 1) as f64;
        let center = self.sun.z.clamp(-1.0, 1.0).acos() / step;
        let reach = half / step + 1.0;
        let rows = (center - reach).max(0.0) as usize..=((center + reach) as usize).min(HEIGHT - 1);
        let cos_half = half.cos();
        let texel = |row: usize, column: usize| {
            let (mut share, mut above) = (0.0, 0.0);
            for i in 0..POINTS * POINTS {
                let offset = |index: usize| (index as f64 + 0.5) / POINTS as f64 - 0.5;
                let place = direction(column as f64 + offset(i % POINTS), row as f64 + offset(i / POINTS));
                if place.dot(self.sun) >= cos_half {
                    share += 1.0;
                    above += f64::from(u8::from(place.z >= 0.0));
                }
            }
            let all = (POINTS * POINTS) as f64;
            (row, column, share / all, above / all)
        };
        let near = |row: usize, column: usize| {
            let away = direction(column as f64, row as f64).angle_between(self.sun);
            away <= half + 2.0 * step
        };
        rows.into_par_iter()
            .flat_map_iter(|row| {
                (0..WIDTH).filter(move |&column| near(row, column)).map(move |column| texel(row, column))
            })
            .filter(|&(_, _, share, _)| share > 0.0)
            .collect()
    }
}
