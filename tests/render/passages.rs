//! Light that goes on through holes, thin sheets of glass and surfaces that refract it: closed forms, bits, and the bound of shadow rays.

use std::fmt::Write as _;

use glam::{DVec3, Vec3, dvec3};
use lodestar::film::Picture;
use lodestar::math::fresnel::fresnel_dielectric;
use lodestar::scene::bsdf::{Distribution, Microfacets, Principled};
use lodestar::scene::{Bsdf, LoadOptions, Scene, Textured, load};
use lodestar::settings::{Execution, Learner, Sampler, Settings, UNLIMITED_DEPTH};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::floor::{ALBEDO, floor_radiance};
use support::mutated::{
    FEW_SURFACES, NOT_WEAKENED, PASSED_TWICE, REFRACTED_TWICE, SHUT, STRAIGHT_SHADES, WRONG_DIRECTION, WRONG_VERTEX,
};
use support::panes::{Pane, covered, with_panes};
use support::scenes::{ours, settings, surface_mut};
use support::significance::{ALPHA, sidak, two_sided};
use support::tier;

use crate::device::{Device, steps};

const SPP: u32 = 512;
/// Number of the tests of the floor.
const TESTS: usize = 64;

/// Mean radiance of the floor below panes, with its standard error.
fn floor(device: &Device, light: &str, panes: &[Pane], change: impl FnOnce(&mut Settings)) -> (f64, f64) {
    let scene = covered(ours("lights/floor.xml", &[("light", light)]), panes);
    let mut settings = Settings { nee: true, ..settings(&scene, [16, 16], Sampler::Bsdf, 73) };
    change(&mut settings);
    let (mean, error) = Estimate::of(&device.render(&scene, &settings, SPP)).gray();
    println!("{light} {panes:?} {:?}, {}: {mean:.6} +- {error:.6}", settings.sampler, device.mutation());
    (mean, error)
}

/// Probability that a right picture deviates as much. The error includes single precision and a camera that sees more than one point.
fn surprise((mean, error): (f64, f64), expected: f64) -> f64 {
    sidak(two_sided((mean - expected) / error.hypot(2.0e-5 * expected)), TESTS)
}

fn assert_is(name: &str, rendered: (f64, f64), expected: f64) {
    assert!(surprise(rendered, expected) > ALPHA, "{name}: {rendered:?}, not {expected}");
    assert!(surprise(rendered, 1.05 * expected) < ALPHA, "{name}: the twin, {rendered:?}");
}

/// Panes whose share does not depend on the angle.
const HOLES: [&[Pane]; 3] =
    [&[Pane::Mask(0.4)], &[Pane::Mask(0.0)], &[Pane::Mask(0.25), Pane::Blend(0.3), Pane::Front(0.2)]];

/// Every light shines through holes, whether paths or connections find it.
#[test]
fn light_through_holes_is_its_closed_form() {
    let device = Device::new();
    let lights = ["directional", "rectangle", "point", "spot", "constant", "disk", "sphere", "envmap"];
    let lights = if tier::is_full() { &lights[..] } else { &lights[..3] };
    for light in lights {
        for panes in tier::some_of(&HOLES, 2) {
            let share: f64 = panes.iter().map(|pane| pane.share(1.0)).product();
            let expected = share * floor_radiance(light);
            assert_is(light, floor(&device, light, panes, |_| {}), expected);
            if tier::is_full() {
                assert_is(light, floor(&device, light, panes, |s| s.sampler = Sampler::Product), expected);
                assert_is(light, floor(&device, light, panes, |s| s.execution = Execution::Wavefront), expected);
            }
        }
    }
}

