//! Pictures by ray queries of the device against pictures by the traversal in compute. Without ray queries, the tests are skipped.

use lodestar::film::Picture;
use lodestar::scene::Scene;
use lodestar::settings::{Execution, Sampler, Settings, Traversal};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::scenes::{ours, settings, steady};

use crate::determinism::bits;
use crate::device::Device;

const SIZE: [u32; 2] = [52, 37];
const SPP: u32 = 8;

fn rendered(device: &Device, scene: &Scene, change: impl Fn(&mut Settings)) -> Picture {
    let mut settings = settings(scene, SIZE, Sampler::Bsdf, 11);
    change(&mut settings);
    device.render(scene, &settings, SPP)
}

/// Share of the pixels that have equal bits.
fn equal_share(a: &Picture, b: &Picture) -> f64 {
    let equal = a.radiance.iter().zip(&b.radiance).filter(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits));
    equal.count() as f64 / a.radiance.len() as f64
}

/// Nearly all pixels have the bits that the traversal in compute gives them. With another seed, far fewer have.
#[test]
fn pixels_by_ray_queries_have_the_bits_of_compute() {
    let device = Device::validated();
    if !device.has_ray_queries("pixels_by_ray_queries_have_the_bits_of_compute") {
        return;
    }
    for name in ["cornell-box", "door-ajar", "lights", "cornell-box-hard", "furnace"] {
        let scene = ours(&format!("{name}/scene.xml"), &[]);
        for nee in [false, true] {
            let render =
                |traversal, seed| rendered(&device, &scene, |s| (s.traversal, s.nee, s.seed) = (traversal, nee, seed));
            let compute = render(Traversal::Compute, 11);
            let share = equal_share(&compute, &render(Traversal::Query, 11));
            println!("{name}, emitters sampled {nee}: {share} of the pixels have equal bits");
            assert!(share > 0.99, "{name}: {share}");
            if name == "cornell-box" && nee {
                let other = equal_share(&compute, &render(Traversal::Query, 12));
                assert!(other < 0.6, "another seed: {other}");
            }
        }
    }
}

/// One kernel and waves give the same bits by ray queries, too, and so does a second render.
#[test]
fn waves_change_no_bit_of_ray_queries() {
    let device = Device::validated();
    if !device.has_ray_queries("waves_change_no_bit_of_ray_queries") {
        return;
    }
    for file in ["cornell-box/scene.xml", "door-ajar/scene.xml"] {
        let scene = ours(file, &[]);
        let render = |execution| {
            bits(&rendered(&device, &scene, |s| {
                (s.sampler, s.nee) = (Sampler::Product, true);
                (s.traversal, s.execution) = (Traversal::Query, execution);
            }))
        };
        let megakernel = render(Execution::Megakernel);
        assert!(megakernel == render(Execution::Wavefront), "{file}");
        assert!(megakernel == render(Execution::Megakernel), "{file}");
    }
}

/// Guided pictures by ray queries agree with plain ones by compute. A wrong albedo is found.
#[test]
fn pictures_by_ray_queries_estimate_the_same() {
    let device = Device::new();
    if !device.has_ray_queries("pictures_by_ray_queries_estimate_the_same") {
        return;
    }
    let estimate = |defines: &[(&str, &str)], sampler, traversal, seed, spp| {
        let scene = ours("cornell-box/scene.xml", defines);
        let settings = Settings { traversal, ..settings(&scene, [32, 32], sampler, seed) };
        Estimate::of(&device.render(&scene, &steady(settings), spp))
    };
    let plain = estimate(&[], Sampler::Bsdf, Traversal::Compute, 1, 8192);
    let compare = |defines: &[(&str, &str)]| {
        let guided = estimate(defines, Sampler::Product, Traversal::Query, 2, 2048);
        let comparison = Comparison::new(&plain, &guided, &[1, 8, WHOLE]);
        println!("{defines:?}: {comparison:?}");
        comparison.agrees()
    };
    assert!(compare(&[]));
    assert!(!compare(&[("white", "0.70325, 0.6887, 0.6596")]));
}
