//! Russian roulette by expected contribution: the rays that it saves are worth more than the noise that it adds.

use lodestar::image::metrics::compare;
use lodestar::scene::Scene;
use lodestar::settings::{Roulette, Sampler, Settings};
use support::scenes::{ours, settings};
use support::tier;

use crate::device::{Device, steps};

const SIZE: [u32; 2] = [64, 64];
const SPP: u32 = 32;
const PICTURES: u32 = 3;
const REFERENCE_SPP: u32 = 2048;

fn with(scene: &Scene, roulette: Roulette, seed: u32) -> Settings {
    Settings { nee: true, roulette: Some(roulette), ..settings(scene, SIZE, Sampler::Product, seed) }
}

/// Default roulette follows from sampler and depths: by contribution for `product`, if the scene asks for any.
#[test]
fn what_is_not_chosen_follows_from_sampler_and_depths() {
    let (device, scene) = (Device::new(), ours("cornell-box/scene.xml", &[]));
    let chosen = |sampler, rr_depth| {
        Settings { rr_depth, roulette: None, max_depth: 8, ..settings(&scene, SIZE, sampler, 1) }.roulette()
    };
    assert_eq!(
        [chosen(Sampler::Product, 7), chosen(Sampler::Product, 8)],
        [Roulette::Contribution, Roulette::Throughput]
    );
    assert_eq!(chosen(Sampler::RejectionMix, 1), Roulette::Throughput);
    let picture = |roulette| {
        let settings = Settings { roulette, ..settings(&scene, [24, 24], Sampler::Product, 1) };
        device.render(&scene, &settings, 16).radiance
    };
    let unchosen = picture(None);
    assert!(unchosen == picture(Some(Roulette::Contribution)) && unchosen != picture(Some(Roulette::Throughput)));
}

#[test]
fn by_contribution_a_ray_brings_more() {
    if tier::is_skipped("the proofs' claim roulette, which has no figure of the gain") {
        return;
    }
    let (device, scene) = (Device::new(), ours("cornell-box/scene.xml", &[]));
    let reference = device.render(&scene, &with(&scene, Roulette::Throughput, 1), REFERENCE_SPP).image();
    // Mean absolute error for a fixed number of rays, and rays per path.
    let measure = |roulette, first_seed: u32| {
        let (mut error, mut rays) = (0.0, 0.0);
        for seed in first_seed..first_seed + PICTURES {
            let settings = with(&scene, roulette, seed);
            let mut renderer = device.renderer(&scene, &settings);
            for counts in steps(&mut renderer, &settings, SPP) {
                rays += (counts.rays + counts.shadow_rays) as f64;
            }
            let picture = renderer.picture().expect("a picture").image();
            error += compare(&picture, &reference).expect("metrics").mae_ldr / f64::from(PICTURES);
        }
        let rays_per_path = rays / f64::from(SIZE[0] * SIZE[1] * SPP * PICTURES);
        (error * rays_per_path.sqrt(), rays_per_path)
    };
    let (by_throughput, long) = measure(Roulette::Throughput, 10);
    let (by_contribution, short) = measure(Roulette::Contribution, 20);
    let (again, _) = measure(Roulette::Throughput, 30);
    println!("{long:.2} and {short:.2} rays a path; {by_throughput:.4}, {again:.4} and {by_contribution:.4}");
    let pays = |error: f64| error < 0.95 * by_throughput;
    assert!(short < 0.75 * long && pays(by_contribution));
    assert!(!pays(again), "the twin: other seeds alone");
}