/// Cells learn which lights to draw, and paths keep their vertices: a path through a hole still knows the cell that it has left.
#[test]
fn light_through_holes_is_the_same_for_every_learner() {
    let device = Device::new();
    for &learner in tier::some_of(&[Learner::MonteCarlo, Learner::Sarsa, Learner::ExpectedSarsa], 1) {
        let rendered = floor(&device, "rectangle", HOLES[0], |s| (s.sampler, s.learner) = (Sampler::Product, learner));
        assert_is("rectangle", rendered, 0.6 * floor_radiance("rectangle"));
    }
}

/// Direction from the floor to a light that no ray can hit.
fn direction_to(light: &str) -> DVec3 {
    match light {
        "directional" => dvec3(1.0, 2.0, 0.5),
        _ => dvec3(-1.0, 2.0, 1.5),
    }
}

/// A lamp behind a thin sheet of glass, and behind glass and holes.
#[test]
fn light_through_glass_is_its_closed_form() {
    let device = Device::new();
    for light in ["directional", "point"] {
        for panes in [&[Pane::Glass][..], &[Pane::Glass, Pane::Mask(0.5), Pane::Glass]] {
            let cosine = direction_to(light).normalize().y;
            let share: f64 = panes.iter().map(|pane| pane.share(cosine)).product();
            assert_is(light, floor(&device, light, panes, |_| {}), share * floor_radiance(light));
        }
    }
}

/// A connection through a surface has an edge more, as a path has that goes through it.
#[test]
fn a_surface_that_is_crossed_counts_as_an_edge() {
    let device = Device::new();
    for light in ["directional", "rectangle"] {
        let depth = |max_depth| floor(&device, light, HOLES[1], |s| s.max_depth = max_depth);
        assert_eq!(depth(2).0, 0.0, "{light}");
        assert_is(light, depth(3), floor_radiance(light));
    }
}

#[test]
fn faults_of_passages_are_found_on_the_floor() {
    if tier::is_skipped("the proofs' claim emitters") {
        return;
    }
    let device = Device::new();
    for (fault, light) in
        [(SHUT, "directional"), (SHUT, "rectangle"), (PASSED_TWICE, "directional"), (WRONG_VERTEX, "rectangle")]
    {
        let rendered = floor(&device.mutated(fault), light, HOLES[0], |_| {});
        assert!(surprise(rendered, 0.6 * floor_radiance(light)) < ALPHA, "{fault}, {light}: {rendered:?}");
    }
}

/// Guided pictures of a box with panes below its lamp agree with unguided ones. With the densities of wrong vertices they do not.
#[test]
fn guided_pictures_with_panes_agree_with_unguided_ones() {
    let device = Device::new();
    let scene = with_panes(ours("cornell-box/scene.xml", &[]));
    let render = |device: &Device, sampler, nee, seed, spp| {
        let settings = Settings { nee, ..settings(&scene, [24, 24], sampler, seed) };
        Estimate::of(&device.render(&scene, &settings, spp))
    };
    let unguided = render(&device, Sampler::Bsdf, false, 1, if tier::is_full() { 16384 } else { 2048 });
    let spp = if tier::is_full() { 4096 } else { 512 };
    for (sampler, seed) in [(Sampler::Bsdf, 2), (Sampler::Product, 3), (Sampler::RejectionMix, 4)] {
        let compare =
            |device: &Device| Comparison::new(&unguided, &render(device, sampler, true, seed, spp), &[6, WHOLE]);
        let right = compare(&device);
        println!("{sampler:?}: {right:?}");
        assert!(right.agrees(), "{sampler:?}: {right:?}");
        if sampler == Sampler::Bsdf {
            let wrong = compare(&device.mutated(SHUT));
            println!("{sampler:?}, {SHUT}: {wrong:?}");
            assert!(!wrong.agrees(), "{SHUT}: {wrong:?}");
        }
    }
}

/// A slab of glass, from below.
const SLAB: [Pane; 2] = [Pane::Interface(1.5), Pane::Interface(1.0 / 1.5)];

