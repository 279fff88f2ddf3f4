//! Rough conductors, dielectrics and principled surfaces under a guide: the picture stays what it is.

use glam::Vec3;
use lodestar::scene::Scene;
use lodestar::scene::bsdf::{Bsdf, Distribution, Microfacets};
use lodestar::scene::texture::Textured;
use lodestar::settings::{GuideSet, Sampler, Settings};

use crate::device::Device;
use crate::estimate::{Comparison, Estimate, WHOLE};
use crate::scenes::{ours, settings, surface_mut};

const SIZE: [u32; 2] = [32, 32];
const SPP: u32 = 2048;

/// The Cornell box with a wall of rough metal on the left and one of rough glass, with nothing behind it, on the right.
fn rough_box() -> Scene {
    let mut scene = ours("cornell-box/scene.xml", &[]);
    let alpha = Textured::constant(0.4);
    let microfacets = Microfacets { distribution: Distribution::Ggx, alpha_u: alpha, alpha_v: alpha };
    let white = Textured::constant(Vec3::splat(0.9));
    let metal = Bsdf::RoughConductor { microfacets, eta: Vec3::ZERO, k: Vec3::ZERO, specular_reflectance: white };
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
    let (device, scene) = (Device::new(), rough_box());
    let unguided = render(&device, &scene, 1, |s| s.sampler = Sampler::Bsdf);
    let compare = |name: &str, other: &Estimate| {
        let comparison = Comparison::new(&unguided, other, &[8, WHOLE]);
        println!("{name}: {comparison:?}");
        comparison.agrees()
    };
    for (seed, sampler, guide_set) in [
        (10, Sampler::RejectionMix, GuideSet::Authors),
        (20, Sampler::Product, GuideSet::Authors),
        (30, Sampler::Product, GuideSet::All),
        (40, Sampler::RejectionMix, GuideSet::All),
    ] {
        let name = |what: &str| format!("{sampler:?}, {guide_set:?}, {what}");
        let render = |seed: u32, change: fn(&mut Settings)| {
            render(&device, &scene, seed, |s| {
                (s.sampler, s.guide_set) = (sampler, guide_set);
                change(s);
            })
        };
        assert!(compare(&name("guided"), &render(seed, |_| {})));
        assert!(compare(&name("emitters sampled"), &render(seed + 1, |s| s.nee = true)));
        assert!(!compare(&name("density 5 % wrong"), &render(seed + 2, |s| s.pdf_tamper = 1.05)));
    }
}
