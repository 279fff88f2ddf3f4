//! Renders whose camera and size change while the guide stays.

use std::cell::Cell;

use glam::{Mat4, Vec3};
use lodestar::renderer::Renderer;
use lodestar::renderer::learned_guide::LearnedGuide;
use lodestar::scene::{Camera, Projection, Scene};
use lodestar::settings::{Execution, Sampler, Settings};
use lodestar::{Options, Session};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::mutated::DENSITIES_FAR;
use support::scenes::{ours, settings, steady};

use crate::determinism::bits;
use crate::device::{Device, steps};

/// Size before the change. It is not a whole number of tiles.
const SIZE: [u32; 2] = [36, 21];
/// Size after the change.
const LATER_SIZE: [u32; 2] = [27, 34];
/// Samples per pixel of a picture: two steps.
const SPP: u32 = 12;

fn scene() -> Scene {
    ours("cornell-box/scene.xml", &[])
}

/// The camera moved to the side and turned.
fn moved(camera: Camera) -> Camera {
    let turn = Mat4::from_translation(Vec3::new(-60.0, 30.0, 40.0)) * Mat4::from_rotation_y(0.06);
    Camera { world_from_camera: camera.world_from_camera * turn, fov: camera.fov * 1.2, ..camera }
}

fn with_camera(scene: &Scene, camera: Camera) -> Scene {
    Scene { camera, ..scene.clone() }
}

/// Bits of the next picture of `SPP` samples per pixel.
fn next(renderer: &mut Renderer, settings: &Settings) -> Vec<u32> {
    steps(renderer, settings, SPP);
    bits(&renderer.picture().expect("a picture"))
}

/// Bits of a new render that begins with a guide, if there is one.
fn anew(device: &Device, scene: &Scene, settings: &Settings, guide: Option<&LearnedGuide>) -> Vec<u32> {
    let mut renderer = device.renderer(scene, settings);
    guide.iter().for_each(|guide| renderer.begin_with_guide(guide).expect("a guide that fits"));
    next(&mut renderer, settings)
}

/// A render after a change does what a new one with the guide does, and the same changes give the same bits. Without a guide to begin
/// with, the new render begins as any other.
#[test]
fn a_changed_view_has_the_bits_of_a_new_render_with_the_guide() {
    let device = Device::validated();
    let scene = scene();
    let camera = moved(scene.camera);
    let lens = Projection::ThinLens { aperture_radius: 9.0, focus_distance: 900.0 };
    for (sampler, execution, projection) in [
        (Sampler::Product, Execution::Wavefront, Projection::Perspective),
        (Sampler::RejectionMix, Execution::Megakernel, lens),
        (Sampler::Quadtree, Execution::Megakernel, Projection::Perspective),
        (Sampler::Bsdf, Execution::Megakernel, Projection::Perspective),
    ] {
        let camera = Camera { projection, ..camera };
        let later = with_camera(&scene, camera);
        let noise = (sampler == Sampler::Bsdf).then_some(0.2);
        let nee = sampler == Sampler::Product;
        let settings = Settings { execution, nee, noise, ..settings(&scene, SIZE, sampler, 5) };
        let learns = matches!(sampler, Sampler::Product | Sampler::RejectionMix);
        let guide_of = |renderer: &Renderer| learns.then(|| renderer.learned_guide().expect("a guide"));
        let seed_after = |changes: u32| settings.seed + if learns { changes } else { 0 };
        let sequence = || {
            let mut renderer = device.renderer(&scene, &settings);
            next(&mut renderer, &settings);
            let first_guide = guide_of(&renderer);
            renderer.change_view(&camera, LATER_SIZE).expect("another view");
            let first = next(&mut renderer, &settings);
            let second_guide = guide_of(&renderer);
            // Two changes without samples between them are one.
            renderer.change_view(&camera, SIZE).expect("another view");
            renderer.change_view(&scene.camera, SIZE).expect("the first view");
            (first, next(&mut renderer, &settings), [first_guide, second_guide])
        };
        let (first, second, guides) = sequence();
        let [width, height] = LATER_SIZE;
        let of_first = Settings { width, height, seed: seed_after(1), ..settings.clone() };
        let of_second = Settings { seed: seed_after(2), ..settings.clone() };
        assert!(first == anew(&device, &later, &of_first, guides[0].as_ref()), "{sampler:?}: the first change");
        // Kernels of a lens serve the pinhole that follows.
        assert!(second == anew(&device, &scene, &of_second, guides[1].as_ref()), "{sampler:?}: the second change");
        let again = sequence();
        assert!(again.0 == first && again.1 == second, "{sampler:?}: the same changes again");
    }
}

/// Bits of the picture of the next step, and what the guide has learned after it. Normalizers that were asked for earlier count from the
/// step after that one.
fn next_step(renderer: &mut Renderer, settings: &Settings) -> (Vec<u32>, Vec<f32>) {
    steps(renderer, settings, settings.spp_per_step);
    let guide = renderer.learned_guide().expect("a guide");
    (bits(&renderer.picture().expect("a picture")), guide.radiance().to_vec())
}