/// Radiance of the floor below a slab under a constant sky, without light that the slab or the floor reflects.
fn below_slab() -> f64 {
    let count = 10_000;
    let integral: f64 = (0..count)
        .map(|at| (f64::from(at) + 0.5) / f64::from(count))
        .map(|cosine| cosine * (1.0 - fresnel_dielectric(cosine, 1.5).reflectance).powi(2))
        .sum();
    let sky = (1.0 + 0.75 + 0.5) / 3.0;
    ALBEDO * sky * 0.75 * 0.75 * 2.0 * integral / f64::from(count)
}

/// The sky through a slab. Four edges are too few for a path that the slab reflects.
#[test]
fn light_through_a_slab_is_its_closed_form() {
    let device = Device::new();
    let expected = below_slab();
    let render = |device: &Device, nee, sampler, execution| {
        floor(device, "constant", &SLAB, |s| {
            (s.max_depth, s.nee, s.sampler, s.execution) = (4, nee, sampler, execution);
        })
    };
    for (nee, sampler, execution) in [
        (false, Sampler::Bsdf, Execution::Megakernel),
        (true, Sampler::Bsdf, Execution::Megakernel),
        (true, Sampler::Product, Execution::Wavefront),
        (true, Sampler::RejectionMix, Execution::Megakernel),
    ] {
        assert_is("slab", render(&device, nee, sampler, execution), expected);
    }
    let wrong = render(&device.mutated(NOT_WEAKENED), true, Sampler::Bsdf, Execution::Megakernel);
    assert!(surprise(wrong, expected) < ALPHA, "{NOT_WEAKENED}: {wrong:?}");
}

/// Index of refraction of one surface between the floor and the light.
const INDEX: f32 = 1.5;

/// Mean radiance of the floor below one surface that refracts light, with its standard error.
fn below_surface(device: &Device, kind: &str, eta: f32, scales: bool, sampler: Sampler, nee: bool) -> (f64, f64) {
    let mut scene = covered(ours("lights/floor.xml", &[("light", "rectangle")]), &[Pane::Interface(eta)]);
    let pane = scene.materials.iter_mut().find(|material| material.name == "pane").expect("a pane");
    let surface = surface_mut(pane);
    surface.scales_radiance = scales;
    let [specular_reflectance, specular_transmittance] = [0.0, 0.75].map(|c| Textured::constant(Vec3::splat(c)));
    let alpha = Textured::constant(0.3);
    let microfacets = Microfacets { distribution: Distribution::Ggx, alpha_u: alpha, alpha_v: alpha };
    match kind {
        "rough" => {
            surface.bsdf = Bsdf::RoughDielectric { microfacets, eta, specular_reflectance, specular_transmittance };
        }
        "principled" => {
            let number = Textured::constant;
            surface.bsdf = Bsdf::Principled(Principled {
                base_color: Textured::constant(Vec3::splat(0.75)),
                roughness: number(0.5),
                anisotropic: number(0.0),
                metallic: number(0.0),
                spec_trans: number(1.0),
                eta,
                spec_tint: number(0.0),
                sheen: number(0.0),
                sheen_tint: number(0.0),
                flatness: number(0.0),
                clearcoat: number(0.0),
                clearcoat_gloss: number(0.0),
            });
        }
        _ => {}
    }
    // Three edges: from the camera to the floor, to the surface, to the light.
    let settings = Settings { nee, max_depth: 3, ..settings(&scene, [16, 16], sampler, 83) };
    let (mean, error) = Estimate::of(&device.render(&scene, &settings, SPP)).gray();
    println!("{kind}, {eta}, scales {scales}, {sampler:?}, emitter sampling {nee}: {mean:.6} +- {error:.6}");
    (mean, error)
}

