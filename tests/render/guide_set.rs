//! Rough conductors, dielectrics and principled surfaces under a guide, which must not change the picture's mean.

use glam::Vec3;
use lodestar::image::metrics::compare;
use lodestar::scene::Scene;
use lodestar::scene::bsdf::{Bsdf, Distribution, Microfacets};
use lodestar::scene::texture::Textured;
use lodestar::settings::{GuideSet, Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::mutated::DENSITIES;
use support::scenes::{ours, settings, surface_mut};
use support::tier;

use crate::device::Device;

const SIZE: [u32; 2] = [32, 32];
const SPP: u32 = 2048;

fn facets(alpha: f32) -> Microfacets {
    let alpha = Textured::constant(alpha);
    Microfacets { distribution: Distribution::Ggx, alpha_u: alpha, alpha_v: alpha }
}

fn metal(alpha: f32) -> Bsdf {
    let specular_reflectance = Textured::constant(Vec3::splat(0.9));
    Bsdf::RoughConductor { microfacets: facets(alpha), eta: Vec3::ZERO, k: Vec3::ZERO, specular_reflectance }
}

/// Cornell box with a left wall of rough metal and a right wall of rough glass, with nothing behind it.
fn rough_box() -> Scene {
    let mut scene = ours("cornell-box/scene.xml", &[]);
    let (microfacets, metal) = (facets(0.4), metal(0.4));
    let white = Textured::constant(Vec3::splat(0.9));
    let glass =
        Bsdf::RoughDielectric { microfacets, eta: 1.5, specular_reflectance: white, specular_transmittance: white };
    for material in &mut scene.materials {
        let (bsdf, two_sided) = match material.name.as_str() {
            "red" => (metal.clone(), true),
            "green" => (glass.clone(), false),
            _ => continue,
        };
        let surface = surface_mut(material);
        (surface.bsdf, surface.two_sided) = (bsdf, two_sided);
    }
    scene
}

fn render(device: &Device, scene: &Scene, seed: u32, change: impl FnOnce(&mut Settings)) -> Estimate {
    let mut settings = settings(scene, SIZE, Sampler::RejectionMix, seed);
    settings.guide_set = GuideSet::Authors;
    change(&mut settings);
    Estimate::of(&device.render(scene, &settings, SPP))
}

#[test]
fn guided_conductors_and_dielectrics_leave_the_picture_as_it_is() {
    if tier::is_skipped("the row `product, every part` of the proofs' claim pictures") {
        return;
    }
    let (device, scene) = (Device::new(), rough_box());
    let faulty = device.mutated(DENSITIES);
    let unguided = render(&device, &scene, 1, |s| s.sampler = Sampler::Bsdf);
    let compare = |name: &str, other: &Estimate| {
        let comparison = Comparison::new(&unguided, other, &[8, WHOLE]);
        println!("{name}: {comparison:?}");
        comparison.agrees()
    };
    for (seed, sampler, guide_set) in [
        (10, Sampler::RejectionMix, GuideSet::Authors),
        (30, Sampler::Product, GuideSet::All),
        (20, Sampler::Product, GuideSet::Authors),
        (40, Sampler::RejectionMix, GuideSet::All),
        (50, Sampler::Quadtree, GuideSet::All),
    ] {
        let name = |what: &str| format!("{sampler:?}, {guide_set:?}, {what}");
        let render = |device: &Device, seed: u32, change: fn(&mut Settings)| {
            render(device, &scene, seed, |s| {
                (s.sampler, s.learner, s.guide_set) = (sampler, sampler.default_learner(), guide_set);
                change(s);
            })
        };
        assert!(compare(&name("guided"), &render(&device, seed, |_| {})));
        assert!(compare(&name("emitters sampled"), &render(&device, seed + 1, |s| s.nee = true)));
        assert!(!compare(&name("density 5 % wrong"), &render(&faulty, seed + 2, |_| {})));
    }
}

/// Cornell box whose light comes from above a shade. All white surfaces are rough metal.
fn metal_box(alpha: f32) -> Scene {
    let mut scene = ours("cornell-box-hard/scene.xml", &[]);
    let white = scene.materials.iter_mut().find(|material| material.name == "white").expect("a material");
    let surface = surface_mut(white);
    (surface.bsdf, surface.two_sided) = (metal(alpha), true);
    scene
}

/// Guiding of all surfaces leaves less than 0.75 times the error of guiding diffuse lobes alone. Errors are those of
/// displayed pictures.
#[test]
fn metal_gains_from_a_guide() {
    if tier::is_skipped("the row `product, every part` of the proofs' claim pictures") {
        return;
    }
    let device = Device::new();
    for alpha in [0.3, 0.6] {
        let scene = metal_box(alpha);
        let render = |sampler, nee, guide_set, spp| {
            let settings = Settings { nee, guide_set, ..settings(&scene, SIZE, sampler, 5) };
            device.render(&scene, &settings, spp).image()
        };
        let truth = render(Sampler::Bsdf, true, GuideSet::Diffuse, 4096);
        let error = |guide_set| {
            let picture = render(Sampler::Product, false, guide_set, 128);
            compare(&picture, &truth).expect("the same size").mae_ldr
        };
        let (diffuse, all) = (error(GuideSet::Diffuse), error(GuideSet::All));
        println!("alpha {alpha}: {diffuse:.4} with diffuse lobes guided, {all:.4} with all surfaces");
        assert!(all < 0.75 * diffuse, "alpha {alpha}: {all} against {diffuse}");
    }
}
