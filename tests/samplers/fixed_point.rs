//! The fixed-point sums of `glsl/include/radiance_grid.glsl`

use bytemuck::{Pod, Zeroable};
use lodestar::kernels::{Variant, test};
use lodestar::layout::RadianceSum;
use lodestar::reference::radiance_grid::{FIXED_POINT_UNITS, fixed_point};

use crate::device::Device;
use crate::statistics::{Numbers, within_four_sigma};

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

/// A power of two, so that the device's division is exact.
const LIMIT: f32 = 16.0;
const BINS: usize = 256;

/// Has `groups` workgroups of `group` invocations add the targets up.
fn add(targets: &[TargetInput], limit: f32, group: u32, groups: u32) -> Vec<RadianceSum> {
    let device = Device::new();
    let variant = Variant { workgroup_size: group, ..Variant::default() };
    let inputs = device.uploaded("targets", targets);
    let sums = device.storage("sums", BINS * size_of::<RadianceSum>());
    let push = TestPush { target_count: targets.len() as u32, target_limit: limit };
    let kernel = device.kernel(&test::ADD_TARGET, &variant);
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

/// Targets over six decades, a few of them beyond the limit, with a hot bin that takes half of all.
fn wild_targets(count: usize) -> Vec<TargetInput> {
    let mut numbers = Numbers::new(5);
    let mut target = || TargetInput {
        index: if numbers.unit() < 0.5 { 7 } else { (numbers.unit() * BINS as f64) as u32 },
        target: 10_f64.powf(numbers.between(-4.5, 1.5)) as f32,
        u: numbers.unit() as f32,
    };
    (0..count).map(|_| target()).collect()
}

#[test]
fn sums_are_exact_in_any_order_and_carry() {
    let targets = wild_targets(1 << 17);
    let sums = add(&targets, LIMIT, 64, 2048);
    let twin = expected(&targets, LIMIT);
    for (bin, (sum, twin)) in sums.iter().zip(&twin).enumerate() {
        assert_eq!((units(sum), sum.target_count), *twin, "bin {bin}");
    }
    assert!(sums[7].high > 1000, "enough to carry often: {:?}", sums[7]);
    // Other shapes of dispatch, and all targets the other way round.
    assert_eq!(add(&targets, LIMIT, 32, 3), sums);
    let reversed: Vec<_> = targets.iter().rev().copied().collect();
    assert_eq!(add(&reversed, LIMIT, 128, 17), sums);
}

#[test]
fn a_lost_carry_would_be_noticed() {
    let targets = [TargetInput { index: 0, target: LIMIT, u: 0.5 }; 9];
    let sum = add(&targets, LIMIT, 64, 1)[0];
    assert_eq!((sum.low, sum.high, sum.target_count), (1 << 30, 2, 9));
    assert_ne!(u64::from(sum.low), expected(&targets, LIMIT)[0].0, "the lower word alone is not the sum");
}

#[test]
fn targets_saturate_at_the_limit() {
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
    let sums = add(&targets, LIMIT, 64, 1);
    for (sum, (target, expected)) in sums.iter().zip(cases) {
        assert_eq!(units(sum), expected, "{target}");
    }
}

#[test]
fn rounding_is_unbiased() {
    // 64 bins of targets of some share of a unit, far below what rounding to the nearest would see.
    let (count, limit) = (1 << 18, 3.0_f32);
    let share = |index: u32| f64::from(index % 64) / 64.0 + 1.0 / 128.0;
    let mut numbers = Numbers::new(9);
    let mut target = |i: u32| TargetInput {
        index: i % 64,
        target: (share(i) / FIXED_POINT_UNITS * f64::from(limit)) as f32,
        u: numbers.unit() as f32,
    };
    let targets: Vec<_> = (0..count).map(&mut target).collect();
    let sums = add(&targets, limit, 64, 64);
    let per_bin = f64::from(count / 64);
    let mut nearest_rejected = 0;
    for (index, sum) in (0..64).zip(&sums) {
        let p = share(index);
        let error = (p * (1.0 - p) / per_bin).sqrt();
        let mean = units(sum) as f64 / per_bin;
        assert!(within_four_sigma((mean, error), p), "bin {index}: {mean}, not {p}");
        nearest_rejected += u32::from(!within_four_sigma((p.round(), error), p));
    }
    assert!(nearest_rejected > 55, "rounding to the nearest: {nearest_rejected}");
}