/// A view may change within a step. The guide has learned nothing of it.
#[test]
fn a_step_that_was_stopped_is_left_out() {
    let device = Device::validated();
    let scene = scene();
    let settings = Settings { slice_milliseconds: Some(1.0), ..settings(&scene, SIZE, Sampler::RejectionMix, 5) };
    let mut renderer = device.renderer(&scene, &settings);
    next(&mut renderer, &settings);
    let guide = renderer.learned_guide().expect("a guide");
    let camera = moved(scene.camera);
    let later = Settings { seed: 6, ..settings.clone() };
    let mut anew = device.renderer(&with_camera(&scene, camera), &later);
    anew.begin_with_guide(&guide).expect("a guide that fits");
    let expected = next_step(&mut anew, &later);

    let asked = Cell::new(0);
    let report = renderer.step(8, &|| asked.replace(asked.get() + 1) == 1).expect("a step");
    assert!(!report.complete && renderer.is_stopped());
    renderer.change_view(&camera, SIZE).expect("another view");
    assert!(renderer.learned_guide().expect("a guide").radiance() == guide.radiance());
    assert!(next_step(&mut renderer, &settings) == expected);
}

/// Pictures after a change agree with unguided ones. Densities that are 25 % off are found.
#[test]
fn a_changed_view_is_unbiased() {
    let scene = scene();
    let later = with_camera(&scene, moved(scene.camera));
    let with = |sampler, seed| steady(settings(&scene, [16, 16], sampler, seed));
    let device = Device::new();
    let unguided = Estimate::of(&device.render(&later, &with(Sampler::Bsdf, 1), 1024));
    let agrees = |device: &Device| {
        let settings = with(Sampler::RejectionMix, 2);
        let mut renderer = device.renderer(&scene, &settings);
        steps(&mut renderer, &settings, 64);
        renderer.change_view(&later.camera, [16, 16]).expect("another view");
        steps(&mut renderer, &settings, 512);
        let picture = Estimate::of(&renderer.picture().expect("a picture"));
        let comparison = Comparison::new(&unguided, &picture, &[8, WHOLE]);
        println!("{}: {comparison:?}", device.mutation());
        comparison.agrees()
    };
    assert!(agrees(&device) && !agrees(&device.mutated(DENSITIES_FAR)));
}

/// A session counts samples anew after a change, names the new camera and the new seed, and writes no checkpoint of them.
#[test]
fn a_session_takes_another_view() {
    let device = Device::validated();
    let scene = scene();
    let options = Options::new().context(device.context()).size(24, 16).samples(6).seed(9);
    let mut session = Session::new(&scene, &options).expect("a session");
    session.step(6).expect("samples");
    let named = |session: &Session, name: &str| {
        let attributes = session.attributes(&session.picture().expect("a picture"));
        attributes.into_iter().find(|(found, _)| found == name).expect(name).1
    };
    let before = named(&session, "scene_hash");
    let camera = moved(scene.camera);
    session.set_camera(&camera).expect("another camera");
    assert_eq!((*session.camera(), session.progress().samples, session.settings().seed), (camera, 0, 10));
    session.set_size(12, 10).expect("another size");
    let refused = session.write_checkpoint("never.ckpt").expect_err("a refusal").to_string();
    assert!(refused.contains("they were changed"), "{refused}");
    session.run(|_| std::ops::ControlFlow::Continue(())).expect("samples");
    let picture = session.picture().expect("a picture");
    assert_eq!((picture.width, picture.height, session.progress().samples), (12, 10, 6));
    assert_eq!(picture.view, lodestar::film::View::new(&camera, 12, 10));
    assert_eq!(named(&session, "sample_ranges"), "10:0..6");
    assert_ne!(named(&session, "scene_hash"), before);

    let refusal =
        |session: &mut Session, camera: Camera| session.set_camera(&camera).expect_err("a refusal").to_string();
    let scaled = Camera { world_from_camera: camera.world_from_camera * Mat4::from_scale(Vec3::splat(2.0)), ..camera };
    assert!(refusal(&mut session, scaled).contains("neither scale nor shear"));
    assert!(refusal(&mut session, Camera { fov: 180.0, ..camera }).contains("between 0 and 180"));
    assert!(refusal(&mut session, Camera { near_clip: f32::NAN, ..camera }).contains("not finite"));
    let lens = Projection::ThinLens { aperture_radius: -1.0, focus_distance: 1.0 };
    assert!(refusal(&mut session, Camera { projection: lens, ..camera }).contains("lens"));
    assert!(session.set_size(0, 4).is_err());
    // Whatever was refused has changed nothing.
    assert_eq!((*session.camera(), session.progress().samples), (camera, 6));
}
