//! Sessions that take another scene while the guide stays.

use glam::Vec3;
use lodestar::renderer::learned_guide::LearnedGuide;
use lodestar::scene::{Bsdf, Camera, Environment, MaterialKind, Projection, Scene, Surface};
use lodestar::settings::{Sampler, Settings};
use lodestar::{Options, Session};
use support::scenes::ours;
use support::scenes_folder;

use crate::determinism::bits;
use crate::device::Device;

const SIZE: [u32; 2] = [36, 21];
/// Samples per pixel of a picture: two steps.
const SPP: u32 = 12;

fn scene() -> Scene {
    ours("cornell-box/scene.xml", &[])
}

fn options(device: &Device, sampler: Sampler) -> Options {
    Options::new().context(device.context()).size(SIZE[0], SIZE[1]).samples(SPP).seed(5).sampler(sampler)
}

/// Bits of the picture after `SPP` more samples.
fn next(session: &mut Session) -> Vec<u32> {
    session.step(SPP).expect("samples");
    bits(&session.picture().expect("a picture"))
}

/// Bits of a new session at the seed of another one, which begins with a guide, if there is one.
fn anew(options: &Options, scene: &Scene, seed: u32, guide: Option<&LearnedGuide>) -> (Session, Vec<u32>) {
    let mut session = Session::new(scene, &options.clone().seed(seed)).expect("a session");
    guide.iter().for_each(|guide| session.begin_with_guide(guide).expect("a guide that fits"));
    let bits = next(&mut session);
    (session, bits)
}

fn set_color(scene: &mut Scene) {
    let color = scene.materials.iter_mut().find_map(|material| match &mut material.kind {
        MaterialKind::Surface(surface) => match &mut surface.bsdf {
            Bsdf::Diffuse { reflectance } => Some(&mut reflectance.value),
            _ => None,
        },
        _ => None,
    });
    *color.expect("a diffuse material") = Vec3::new(0.1, 0.6, 0.3);
}

fn some_surface() -> Surface {
    Surface { material: 0, emitter: None }
}

type Change = fn(&mut Scene);

/// Changes of the scene, each of another kind. Some keep the geometry, and some need other kernels.
const CHANGES: [(&str, Change); 12] = [
    ("nothing", |_| {}),
    ("the camera", |s| s.camera.fov *= 0.8),
    ("a lens", |s| s.camera.projection = Projection::ThinLens { aperture_radius: 9.0, focus_distance: 900.0 }),
    ("a lamp", |s| s.emitters[0].radiance.value *= 3.0),
    ("a color", set_color),
    ("a place", |s| s.primitives.last_mut().expect("a shape").origin.x -= 20.0),
    ("a place beyond the box", |s| s.primitives.last_mut().expect("a shape").origin.y += 900.0),
    ("a shape more", |s| s.add_sphere([200.0, 300.0, 200.0], 60.0, some_surface())),
    ("a shape less", |s| s.primitives.truncate(s.primitives.len() - 1)),
    ("an environment", |s| s.environment = Some(Environment::constant(Vec3::splat(0.3)))),
    ("a lamp more", |s| s.add_facing_disk([270.0, 200.0, 270.0], 20.0, [5.0; 3])),
    ("the integrator", |s| s.integrator.max_depth = Some(4)),
];

/// After each kind of change, a session has the bits of a new one that begins with its guide, from memory or from a file. Changes follow each
/// other in one session.
#[test]
fn a_changed_scene_has_the_bits_of_a_new_session_with_the_guide() {
    let device = Device::validated();
    let folder = tempfile::tempdir().expect("a folder");
    for sampler in [Sampler::Product, Sampler::Bsdf] {
        let options = options(&device, sampler);
        let mut session = Session::new(&scene(), &options).expect("a session");
        next(&mut session);
        for (at, (name, change)) in (1..).zip(CHANGES) {
            let learns = sampler == Sampler::Product;
            let guide = learns.then(|| session.learned_guide().expect("a guide"));
            let file = folder.path().join(format!("{at}.guide"));
            if learns {
                session.write_guide(&file).expect("a file");
            }
            let mut changed = scene();
            change(&mut changed);
            session.set_scene(&changed).expect(name);
            let seed = 5 + if learns { at } else { 0 };
            assert_eq!((session.settings().seed, session.progress().samples), (seed, 0), "{name}");
            let found = next(&mut session);
            let (fresh, expected) = anew(&options, &changed, seed, guide.as_ref());
            assert!(found == expected, "{sampler:?}: {name}");
            assert_eq!(session.settings(), fresh.settings(), "{name}");
            let named = |session: &Session| session.attributes(&session.picture().expect("a picture"));
            let pairs = named(&session).into_iter().zip(named(&fresh));
            pairs.filter(|((name, _), _)| !name.contains("seconds")).for_each(|(a, b)| assert_eq!(a, b, "{name}"));
            if learns {
                let radiance = |session: &Session| session.learned_radiance().expect("radiance");
                assert!(radiance(&session) == radiance(&fresh), "{name}");
                let of_file = options.clone().seed(seed).guide(&file);
                let mut of_file = Session::new(&changed, &of_file).expect("a guide of a file");
                assert!(next(&mut of_file) == expected, "from a file: {name}");
            }
        }
    }
}

