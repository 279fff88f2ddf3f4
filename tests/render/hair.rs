//! Pictures of hair: fibers along either texture coordinate, and light that is kept.

use glam::Vec2Swizzles;
use lodestar::scene::{Bsdf, Scene};
use lodestar::settings::Sampler;
use support::estimate::Estimate;
use support::scenes::{settings, surface_mut};
use support::tier;

use crate::determinism::bits;
use crate::device::Device;

const SIZE: [u32; 2] = [24, 24];

/// A bent fiber under a lamp and a sky. Its scales rise steeply, so that its two ends differ.
fn fiber() -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    let points = "-1 -1.5 0 0.3\n-0.6 -0.6 0.2 0.3\n0.1 0 0 0.25\n0.2 0.6 -0.3 0.3\n0.9 1.4 0 0.3\n";
    std::fs::write(folder.path().join("curve.txt"), points).expect("written");
    let scene = r#"<scene version="3.0.0">
        <sensor type="perspective"><transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform></sensor>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
            <emitter type="area"><rgb name="radiance" value="20"/></emitter></shape>
        <emitter type="constant"><rgb name="radiance" value="0.3"/></emitter>
        <shape type="bsplinecurve"><string name="filename" value="curve.txt"/>
            <bsdf type="hair"><float name="scale_tilt" value="20"/><float name="longitudinal_roughness" value="0.15"/></bsdf></shape>
        </scene>"#;
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, scene).expect("written");
    Scene::load(path).expect("a scene")
}

/// The scene with its texture coordinates exchanged, and with fibers along u or v.
fn exchanged(scene: &Scene, is_along_u: bool) -> Scene {
    let mut scene = scene.clone();
    for primitive in &mut scene.primitives {
        primitive.uvs = primitive.uvs.map(|uv| uv.yx());
    }
    for material in &mut scene.materials {
        if let Bsdf::Hair { along_u, .. } = &mut surface_mut(material).bsdf {
            *along_u = is_along_u;
        }
    }
    scene
}

/// A fiber that runs along u has the picture of one that runs along v, where the coordinates are exchanged. The twin is one that does
/// not know it.
#[test]
fn fibers_run_along_either_coordinate() {
    let (device, scene) = (Device::new(), fiber());
    let render = |scene: &Scene| {
        let mut settings = settings(scene, SIZE, Sampler::Bsdf, 5);
        settings.nee = true;
        device.render(scene, &settings, 16)
    };
    let plain = render(&scene);
    assert_eq!(bits(&plain), bits(&render(&exchanged(&scene, true))));
    assert_ne!(bits(&plain), bits(&render(&exchanged(&scene, false))));
}

/// With a guide and without, with emitter sampling and without, the picture has one mean. The quick tier has one guide. The twin is a fiber that absorbs twice as much.
#[test]
fn guided_hair_has_the_same_mean() {
    let device = Device::new();
    let scene = fiber();
    let mut darker = scene.clone();
    let Bsdf::Hair { sigma_a, .. } = &mut surface_mut(&mut darker.materials[1]).bsdf else { panic!("hair") };
    sigma_a.value *= 2.0;
    let mean = |scene: &Scene, sampler, nee, seed| {
        let mut settings = settings(scene, SIZE, sampler, seed);
        settings.nee = nee;
        Estimate::of(&device.render(scene, &settings, 512)).gray()
    };
    let z = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0) / a.1.hypot(b.1);
    let plain = mean(&scene, Sampler::Bsdf, true, 1);
    let ways = [(Sampler::Product, true), (Sampler::RejectionMix, true), (Sampler::Bsdf, false)];
    for (seed, &(sampler, nee)) in (2..).zip(tier::some_of(&ways, 1)) {
        let other = mean(&scene, sampler, nee, seed);
        let twin = mean(&darker, sampler, nee, seed);
        println!("{sampler:?}, {nee}: {plain:.5?} {other:.5?}, the twin {twin:.5?}");
        assert!(z(plain, other).abs() < 4.5, "{sampler:?}, emitter sampling {nee}: {plain:?} is not {other:?}");
        assert!(!nee || z(plain, twin).abs() > 4.5, "the twin, {sampler:?}: {plain:?}, {twin:?}");
    }
}
