//! Scenes of this repository, and the shared scenes if they are unpacked.

use std::path::Path;

use glam::Vec3;
use lodestar::scene::{LoadOptions, PrimitiveShape, Scene, load};

fn ours(file: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(file);
    let scene = load(&path, &LoadOptions::default()).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(
        (scene.integrator.max_depth, scene.integrator.rr_depth, scene.sample_count),
        (Some(16), Some(8), Some(64))
    );
    scene
}

#[test]
fn cornell_boxes() {
    let plain = ours("cornell-box/scene.xml");
    let hard = ours("cornell-box-hard/scene.xml");
    assert_eq!((plain.name.as_str(), plain.film.width, plain.film.height), ("cornell-box", 512, 512));
    let is_light = |scene: &Scene| scene.primitives.iter().filter(|primitive| primitive.emitter.is_some()).count();
    assert_eq!((is_light(&plain), is_light(&hard)), (1, 1));
    assert_eq!(hard.primitives.len(), plain.primitives.len() + 6);
    let (low, high) = plain.bounds().unwrap();
    assert_eq!((low, high), (Vec3::ZERO, Vec3::new(556.0, 548.8, 559.2)));
}

#[test]
fn door_ajar() {
    let scene = ours("door-ajar/scene.xml");
    for shape in [PrimitiveShape::Triangle, PrimitiveShape::Parallelogram, PrimitiveShape::Disk, PrimitiveShape::Sphere]
    {
        assert!(scene.primitives.iter().any(|primitive| primitive.shape == shape), "{shape:?}");
    }
    assert_eq!((scene.film.width, scene.film.height), (640, 360));
}

#[test]
fn furnaces_face_inward_and_are_closed() {
    let sphere = ours("furnace/scene.xml");
    assert_eq!(sphere.primitives.len(), 1);
    assert!(sphere.primitives[0].flip_normal);
    let mesh = ours("furnace/mesh.xml");
    assert_eq!((mesh.name.as_str(), mesh.primitives.len()), ("mesh", 1280));
    for triangle in &mesh.primitives {
        let normal = triangle.edge_u.cross(triangle.edge_v) * if triangle.flip_normal { -1.0 } else { 1.0 };
        assert!(normal.dot(triangle.origin) < 0.0);
    }
    // The vector areas of a closed surface cancel.
    let sum: Vec3 = mesh.primitives.iter().map(|triangle| triangle.edge_u.cross(triangle.edge_v)).sum();
    assert!(sum.length() < 1e-5, "{sum}");
}

#[test]
fn shared_cornell_boxes() {
    let Some(folder) = std::env::var_os("LODESTAR_SCENES") else {
        return println!("skipped: LODESTAR_SCENES names no folder of unpacked scenes");
    };
    for (name, count) in [("cornell-box", 18), ("cornell-box-hard", 19)] {
        let path = Path::new(&folder).join(name).join("scene.xml");
        let scene =
            load(&path, &LoadOptions { defines: vec![("resx".into(), "256".into())], ..Default::default() }).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        assert_eq!((scene.name.as_str(), scene.primitives.len(), scene.emitters.len()), (name, count, 1));
        assert_eq!((scene.film.width, scene.film.height), (256, 1024));
    }
}

/// Shared scenes that are available load without a warning, except that an old file's picture is that of Mitsuba 3.
#[test]
fn shared_scenes() {
    let Ok(folder) = std::env::var("LODESTAR_SCENES") else {
        return println!("skipped: LODESTAR_SCENES names no folder of unpacked scenes");
    };
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path().join("scene.xml");
        if path.is_file() {
            let scene = load(&path, &LoadOptions::default()).unwrap();
            println!("{}: {} textures, {} images", scene.name, scene.textures.len(), scene.images.len());
            let others: Vec<_> = scene.warnings.iter().filter(|warning| !warning.contains("of Mitsuba 0.6")).collect();
            assert!(others.is_empty(), "{}: {others:?}", scene.name);
        }
    }
}
