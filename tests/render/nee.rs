//! Emitter sampling: against closed forms, against pictures without it, and in cases where it must change nothing.

use glam::Vec3;
use lodestar::film::Picture;
use lodestar::scene::bsdf::Distribution;
use lodestar::scene::{Bsdf, Material, Textured};
use lodestar::settings::{Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::floor::{DELTA, SPREAD, floor_radiance};
use support::mutated::{BLIND_TO_GUIDE, COUNTED_TWICE, DENSITIES};
use support::rows::samplers;
use support::scenes::{SAMPLERS, ours, settings, surface_mut, with_albedo_scaled};
use support::significance::{ALPHA, sidak, two_sided};
use support::tier;

use crate::device::{Device, steps};

/// Mean radiance of the rendered floor, with its standard error.
fn render_floor(device: &Device, light: &str, change: impl FnOnce(&mut Settings)) -> (f64, f64) {
    let scene = ours("lights/floor.xml", &[("light", light)]);
    let mut settings = settings(&scene, [16, 16], Sampler::Bsdf, 71);
    change(&mut settings);
    let (mean, error) = Estimate::of(&device.render(&scene, &settings, 512)).gray();
    let (Settings { sampler, nee, .. }, mutation) = (settings, device.mutation());
    println!("{light} {sampler:?}, emitters sampled: {nee}, {mutation}: {mean:.6} +- {error:.6}");
    (mean, error)
}

/// Deviation from `expected` in standard errors. The error includes single precision and a camera that sees more than
/// one point.
fn deviation((mean, error): (f64, f64), expected: f64) -> f64 {
    (mean - expected) / error.hypot(1.0e-5 * expected)
}

/// Every kind of light has the closed form's radiance. The quick tier has the plain path tracer with emitter sampling;
/// the proofs' claim emitters has the guided samplers.
#[test]
fn direct_light_is_its_closed_form() {
    let device = Device::new();
    let lights = SPREAD.map(|light| (light, false)).into_iter().chain(SPREAD.map(|light| (light, true)));
    let lights = lights.chain(DELTA.map(|light| (light, true)));
    let cases: Vec<_> = lights.flat_map(|(light, nee)| SAMPLERS.map(|sampler| (light, nee, sampler))).collect();
    let is_quick = |&&(_, nee, sampler): &&(_, bool, Sampler)| nee && sampler == Sampler::Bsdf;
    for &(light, nee, sampler) in cases.iter().filter(|case| tier::is_full() || is_quick(case)) {
        let rendered = render_floor(&device, light, |s| (s.nee, s.sampler) = (nee, sampler));
        let z = deviation(rendered, floor_radiance(light));
        assert!(sidak(two_sided(z), cases.len()) > ALPHA, "{light} {sampler:?}, emitters sampled: {nee}: z = {z}");
        let z = deviation(rendered, 1.02 * floor_radiance(light));
        assert!(!nee || sidak(two_sided(z), cases.len()) < ALPHA, "{light} {sampler:?}: the twin's z = {z}");
    }
}

#[test]
fn faults_of_the_weights_are_found_on_the_floor() {
    if tier::is_skipped("the faults of the proofs' claim emitters") {
        return;
    }
    let device = Device::new();
    let is_found = |light, sampler, fault| {
        let change = |s: &mut Settings| (s.nee, s.sampler) = (true, sampler);
        let z = deviation(render_floor(&device.mutated(fault), light, change), floor_radiance(light));
        sidak(two_sided(z), 32) < ALPHA
    };
    for light in SPREAD {
        for sampler in SAMPLERS {
            assert!(is_found(light, sampler, COUNTED_TWICE), "{light} {sampler:?} counts light twice");
        }
    }
    for light in ["constant", "rectangle"] {
        assert!(is_found(light, Sampler::RejectionMix, BLIND_TO_GUIDE), "{light}: weights blind to the guide");
    }
    // Only the largest light is tested: scattered rays bring so little of smaller lights that their density hardly
    // matters.
    for sampler in SAMPLERS {
        assert!(is_found("constant", sampler, DENSITIES), "{sampler:?}: density 5 % off");
    }
}

/// A scene, its samples per pixel without and with emitter sampling, and the scales of the comparison.
struct Case {
    file: &'static str,
    light: &'static str,
    size: [u32; 2],
    spp: [u32; 2],
    sides: &'static [usize],
    /// Whether floor, ball and box are glossy.
    glossy: bool,
}

const BLOCKS: &[usize] = &[4, 8, WHOLE];
const CORNELL_BOX: Case =
    Case { file: "cornell-box/scene.xml", light: "", size: [32, 32], spp: [4096, 1024], sides: BLOCKS, glossy: false };
const AREA_LIGHTS: Case =
    Case { file: "lights/scene.xml", light: "area", size: [32, 24], spp: [4096, 512], sides: BLOCKS, glossy: false };
const GLOSSY: Case =
    Case { file: "lights/scene.xml", light: "area", size: [32, 24], spp: [4096, 1024], sides: BLOCKS, glossy: true };
const SKY: Case =
    Case { file: "lights/scene.xml", light: "envmap", size: [32, 24], spp: [4096, 512], sides: BLOCKS, glossy: false };

/// Adds a rough layer to a diffuse material that is not black.
fn polish(material: &mut Material) {
    if let Bsdf::Diffuse { reflectance } = surface_mut(material).bsdf
        && reflectance.value.max_element() > 0.0
    {
        surface_mut(material).bsdf = Bsdf::RoughPlastic {
            distribution: Distribution::Ggx,
            alpha: 0.15,
            eta: 1.5,
            diffuse_reflectance: reflectance,
            specular_reflectance: Textured::constant(Vec3::ONE),
            nonlinear: false,
        };
    }
}

impl Case {
    /// Picture of the scene with all albedos multiplied.
    fn render(&self, device: &Device, albedo: f32, change: impl FnOnce(&mut Settings)) -> Estimate {
        let defines = [("light", self.light)];
        let scene = ours(self.file, if self.light.is_empty() { &[] } else { &defines });
        let mut scene = with_albedo_scaled(&scene, albedo);
        if self.glossy {
            scene.materials.iter_mut().for_each(polish);
        }
        let mut settings = settings(&scene, self.size, Sampler::Bsdf, 0);
        change(&mut settings);
        Estimate::of(&device.render(&scene, &settings, self.spp[usize::from(settings.nee)]))
    }

    fn agrees(&self, name: &str, a: &Estimate, b: &Estimate) -> bool {
        let comparison = Comparison::new(a, b, self.sides);
        println!("{} {} {name}: {comparison:?}", self.file, self.light);
        comparison.agrees()
    }

    /// Fails unless emitter sampling leaves the picture as it is. The twins must be found: light counted twice, and
    /// albedos 3 % off. The quick tier has the guided sampler only, and the twins of the sky only.
    fn check(&self) {
        let device = Device::new();
        let twice = device.mutated(COUNTED_TWICE);
        let off = self.render(&device, 1.0, |s| s.seed = 1);
        for &(sampler, seed) in tier::some_of(&[(Sampler::RejectionMix, 5), (Sampler::Bsdf, 2)], 1) {
            let on = |device: &Device, albedo, seed| {
                self.render(device, albedo, |s| (s.nee, s.sampler, s.seed) = (true, sampler, seed))
            };
            let name = format!("{sampler:?}");
            assert!(self.agrees(&name, &on(&device, 1.0, seed), &off), "{name}");
            if !tier::is_full() && self.light != SKY.light {
                continue;
            }
            assert!(!self.agrees(&format!("{name}, twice"), &on(&twice, 1.0, seed + 1), &off), "{name}");
            assert!(!self.agrees(&format!("{name}, albedo"), &on(&device, 0.97, seed + 2), &off), "{name}");
        }
    }
}

#[test]
fn emitter_sampling_leaves_the_cornell_box_as_it_is() {
    if !tier::is_skipped("the proofs' claim pictures, and emitter_sampling_leaves_the_sky_as_it_is") {
        CORNELL_BOX.check();
    }
}

#[test]
fn emitter_sampling_leaves_all_shapes_of_light_as_they_are() {
    AREA_LIGHTS.check();
}

#[test]
fn emitter_sampling_leaves_glossy_surfaces_as_they_are() {
    GLOSSY.check();
}

#[test]
fn emitter_sampling_leaves_the_sky_as_it_is() {
    SKY.check();
}

/// Emitter sampling does not change the furnace's brightness. The furnace emits 0.5 and reflects half, and light comes
/// from everywhere. The quick tier has one sampler and one furnace.
#[test]
fn the_furnace_is_as_bright_with_emitter_sampling() {
    let device = Device::new();
    let twice = device.mutated(COUNTED_TWICE);
    for file in tier::some_of(&["furnace/mesh.xml", "furnace/scene.xml"], 1) {
        for &sampler in tier::some_of(&samplers(), 1) {
            let z = |device: &Device| {
                let scene = ours(file, &[]);
                let settings = Settings { nee: true, ..settings(&scene, [32, 32], sampler, 5) };
                let rendered = Estimate::of(&device.render(&scene, &settings, 64)).gray();
                let z = deviation(rendered, 1.0 - 1.0 / f64::from(1 << 16));
                println!("{file} {sampler:?}, {}: {rendered:?}, z = {z:.2}", device.mutation());
                sidak(two_sided(z), 2 * samplers().len())
            };
            assert!(z(&device) > ALPHA && z(&twice) < ALPHA, "{file} {sampler:?}");
        }
    }
}

fn bits(picture: &Picture) -> Vec<u32> {
    picture.radiance.iter().chain(&picture.variance).flatten().map(|value| value.to_bits()).collect()
}

#[test]
fn the_same_seed_gives_the_same_bits_with_emitter_sampling() {
    let device = Device::new();
    let scene = ours("lights/scene.xml", &[("light", "area")]);
    for &sampler in tier::some_of(&samplers(), 2) {
        let render = |change: &dyn Fn(&mut Settings)| {
            let mut settings = Settings { nee: true, ..settings(&scene, [50, 37], sampler, 11) };
            change(&mut settings);
            bits(&device.render(&scene, &settings, 20))
        };
        let first = render(&|_| {});
        assert!(first == render(&|_| {}), "{sampler:?}: a second time");
        assert!(first == render(&|s| s.slice_milliseconds = Some(1.0)), "{sampler:?}: slices of 1 ms");
        assert!(first == render(&|s| s.storage_reads = true), "{sampler:?}: storage buffers");
        assert!(first != render(&|s| s.seed = 12), "{sampler:?}: another seed");
    }
}

/// The guide learns only the light that emitter sampling does not find at a vertex.
#[test]
fn the_guide_learns_what_emitter_sampling_leaves() {
    let device = Device::new();
    let scene = ours("furnace/scene.xml", &[]);
    let mean = |nee| {
        let settings = Settings {
            nee,
            decay: 0.0,
            grid: Some(4),
            directions: 8,
            ..settings(&scene, [64, 64], Sampler::RejectionMix, 9)
        };
        let mut renderer = device.renderer(&scene, &settings);
        steps(&mut renderer, &settings, 12 * 8);
        let bins = renderer.radiance().expect("a table");
        let learned: Vec<f64> = bins.into_iter().map(f64::from).filter(|&l| l > 0.2).collect();
        learned.iter().sum::<f64>() / learned.len() as f64
    };
    // The incident radiance is 1. Emission is 0.5 of it, and about half of the emission is left to the guide.
    let (all, left) = (mean(false), mean(true));
    println!("learned {all:.3} without emitter sampling, {left:.3} with it");
    assert!((all - 1.0).abs() < 0.02 && (0.6..0.9).contains(&left), "{all} {left}");
}

#[test]
fn shadow_rays_are_counted() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    for sampler in SAMPLERS {
        let counts = |nee| {
            let settings = Settings { nee, ..settings(&scene, [64, 64], sampler, 1) };
            steps(&mut device.renderer(&scene, &settings), &settings, 16)
        };
        assert!(counts(false).iter().all(|c| c.shadow_rays == 0));
        assert!(counts(true).iter().all(|c| c.shadow_rays > c.rays / 4 && c.shadow_rays <= c.rays), "{sampler:?}");
    }
}

#[test]
fn what_no_ray_can_hit_needs_emitter_sampling() {
    for light in DELTA {
        let scene = ours("lights/scene.xml", &[("light", light)]);
        let settings = settings(&scene, [8, 8], Sampler::Bsdf, 1);
        let sentence = settings.check_lighting(&scene).expect_err("an error").to_string();
        assert!(sentence.contains(&format!("`{light}`")) && sentence.contains("--nee on"), "{sentence}");
        assert!(Settings { nee: true, ..settings }.check_lighting(&scene).is_ok());
    }
}

/// A scene without light is black with all settings.
#[test]
fn without_lights_nothing_is_sampled() {
    let device = Device::new();
    let mut scene = ours("lights/scene.xml", &[("light", "constant")]);
    scene.environment = None;
    let settings = Settings { nee: true, ..settings(&scene, [8, 8], Sampler::Bsdf, 1) };
    assert!(device.render(&scene, &settings, 8).radiance.iter().flatten().all(|&l| l == 0.0));
}
