//! Claim: sums of fixed-point targets (`glsl/include/guide/grid/radiance_grid.glsl`) are exact in any order, also
//! beyond the first word. The rounding of targets is unbiased.

use bytemuck::{Pod, Zeroable};
use lodestar::generated::kernels::{Variant, test as kernels};
use lodestar::generated::layout::RadianceSum;
use support::device::Device;
use support::significance::two_sided;
use support::statistics::Numbers;
use support::twins::radiance_grid::{FIXED_POINT_UNITS, fixed_point};

use crate::evidence::{Evidence, Record};
use crate::rows::Scope;
use crate::subject::Subject;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct TargetInput {
    index: u32,
    target: f32,
    u: f32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct TestPush {
    target_count: u32,
    target_limit: f32,
}

/// Largest target: a power of two, so that the device's division is exact.
const LIMIT: f32 = 16.0;
const BINS: usize = 256;

pub fn test(subject: &Subject, _: Scope, evidence: &mut Evidence) {
    check_sums(subject, evidence);
    check_saturation(subject, evidence);
    check_rounding(subject, evidence);
}

/// Adds up the targets with `groups` workgroups of `group` invocations.
fn add(subject: &Subject, targets: &[TargetInput], limit: f32, group: u32, groups: u32) -> Vec<RadianceSum> {
    let device = Device::new();
    let variant = Variant { workgroup_size: group, ..Variant::default() };
    let inputs = device.uploaded("targets", targets);
    let sums = device.storage("sums", BINS * size_of::<RadianceSum>());
    let push = TestPush { target_count: targets.len() as u32, target_limit: limit };
    let kernel = device.kernel(&subject.kernel(&kernels::ADD_TARGET), &variant);
    device.dispatch(&kernel, &[&inputs, &sums], bytemuck::bytes_of(&push), groups);
    sums.read(0, BINS).expect("read")
}

fn units(sum: &RadianceSum) -> u64 {
    u64::from(sum.high) << 32 | u64::from(sum.low)
}

fn expected(targets: &[TargetInput], limit: f32) -> Vec<(u64, u32)> {
    let mut sums = vec![(0, 0); BINS];
    for t in targets {
        let sum = &mut sums[t.index as usize];
        *sum = (sum.0 + fixed_point(f64::from(t.target), f64::from(limit), f64::from(t.u)), sum.1 + 1);
    }
    sums
}

/// Targets over six decades. A few exceed the limit, and half of them go to one bin.
fn wild_targets(count: usize, seed: u32) -> Vec<TargetInput> {
    let mut numbers = Numbers::new(seed);
    let mut target = || TargetInput {
        index: if numbers.unit() < 0.5 { 7 } else { (numbers.unit() * BINS as f64) as u32 },
        target: 10_f64.powf(numbers.between(-4.5, 1.5)) as f32,
        u: numbers.unit() as f32,
    };
    (0..count).map(|_| target()).collect()
}

/// Sums do not depend on the shape of the dispatch or on the order of the targets.
fn check_sums(subject: &Subject, evidence: &mut Evidence) {
    let targets = wild_targets(1 << 17, subject.seed + 5);
    let reversed: Vec<_> = targets.iter().rev().copied().collect();
    let twin = expected(&targets, LIMIT);
    for (name, targets, group, groups) in [
        ("many workgroups", &targets, 64, 2048),
        ("a few", &targets, 32, 3),
        ("the other way round", &reversed, 128, 17),
    ] {
        let sums = add(subject, targets, LIMIT, group, groups);
        let wrong = sums.iter().zip(&twin).filter(|(sum, twin)| (units(sum), sum.target_count) != **twin).count();
        evidence.hold(format!("sums, {name}"), wrong == 0, || format!("{wrong} of {BINS} sums are not the exact ones"));
    }
    // The twin must fail: a sum without its second word.
    assert!(twin[7].0 >> 32 > 1000, "enough to carry often: {:?}", twin[7]);
}

fn check_saturation(subject: &Subject, evidence: &mut Evidence) {
    let cases = [
        (LIMIT, 1 << 30),
        (2.0 * LIMIT, 1 << 30),
        (f32::MAX, 1 << 30),
        (f32::INFINITY, 1 << 30),
        (0.0, 0),
        (-1.0, 0),
        (f32::MIN, 0),
        (LIMIT / 2.0, 1 << 29),
    ];
    let targets: Vec<_> = (0..).zip(cases).map(|(index, (target, _))| TargetInput { index, target, u: 0.0 }).collect();
    for (sum, (target, expected)) in add(subject, &targets, LIMIT, 64, 1).iter().zip(cases) {
        evidence.hold(format!("saturation, {target}"), units(sum) == expected, || {
            format!("{}, not {expected}", units(sum))
        });
    }
}

/// 64 bins of targets that are a fraction of a unit. Rounding to the nearest unit would make all of them 0.
fn check_rounding(subject: &Subject, evidence: &mut Evidence) {
    let (count, limit) = (1 << 18, 3.0_f32);
    let share = |index: u32| f64::from(index % 64) / 64.0 + 1.0 / 128.0;
    let mut numbers = Numbers::new(subject.seed + 9);
    let target = |i: u32| TargetInput {
        index: i % 64,
        target: (share(i) / FIXED_POINT_UNITS * f64::from(limit)) as f32,
        u: numbers.unit() as f32,
    };
    let targets: Vec<_> = (0..count).map(target).collect();
    let sums = add(subject, &targets, limit, 64, 64);
    let per_bin = f64::from(count / 64);
    for (index, sum) in (0..64).zip(&sums) {
        let p = share(index);
        let error = (p * (1.0 - p) / per_bin).sqrt();
        let z = (units(sum) as f64 / per_bin - p) / error;
        evidence.test(format!("rounding, {p:.4} units, seed {}", subject.seed + 9), two_sided(z), || Record::Nothing);
    }
}