/// The film keeps the size that it has, and the view may change before and after the scene.
#[test]
fn scenes_and_views_change_in_any_order() {
    let device = Device::validated();
    let options = options(&device, Sampler::RejectionMix);
    let mut session = Session::new(&scene(), &options).expect("a session");
    next(&mut session);
    session.set_size(27, 34).expect("another size");
    let camera = Camera { fov: 30.0, ..scene().camera };
    next(&mut session);
    let guide = session.learned_guide().expect("a guide");
    let mut changed = scene();
    set_color(&mut changed);
    session.set_scene(&changed).expect("another scene");
    assert_eq!(*session.camera(), changed.camera);
    session.set_camera(&camera).expect("another camera");
    let found = next(&mut session);
    let (_, expected) = anew(&options.size(27, 34), &Scene { camera, ..changed }, 7, Some(&guide));
    assert!(found == expected);
}

/// Several devices change together.
#[test]
fn devices_that_share_a_film_change_together() {
    let mut changed = scene();
    changed.primitives.pop();
    let of = |device: &str| {
        let options = Options::new().device(device).size(SIZE[0], SIZE[1]).samples(SPP).seed(5);
        let mut session = Session::new(&scene(), &options).expect("a session");
        next(&mut session);
        session.set_scene(&changed).expect("another scene");
        next(&mut session)
    };
    assert!(of("0") == of("0,0"));
}

/// A scene or a render that is refused leaves the session as it was.
#[test]
fn a_refused_scene_changes_nothing() {
    let device = Device::validated();
    let options = options(&device, Sampler::Product);
    let mut session = Session::new(&scene(), &options).expect("a session");
    let mut other = Session::new(&scene(), &options).expect("a session");
    assert!(next(&mut session) == next(&mut other));
    let broken: [(Change, &str); 3] = [
        (|s| s.primitives[0].origin.x = f32::NAN, "finite"),
        (|s| s.primitives[0].material = 999, "material"),
        (|s| s.camera.fov = 200.0, "between 0 and 180"),
    ];
    for (change, words) in broken {
        let mut changed = scene();
        change(&mut changed);
        let refused = session.set_scene(&changed).expect_err("a refusal").to_string();
        assert!(refused.contains(words), "{refused}");
    }
    assert!(next(&mut session) == next(&mut other), "it goes on");

    let folder = tempfile::tempdir().expect("a folder");
    let kept = options.checkpoint(folder.path().join("a.ckpt"));
    let mut session = Session::open(scenes_folder().join("cornell-box/scene.xml"), &kept).expect("a session");
    let refused = session.set_scene(&scene()).expect_err("a refusal").to_string();
    assert!(refused.contains("keeps a checkpoint"), "{refused}");
}

/// A changed render writes no checkpoint, because nobody could read its scene again.
#[test]
fn a_changed_scene_has_no_checkpoint() {
    let device = Device::new();
    let mut session = Session::new(&scene(), &options(&device, Sampler::Product)).expect("a session");
    session.set_scene(&scene()).expect("another scene");
    let refused = session.write_checkpoint("never.ckpt").expect_err("a refusal").to_string();
    assert!(refused.contains("they were changed"), "{refused}");
}

/// Many changes leave no memory behind on the device.
#[test]
fn many_changes_leave_nothing_behind() {
    let device = Device::validated();
    let mut session = Session::new(&scene(), &options(&device, Sampler::Product)).expect("a session");
    let mut held = Vec::new();
    for round in 0..12 {
        let mut changed = scene();
        match round % 4 {
            0 => changed.emitters[0].radiance.value *= 2.0,
            1 => set_color(&mut changed),
            2 => changed.primitives.truncate(changed.primitives.len() - 1),
            _ => {}
        }
        session.set_scene(&changed).expect("another scene");
        session.step(1).expect("samples");
        held.push(device.context().allocated_bytes());
    }
    assert_eq!(held[..4], held[8..], "bytes on the device");
}

/// A step that was stopped ends with the change, and the guide has learned nothing of it.
#[test]
fn a_step_that_was_stopped_is_left_out() {
    let device = Device::validated();
    let options = options(&device, Sampler::Product).slice_milliseconds(1.0);
    let mut session = Session::new(&scene(), &options).expect("a session");
    next(&mut session);
    let before = session.learned_radiance().expect("radiance");
    let asked = std::cell::Cell::new(0);
    let stop = || asked.replace(asked.get() + 1) == 1;
    session.step_watched(8, &lodestar::session::Watch { stop: &stop, events: &|_| {} }).expect("a step");
    let mut changed = scene();
    changed.emitters[0].radiance.value *= 3.0;
    session.set_scene(&changed).expect("another scene");
    assert!(session.learned_radiance().expect("radiance") == before);
    assert_eq!(session.step(SPP).expect("samples").samples, SPP);
    let Settings { seed, .. } = *session.settings();
    assert_eq!(seed, 6);
}
