//! A render begins again with fewer samples per dispatch where the driver ends a loop of a kernel early.

use std::ops::ControlFlow;
use std::sync::Mutex;

use lodestar::scene::Scene;
use lodestar::session::{Event, SceneInput, Start, Watch};
use lodestar::settings::{Sampler, Settings};
use lodestar::{Options, Session};
use support::scenes::{ours, settings};

use crate::device::{Device, steps};

/// Paths of 256 edges in a closed mesh that reflects everything. 64 of them need all iterations that lavapipe 22.3 grants
/// one invocation; other drivers end no loop.
fn demanding() -> Scene {
    let mut scene = ours("furnace/mesh.xml", &[("albedo", "1"), ("emission", "0.00390625")]);
    scene.environment = None;
    scene
}

fn options(samples_per_dispatch: u32) -> Options {
    let change = move |settings: &mut Settings| {
        (settings.samples_per_dispatch, settings.rr_depth) = (samples_per_dispatch, u32::MAX);
        (settings.sampler, settings.nee) = (Sampler::Bsdf, false);
    };
    Options::new().size(16, 8).max_depth(256).samples(64).settings(change)
}

/// Renders to the end. Returns the session and its warnings.
fn render(scene: &Scene, options: &Options) -> (Session, Vec<String>) {
    let warnings = Mutex::new(Vec::new());
    let events = |event: Event<'_>| {
        if let Event::Warning(sentence) = event {
            warnings.lock().unwrap().push(sentence.to_owned());
        }
    };
    let watch = Watch { events: &events, ..Watch::silent() };
    let mut session = Session::start(Start::Anew(SceneInput::Memory(scene)), options, &watch).expect("a session");
    session.run_watched(&watch, |_| ControlFlow::Continue(())).expect("a render");
    (session, warnings.into_inner().unwrap())
}

#[test]
fn a_render_whose_loops_are_cut_begins_again() {
    let scene = demanding();
    let (session, warnings) = render(&scene, &options(64));
    println!("{warnings:#?}");
    let halvings = 64_u32.ilog2() - session.settings().samples_per_dispatch.ilog2();
    let said = warnings.iter().filter(|sentence| sentence.contains("begins again with")).count();
    assert_eq!(said, halvings as usize);
    // Each path brings the same, so nothing is missing.
    let picture = session.picture().expect("a picture");
    assert!(picture.radiance.iter().flatten().all(|l| (l - 1.0).abs() < 1.0e-3));
    let (begun_so, warnings) = render(&scene, &options(session.settings().samples_per_dispatch));
    assert!(warnings.iter().all(|sentence| !sentence.contains("begins again")), "{warnings:#?}");
    assert_eq!(begun_so.picture().expect("a picture").radiance, picture.radiance);
}

/// A renderer that begins again leaves nothing of what it did before: neither light nor what the guide has learned.
#[test]
fn a_renderer_that_begins_again_forgets() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    for sampler in [Sampler::Bsdf, Sampler::Product, Sampler::Quadtree] {
        let of = |samples_per_dispatch| Settings { samples_per_dispatch, ..settings(&scene, [24, 16], sampler, 3) };
        let mut again = device.renderer(&scene, &of(8));
        steps(&mut again, &of(8), 32);
        let before = again.picture().expect("a picture").radiance;
        again.begin_again(3, None).expect("a beginning");
        steps(&mut again, &of(3), 32);
        let mut fresh = device.renderer(&scene, &of(3));
        steps(&mut fresh, &of(3), 32);
        let pictures = [&again, &fresh].map(|renderer| renderer.picture().expect("a picture").radiance);
        assert_eq!(pictures[0], pictures[1], "{sampler:?}");
        assert_ne!(pictures[0], before, "{sampler:?}");
        // From a state, too: the rest has the bits of a renderer with that setting that goes on from the state.
        let state = fresh.state().expect("a state");
        steps(&mut fresh, &of(3), 40);
        steps(&mut again, &of(3), 48);
        again.begin_again(3, Some(&state)).expect("a beginning");
        steps(&mut again, &of(3), 40);
        let pictures = [&again, &fresh].map(|renderer| renderer.picture().expect("a picture").radiance);
        assert_eq!(pictures[0], pictures[1], "{sampler:?} from a state");
    }
}