/// Without scaling, the floor is brighter by the square of the index where light leaves the denser medium, and darker where it enters it,
/// whether a path or a connection crosses the surface.
#[test]
fn surfaces_that_scale_no_radiance_leave_out_the_square_of_the_index() {
    let device = Device::new();
    for &kind in tier::some_of(&["smooth", "rough", "principled"], 2) {
        let indices = [INDEX, 1.0 / INDEX];
        // The principled BSDF has an index above 1.
        for &eta in if kind == "principled" { &indices[..1] } else { &indices[..] } {
            let square = f64::from(eta).powi(2);
            for nee in [true, false] {
                let below = |scales, sampler| below_surface(&device, kind, eta, scales, sampler, nee);
                let (scaled, unscaled) = (below(true, Sampler::Bsdf), below(false, Sampler::Bsdf));
                // The same paths, because no roulette is played.
                let ratio = unscaled.0 / scaled.0;
                assert!((ratio / square - 1.0).abs() < 1.0e-4, "{kind}, {eta}, {nee}: {ratio}, not {square}");
                if nee {
                    let guided = below(false, Sampler::Product);
                    let z = (guided.0 - unscaled.0) / guided.1.hypot(unscaled.1);
                    assert!(sidak(two_sided(z), TESTS) > ALPHA, "{kind}, {eta}: {guided:?}, not {unscaled:?}");
                }
            }
        }
    }
}

/// Height of a shade above the floor, and where it begins. It covers half a plane.
const SHADE: [f64; 2] = [2.0, 1.0];

/// Radiance of a floor below one surface that refracts the light of the sky. A shade hides the sky where refracted rays meet it.
fn below_shade() -> f64 {
    let [height, begin] = SHADE;
    let index = f64::from(INDEX);
    let (cosines, angles) = (2000, 1000);
    let at = |k: i32, count: i32| (f64::from(k) + 0.5) / f64::from(count);
    let mut integral = 0.0;
    for cosine in (0..cosines).map(|k| at(k, cosines)) {
        let sine = (1.0 - cosine * cosine).sqrt();
        let behind = sine / index;
        let radius = 1.05 * sine / cosine + (height - 1.05) * behind / (1.0 - behind * behind).sqrt();
        let open = (0..angles).filter(|&k| radius * (std::f64::consts::TAU * at(k, angles)).cos() < begin).count();
        integral += cosine * (1.0 - fresnel_dielectric(cosine, index).reflectance) * open as f64 / f64::from(angles);
    }
    let sky = (1.0 + 0.75 + 0.5) / 3.0;
    ALBEDO * sky * 0.75 * 2.0 * integral / f64::from(cosines) / (index * index)
}

/// A ray to the sky that a surface refracts passes a shade that lies on its straight line, or meets one that lies beside it.
#[test]
fn shades_block_refracted_rays_where_these_meet_them() {
    let device = Device::new();
    let [height, begin] = SHADE.map(|value| value as f32);
    let render = |device: &Device, nee, sampler, execution| {
        let mut scene = ours("lights/floor.xml", &[("light", "constant")]);
        Pane::Mask(1.0).add(&mut scene, Vec3::new(begin + 150.0, height, 0.0), 150.0 * Vec3::X, 150.0 * Vec3::Z);
        // Seen along rays to the shade, the surface's middle lies behind the shade's, so that a traversal for any hit takes the shade first.
        Pane::Interface(INDEX).add(&mut scene, Vec3::new(2700.0, 1.05, 0.0), 3000.0 * Vec3::X, 3000.0 * Vec3::Z);
        // Three edges: from the camera to the floor, to the surface, to the sky.
        let settings = Settings { nee, execution, max_depth: 3, ..settings(&scene, [16, 16], sampler, 89) };
        let (mean, error) = Estimate::of(&device.render(&scene, &settings, 2 * SPP)).gray();
        println!("{sampler:?}, emitter sampling {nee}, {}: {mean:.6} +- {error:.6}", device.mutation());
        (mean, error)
    };
    let expected = below_shade();
    for (nee, sampler, execution) in [
        (false, Sampler::Bsdf, Execution::Megakernel),
        (true, Sampler::Bsdf, Execution::Megakernel),
        (true, Sampler::Product, Execution::Wavefront),
    ] {
        assert_is("shade", render(&device, nee, sampler, execution), expected);
    }
    let wrong = render(&device.mutated(STRAIGHT_SHADES), true, Sampler::Bsdf, Execution::Megakernel);
    assert!(surprise(wrong, expected) < ALPHA, "{STRAIGHT_SHADES}: {wrong:?}, not {expected}");
}

