//! Phase functions of `glsl/include/bsdf/phase.glsl`: samples against the closed forms of their distributions, and densities.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3, dvec3};
use lodestar::generated::kernels::{BSDF_PHASE, PHASE_RAYLEIGH, Variant};
use support::scattering_cases::DeviceBsdf;
use support::statistics::{Numbers, chi_square, sidak};

use crate::scattering::{Bench, ScatteringInput, d3};

const SAMPLES: usize = 1 << 19;
const SIGNIFICANCE: f64 = 0.01;
const HEIGHTS: usize = 48;
const SECTORS: usize = 6;

/// Mixture of two lobes with a mean cosine each; `None` is Rayleigh's.
#[derive(Debug, Clone, Copy)]
struct Phase {
    lobes: [Option<f64>; 2],
    second_lobe: f64,
}

const fn one(lobe: Option<f64>) -> Phase {
    Phase { lobes: [lobe; 2], second_lobe: 0.0 }
}

const PHASES: [Phase; 8] = [
    one(Some(0.0)),
    one(Some(0.3)),
    one(Some(-0.6)),
    one(Some(0.95)),
    one(Some(-0.99)),
    one(None),
    Phase { lobes: [Some(0.8), Some(-0.4)], second_lobe: 0.3 },
    Phase { lobes: [Some(1.0e-4), None], second_lobe: 0.8 },
];

impl Phase {
    fn mix(&self, of_lobe: impl Fn(Option<f64>) -> f64) -> f64 {
        (1.0 - self.second_lobe) * of_lobe(self.lobes[0]) + self.second_lobe * of_lobe(self.lobes[1])
    }

    /// Density per steradian at the cosine `c` to the direction straight on.
    fn pdf(&self, c: f64) -> f64 {
        self.mix(|lobe| match lobe {
            None => 3.0 / (16.0 * PI) * (1.0 + c * c),
            Some(g) => (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * c).powf(1.5)),
        })
    }

    /// Probability of a cosine below `c`.
    fn below(&self, c: f64) -> f64 {
        self.mix(|lobe| match lobe {
            None => (c * c * c + 3.0 * c + 4.0) / 8.0,
            Some(0.0) => 0.5 * (1.0 + c),
            Some(g) => (1.0 - g * g) / (2.0 * g) * ((1.0 + g * g - 2.0 * g * c).powf(-0.5) - 1.0 / (1.0 + g)),
        })
    }

    fn device(&self) -> DeviceBsdf {
        let mut device = DeviceBsdf::new(BSDF_PHASE, [DVec3::ONE; 3]);
        for (scalar, lobe) in device.scalars.iter_mut().zip(self.lobes) {
            *scalar = lobe.map_or(PHASE_RAYLEIGH, |g| g as f32);
        }
        device.scalars[2] = self.second_lobe as f32;
        device
    }

    /// Cosines between which samples are equally probable.
    fn edge(&self, share: f64) -> f64 {
        let (mut low, mut high) = (-1.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.below(middle) < share { low = middle } else { high = middle }
        }
        low
    }
}

#[test]
fn samples_and_densities_are_the_closed_forms() {
    let bench = Bench::with(&Variant { material_kinds: 1 << BSDF_PHASE, ..Variant::default() });
    let mut numbers = Numbers::new(77);
    let level = sidak(SIGNIFICANCE, PHASES.len());
    for phase in PHASES {
        // The direction is one of single precision.
        let wo = numbers.unit_vector().as_vec3().normalize();
        let mut input = || ScatteringInput {
            bsdf: phase.device(),
            wo: wo.into(),
            wi: numbers.unit_vector().as_vec3().into(),
            u: [(); 3].map(|()| numbers.unit() as f32),
        };
        let inputs: Vec<_> = (0..SAMPLES).map(|_| input()).collect();
        let outputs = bench.map(&inputs);
        let straight = -wo.as_dvec3();
        let turn = DQuat::from_rotation_arc(straight, DVec3::Z);
        let edges: Vec<f64> = (1..HEIGHTS).map(|i| phase.edge(i as f64 / HEIGHTS as f64)).collect();
        let mut observed = vec![0_u64; HEIGHTS * SECTORS];
        for (input, output) in inputs.iter().zip(&outputs) {
            let w = turn * d3(output.wi);
            let height = edges.partition_point(|&edge| edge < w.z);
            let sector = (w.y.atan2(w.x) / TAU).rem_euclid(1.0) * SECTORS as f64;
            observed[height * SECTORS + (sector as usize).min(SECTORS - 1)] += 1;
            let expected = phase.pdf(d3(input.wi).dot(straight));
            assert!((f64::from(output.pdf) / expected - 1.0).abs() < 2.0e-3, "{phase:?}: {output:?}, not {expected}");
            assert!((output.value[0] - output.pdf).abs() <= 1.0e-6 * output.pdf);
            assert!((output.weight[0] - 1.0).abs() < 1.0e-5, "{phase:?}: {output:?}");
        }
        let share = SAMPLES as f64 / observed.len() as f64;
        let p = chi_square(&observed, &vec![share; observed.len()]);
        let tampered: Vec<f64> =
            (0..observed.len()).map(|i| share * if i % SECTORS < SECTORS / 2 { 1.03 } else { 0.97 }).collect();
        let twin = chi_square(&observed, &tampered);
        println!("{phase:?}: p = {p:.3}, twin {twin:.1e}");
        assert!(p > level, "{phase:?}: {p}");
        assert!(twin < level, "the twin of {phase:?}: {twin}");
    }
}

/// A narrow lobe keeps its mean cosine, which is the parameter.
#[test]
fn mean_cosines_are_the_parameters() {
    let bench = Bench::with(&Variant { material_kinds: 1 << BSDF_PHASE, ..Variant::default() });
    for g in [-0.999, -0.5, 0.0, 0.5, 0.999] {
        let mut numbers = Numbers::new(78);
        let phase = one(Some(g));
        let mut input = || ScatteringInput {
            bsdf: phase.device(),
            wo: [0.0, 0.6, -0.8],
            wi: [0.0, 0.0, 1.0],
            u: [(); 3].map(|()| numbers.unit() as f32),
        };
        let inputs: Vec<_> = (0..SAMPLES).map(|_| input()).collect();
        let straight = dvec3(0.0, -0.6, 0.8);
        let mean = bench.map(&inputs).iter().map(|o| d3(o.wi).dot(straight)).sum::<f64>() / SAMPLES as f64;
        assert!((mean - g).abs() < 5.0 / (SAMPLES as f64).sqrt(), "{g}: {mean}");
    }
}
