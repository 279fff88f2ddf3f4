//! A context is timed only while a session with a profile uses it.

use lodestar::gpu::{Context, ContextOptions};
use lodestar::scene::Scene;
use lodestar::session::{OutputFiles, SceneInput, Start, Watch};
use lodestar::settings::Sampler;
use lodestar::{Options, Session};
use support::scenes::ours;

fn begin(scene: &Scene, options: &Options) -> Session {
    Session::start(Start::Anew(SceneInput::Memory(scene)), options, &Watch::silent()).expect("a session")
}

#[test]
fn a_profile_ends_with_its_session() {
    let folder = tempfile::tempdir().expect("a folder");
    let context = Context::new(&ContextOptions::default()).expect("a Vulkan device");
    let scene = ours("furnace/scene.xml", &[]);
    let plain = Options::new().context(&context).size(8, 8).samples(1).settings(|s| s.sampler = Sampler::Bsdf);
    let profile = Some(folder.path().join("profile.json"));
    let pictures = vec![folder.path().join("picture.exr")];
    let timed = plain.clone().files(OutputFiles { profile, pictures, ..OutputFiles::default() });
    let session = begin(&scene, &timed);
    begin(&scene, &plain).step(1).expect("a step");
    assert!(!context.take_timings().is_empty(), "the twin: while the session lives, its context is timed");
    drop(session);
    begin(&scene, &plain).step(1).expect("a step");
    assert!(context.take_timings().is_empty());
}