/// Mean radiance of the floor below a slab that bends light, with its standard error.
fn below_glass(device: &Device, light: &str, nee: bool, change: impl FnOnce(&mut Settings)) -> (f64, f64) {
    let mut scene = ours("lights/floor.xml", &[("light", light)]);
    let tilt = Vec3::new(0.0, 0.3, 0.0);
    for (pane, height) in SLAB.into_iter().zip([0.3, 0.6]) {
        pane.add(&mut scene, height * Vec3::Y, 0.4 * Vec3::X + tilt * height, 0.5 * Vec3::Z);
    }
    let mut settings = Settings { nee, ..settings(&scene, [16, 16], Sampler::Bsdf, 79) };
    change(&mut settings);
    let (mean, error) = Estimate::of(&device.render(&scene, &settings, 8 * SPP)).gray();
    println!("{light}, emitter sampling {nee}: {mean:.6} +- {error:.6}, {}", device.mutation());
    (mean, error)
}

/// Emitter sampling finds the light that paths find alone, behind a piece of glass whose sides are not parallel.
#[test]
fn refracted_lights_are_as_bright_as_paths_find_them() {
    let device = Device::new();
    let surprise = |(with, with_error): (f64, f64), (without, without_error): (f64, f64)| {
        sidak(two_sided((with - without) / with_error.hypot(without_error)), TESTS)
    };
    let lights = ["envmap", "rectangle", "sphere", "disk", "facing", "textured"];
    for light in tier::some_of(&lights, 2) {
        let alone = below_glass(&device, light, false, |_| {});
        for (sampler, execution) in [(Sampler::Bsdf, Execution::Megakernel), (Sampler::Product, Execution::Wavefront)] {
            let both = below_glass(&device, light, true, |s| (s.sampler, s.execution) = (sampler, execution));
            assert!(surprise(both, alone) > ALPHA && alone.0 > 0.0, "{light}, {sampler:?}: {both:?}, not {alone:?}");
        }
        let fault = match *light {
            "envmap" => WRONG_DIRECTION,
            "rectangle" => REFRACTED_TWICE,
            _ => continue,
        };
        let wrong = below_glass(&device.mutated(fault), light, true, |_| {});
        println!("{light}, {fault}: {:e}", surprise(wrong, alone));
        assert!(surprise(wrong, alone) < ALPHA, "{light}, {fault}: {wrong:?}, not {alone:?}");
    }
}

/// Sphere that emits, above a floor.
fn lamp(flip: bool, radius: f32, bsdf: &str) -> String {
    format!(
        "<shape type='sphere'><point name='center' x='0' y='2' z='0'/><float name='radius' value='{radius}'/>\
         <boolean name='flip_normals' value='{flip}'/>{bsdf}<emitter type='area'/></shape>"
    )
}

