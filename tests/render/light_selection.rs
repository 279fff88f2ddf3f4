//! Renders in which cells learn which lights reach them.

use glam::Vec3;
use lodestar::film::Picture;
use lodestar::scene::{Primitive, Scene};
use lodestar::settings::{LightSelection, Sampler, Settings};
use support::scenes::{ours, settings};

use crate::device::Device;

const SPP: u32 = 128;

/// The Cornell box with more lamps above its ceiling. They are as bright as the lamp within, and no light of theirs gets in.
fn box_with_lamps_outside(count: usize) -> Scene {
    let mut scene = ours("cornell-box/scene.xml", &[]);
    let lamp = *scene.primitives.iter().find(|primitive| primitive.emitter.is_some()).expect("a lamp");
    let top = scene.primitives.iter().map(|p| p.origin.y).fold(f32::MIN, f32::max);
    let outside = |i: usize| {
        let beside = 0.02 * i as f32 / count as f32;
        Primitive { origin: Vec3::new(lamp.origin.x + beside, top + 0.05 + beside, lamp.origin.z), ..lamp }
    };
    scene.primitives.extend((0..count).map(outside));
    scene
}

/// Median over the pixels of the squared difference of two pictures. Pixels at the edge of the lamp differ by far more.
fn difference(a: &Picture, b: &Picture) -> f64 {
    let squared = |(a, b): (&[f32; 3], &[f32; 3])| f64::from((Vec3::from(*a) - Vec3::from(*b)).length_squared());
    let mut squares: Vec<f64> = a.radiance.iter().zip(&b.radiance).map(squared).collect();
    squares.sort_unstable_by(f64::total_cmp);
    squares[squares.len() / 2]
}

/// Where fifteen of sixteen lamps are blocked, or more of them, cells learn to draw the one that is not.
#[test]
fn cells_learn_which_lamps_reach_them() {
    let device = Device::new();
    for count in [15, 39] {
        let scene = box_with_lamps_outside(count);
        let noise = |selection, seed| {
            let picture = |seed| {
                // Few cells, so that each has made many connections.
                let common = settings(&scene, [32, 32], Sampler::Product, seed);
                let settings =
                    Settings { nee: true, light_selection: Some(selection), max_depth: 2, grid: Some(2), ..common };
                device.render(&scene, &settings, SPP)
            };
            difference(&picture(seed), &picture(seed + 1))
        };
        let by_power = noise(LightSelection::Power, 1);
        let learned = noise(LightSelection::Learned, 1) / by_power;
        let again = noise(LightSelection::Power, 11) / by_power;
        println!("{count} lamps outside: variance {learned:.3} of that by power; by power again {again:.3}");
        assert!(learned < 0.3, "{count} lamps outside: {learned}");
        assert!(again > 0.5, "the measure is too coarse: {again}");
    }
}