/// Emitter sampling finds the light that paths find alone. A lamp that emits inwards is seen through its own holes from outside, where
/// emitter sampling draws no point of it that emits. A shadow ray to a bulb close behind holes ends before the bulb, although it has
/// crossed surfaces (Mitsuba's `volpath` loses 6 % of this light).
#[test]
fn lamps_within_holes_are_as_bright_as_paths_find_them() {
    let device = Device::new();
    let mask = "<bsdf type='mask'><float name='opacity' value='0.5'/><bsdf type='diffuse'/></bsdf>";
    let around = |half: f32, bsdf: &str| {
        format!(
            "<shape type='cube'><transform name='to_world'><scale value='{half}'/><translate y='2'/></transform>{bsdf}</shape>"
        )
    };
    let bulb = lamp(false, 0.3, "") + &around(0.35, "<bsdf type='null'/>") + &around(0.4, mask);
    for lamps in [lamp(true, 0.7, "<bsdf type='null'/>"), lamp(true, 0.7, mask), bulb] {
        let text = format!(
            "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><float name='fov' value='10'/>\
             <transform name='to_world'><lookat origin='0,1,4' target='0,0,0' up='0,1,0'/></transform></sensor>\
             <shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/><scale value='4'/></transform></shape>\
             {lamps}</scene>"
        );
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.xml");
        std::fs::write(&path, &text).expect("a file");
        let scene = load(&path, &LoadOptions::default()).expect("a scene");
        let mean = |nee| {
            let settings = Settings { nee, ..settings(&scene, [16, 16], Sampler::Bsdf, 11) };
            Estimate::of(&device.render(&scene, &settings, 8 * SPP)).gray()
        };
        let ((with, with_error), (without, without_error)) = (mean(true), mean(false));
        println!(
            "{with:.5} +- {with_error:.5} with emitter sampling, {without:.5} +- {without_error:.5} without: {lamps}"
        );
        let z = (with - without) / with_error.hypot(without_error);
        assert!(sidak(two_sided(z), TESTS) > ALPHA && without > 1.0e-3, "{with}, not {without}: {lamps}");
        let twin = (0.94 * with - without) / with_error.hypot(without_error);
        assert!(sidak(two_sided(twin), TESTS) < ALPHA, "the twin of {lamps}");
    }
}

/// A stack of surfaces that let all light pass, above a floor under a sun.
fn stack(count: usize) -> String {
    let mut text = String::from(
        "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><float name='fov' value='0.1'/>\
         <transform name='to_world'><lookat origin='0,0.4,1' target='0,0,0' up='0,1,0'/></transform>\
         <film type='hdrfilm'><integer name='width' value='2'/><integer name='height' value='2'/><rfilter type='box'/></film></sensor>\
         <emitter type='directional'><vector name='direction' x='0' y='-1' z='0'/><rgb name='irradiance' value='1'/></emitter>\
         <shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/></transform>\
         <bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>",
    );
    for layer in 0..count {
        let height = 0.5 + 0.05 * layer as f32;
        let _ = write!(
            text,
            "<shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/><translate y='{height}'/>\
             </transform><bsdf type='null'/></shape>"
        );
    }
    text + "</scene>"
}

/// A shadow ray through more surfaces than a kernel follows is counted. The mutation follows 16, because 1024 would take lavapipe more
/// turns of loops than it has.
#[test]
fn a_shadow_ray_through_too_many_surfaces_is_counted() {
    let device = Device::new();
    let short = device.mutated(FEW_SURFACES);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    for (device, count, is_cut) in [(&device, 60, false), (&short, 16, false), (&short, 17, true)] {
        std::fs::write(&path, stack(count)).expect("a file");
        let scene = load(&path, &LoadOptions::default()).expect("a scene");
        let settings = Settings { nee: true, samples_per_dispatch: 1, ..settings(&scene, [2, 2], Sampler::Bsdf, 3) };
        assert_eq!(settings.max_depth, UNLIMITED_DEPTH);
        let mut renderer = device.renderer(&scene, &settings);
        let cut: u64 = steps(&mut renderer, &settings, 2).iter().map(|counts| counts.cut_shadow_rays).sum();
        assert_eq!(cut, if is_cut { 8 } else { 0 }, "{count} surfaces");
        let mean = Estimate::of(&renderer.picture().expect("a picture")).gray().0;
        let expected = if is_cut { 0.0 } else { 0.5 / std::f64::consts::PI };
        assert!((mean - expected).abs() < 1.0e-4, "{count} surfaces: {mean}, not {expected}");
    }
}

/// Opacity of the pixels, and their mean radiance.
fn seen(scene: &Scene, text: &str) -> (f64, f64) {
    let device = Device::new();
    let settings = Settings { nee: true, ..settings(scene, [16, 16], Sampler::Bsdf, 5) };
    let picture: Picture = device.render(scene, &settings, 256);
    let alpha = (0..256).map(|at| f64::from(picture.alpha(at))).sum::<f64>() / 256.0;
    let mean = Estimate::of(&picture).gray().0;
    println!("{text}: alpha {alpha:.4}, radiance {mean:.4}");
    (alpha, mean)
}

/// Where emitters are hidden, what stands behind holes and thin glass is hidden, too, and such surfaces are as opaque as they
/// scatter light: the environment, and a lamp behind it. Without a hidden environment, the picture shows it.
#[test]
fn hidden_emitters_are_hidden_behind_holes_and_glass() {
    // Reflectance of glass of index 1.5 at normal incidence, with all reflections within the sheet.
    let glass = 2.0 * 0.04 / 1.04;
    let lamp = "<shape type='rectangle'><transform name='to_world'><translate z='-1'/></transform><emitter type='area'/></shape>";
    let mask = "<bsdf type='mask'><float name='opacity' value='0.25'/><bsdf type='diffuse'>\
                <rgb name='reflectance' value='0'/></bsdf></bsdf>";
    let sheet =
        "<bsdf type='thindielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf>";
    for (bsdf, alpha, radiance) in [("<bsdf type='null'/>", 0.0, 0.0), (mask, 0.25, 0.0), (sheet, glass, glass)] {
        for (hides, behind) in [(true, ""), (true, lamp), (false, lamp)] {
            let text = format!(
                "<scene version='3.0.0'><integrator type='path'><boolean name='hide_emitters' value='{hides}'/></integrator>\
                 <sensor type='perspective'><float name='fov' value='2'/><transform name='to_world'>\
                 <lookat origin='0,0,4' target='0,0,0' up='0,1,0'/></transform></sensor>\
                 <shape type='rectangle'>{bsdf}</shape>{behind}<emitter type='constant'/></scene>"
            );
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("scene.xml");
            std::fs::write(&path, &text).expect("a file");
            let scene = load(&path, &LoadOptions::default()).expect("a scene");
            let (a, l) = seen(&scene, &text);
            let (alpha, radiance) = if hides { (alpha, radiance) } else { (1.0, 1.0 - alpha + radiance) };
            let error = |share: f64| 5.0 * (share * (1.0 - share) / 65536.0).sqrt() + 1.0e-3;
            assert!((a - alpha).abs() < error(alpha), "alpha {a}, not {alpha}: {text}");
            assert!((l - radiance).abs() < error(radiance), "radiance {l}, not {radiance}: {text}");
        }
    }
}

/// Holes in a leaf do not hide what is behind from the layers: the first surface is the first one that scatters.
#[test]
fn layers_show_what_is_behind_holes() {
    let mut scene = Scene::new(lodestar::scene::Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], 2.0), 16, 16);
    let wall = scene.add_diffuse([0.8, 0.2, 0.4]);
    scene.add_parallelogram([0.0, 0.0, -1.0], Vec3::X, Vec3::Y, wall);
    Pane::Mask(0.0).add(&mut scene, Vec3::ZERO, Vec3::X, Vec3::Y);
    let settings = settings(&scene, [16, 16], Sampler::Bsdf, 5);
    let device = Device::new();
    for execution in [Execution::Megakernel, Execution::Wavefront] {
        let picture = device.render(&scene, &Settings { execution, ..settings.clone() }, 4);
        assert!(
            picture.albedo().iter().all(|albedo| (Vec3::from(*albedo) - Vec3::new(0.8, 0.2, 0.4)).length() < 1.0e-5)
        );
        assert!(picture.depth().iter().all(|depth| (depth - 5.0).abs() < 0.01));
    }
}
