//! Files of pbrt-v3.

use glam::{DVec3, Vec3};
use lodestar::image::{Image, exr::encode_rgb};
use lodestar::scene::texture::Texels;
use lodestar::scene::{Bsdf, DeltaKind, EnvironmentKind, ReconstructionFilter, Scene};

use super::{assert_close, bsdf, load_in, load_text, surface, world};
use crate::Folder;

/// Scene of one sphere with a material, and the one warning about its age.
fn with(material: &str) -> Scene {
    let scene = world(&format!("{material} Shape \"sphere\"")).unwrap();
    let warnings = scene.warnings.iter().filter(|warning| warning.contains("the scene is one of pbrt-v3"));
    assert_eq!(warnings.count(), 1, "{material}: {:?}", scene.warnings);
    let unknown = scene.warnings.iter().find(|warning| warning.contains("is not known"));
    assert_eq!(unknown, None, "{material}");
    scene
}

#[test]
fn materials_become_those_of_v4() {
    let Bsdf::Diffuse { reflectance } =
        *bsdf(&with("Material \"matte\" \"rgb Kd\" [ 0.1 0.2 0.3 ] \"float sigma\" 20"))
    else {
        panic!("diffuse")
    };
    assert_eq!(reflectance.value, Vec3::new(0.1, 0.2, 0.3));
    let plastic =
        with("Material \"plastic\" \"color Kd\" [ 0.5 0.5 0.5 ] \"rgb Ks\" [ 0.2 0.2 0.2 ] \"float roughness\" 0.1");
    // v3's remapping: 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 with x = ln 0.1.
    assert!(
        matches!(bsdf(&plastic), Bsdf::RoughPlastic { alpha, .. } if (alpha - 0.46176).abs() < 1e-4),
        "{:?}",
        bsdf(&plastic)
    );
    let dull = with("Material \"uber\" \"rgb Ks\" [ 0 0 0 ]");
    assert!(matches!(bsdf(&dull), Bsdf::Diffuse { reflectance } if reflectance.value == Vec3::splat(0.25)));
    let glass = with("Material \"glass\" \"float index\" 1.3 \"rgb Kr\" [ 1 1 1 ]");
    assert!(matches!(bsdf(&glass), Bsdf::Dielectric { eta, .. } if (eta - 1.3).abs() < 1e-6));
    let skin = with("Material \"kdsubsurface\" \"rgb mfp\" [ 2 2 2 ] \"rgb Kr\" [ 1 1 1 ] \"float roughness\" 0.1");
    assert!(
        matches!(bsdf(&skin), Bsdf::RoughDielectric { microfacets, .. } if (microfacets.alpha_u.value - 0.46176).abs() < 1e-4)
    );
    assert_eq!(skin.media.all[0].extinction, Vec3::splat(0.5));
    assert!(matches!(bsdf(&with("Material \"substrate\"")), Bsdf::RoughPlastic { .. }));
    assert!(matches!(bsdf(&with("Material \"metal\"")), Bsdf::RoughConductor { .. }));
    let Bsdf::Conductor { eta, k, .. } = *bsdf(&with("Material \"mirror\" \"rgb Kr\" [ 0.5 0.5 0.5 ]")) else {
        panic!("a conductor")
    };
    let (eta, k) = (eta.as_dvec3(), k.as_dvec3());
    let reflected = ((eta - 1.0).powf(2.0) + k * k) / ((eta + 1.0).powf(2.0) + k * k);
    assert!((reflected - DVec3::splat(0.5)).length() < 1e-3, "{reflected}");
    let masked = with("Material \"uber\" \"rgb opacity\" [ 0.25 0.25 0.25 ] \"rgb Kd\" [ 1 1 1 ]");
    assert_eq!(surface(&masked).opacity.value, 0.25);
    let Bsdf::PrincipledThin(thin) = bsdf(&with("Material \"translucent\" \"rgb Kd\" [ 0.8 0.8 0.8 ]")).clone() else {
        panic!("a sheet")
    };
    assert_close(&[thin.base_color.value.x], &[0.8]);
}

/// The first material of v3's `mix` has the amount's share, the second of v4's.
#[test]
fn mixtures_name_their_parts_one_by_one() {
    let scene = with(
        "MakeNamedMaterial \"red\" \"string type\" \"matte\" \"rgb Kd\" [ 1 0 0 ]
         MakeNamedMaterial \"blue\" \"string type\" \"matte\" \"rgb Kd\" [ 0 0 1 ]
         Material \"mix\" \"string namedmaterial1\" \"red\" \"string namedmaterial2\" \"blue\" \"rgb amount\" [ 0.2 0.2 0.2 ]",
    );
    let blend = scene.materials.iter().find_map(|material| match &material.kind {
        lodestar::scene::MaterialKind::Blend { weight, materials } => Some((weight.value, *materials)),
        _ => None,
    });
    let (weight, [first, second]) = blend.expect("a mixture");
    let color = |index: u32| match &scene.materials[index as usize].kind {
        lodestar::scene::MaterialKind::Surface(surface) => match &surface.bsdf {
            Bsdf::Diffuse { reflectance } => reflectance.value,
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    };
    assert_eq!((weight, color(first), color(second)), (0.2, Vec3::Z, Vec3::X));
}

#[test]
fn lights_textures_and_films_become_those_of_v4() {
    let scene = with(
        "Texture \"a\" \"color\" \"scale\" \"rgb tex1\" [ 0.4 0.6 0.8 ] \"rgb tex2\" [ 0.5 0.5 0.5 ]
         Material \"matte\" \"texture Kd\" \"a\"
         LightSource \"point\" \"rgb scale\" [ 1 2 3 ] \"rgb I\" [ 10 10 10 ]
         LightSource \"point\" \"blackbody I\" [ 6500 4 ]",
    );
    let Bsdf::Diffuse { reflectance } = *bsdf(&scene) else { panic!("diffuse") };
    assert!((reflectance.value - Vec3::new(0.2, 0.3, 0.4)).length() < 1e-6, "{reflectance:?}");
    let intensity = |at: usize| match scene.delta_emitters[at].kind {
        DeltaKind::Point { intensity, .. } => intensity,
        _ => panic!("a point"),
    };
    assert_eq!(intensity(0), Vec3::new(10.0, 20.0, 30.0));
    let warm = intensity(1).as_dvec3();
    assert!((0.2126 * warm.x + 0.7152 * warm.y + 0.0722 * warm.z - 4.0).abs() < 0.01, "{warm}");
    let old =
        "Film \"image\" \"float scale\" 2 Camera \"perspective\" \"float halffov\" 20 WorldBegin LightSource \"point\"";
    let scene = load_text(old).unwrap();
    assert_eq!(scene.film.filter, ReconstructionFilter::Box);
    assert!((scene.camera.fov - 40.0).abs() < 1e-3 || scene.camera.fov > 40.0, "{}", scene.camera.fov);
    let narrow = old.replace(
        "WorldBegin",
        "PixelFilter \"gaussian\" \"float xwidth\" 2 \"float ywidth\" 2 \"float alpha\" 2 WorldBegin",
    );
    assert_eq!(load_text(&narrow).unwrap().film.filter, ReconstructionFilter::Gaussian { stddev: 0.5 });
}

/// A map of v3 has longitude and latitude, with the light's +z above.
#[test]
fn maps_of_longitude_and_latitude_light() {
    let folder = Folder::new(&[(
        "scene.pbrt",
        "Camera \"perspective\" WorldBegin LightSource \"infinite\" \"string mapname\" \"sky.exr\" \"rgb L\" [ 1 2 4 ]",
    )]);
    // The upper half shines; its first quarter in azimuth does so in red alone.
    let pixel = |at: usize| match (at / 32, at % 32) {
        (8.., _) => [0.0; 3],
        (_, 0..8) => [3.0, 0.0, 0.0],
        _ => [3.0; 3],
    };
    let image = Image { width: 32, height: 16, pixels: (0..512).map(pixel).collect() };
    folder.write("sky.exr", &encode_rgb(std::path::Path::new("sky.exr"), &image).unwrap());
    let scene = load_in(&folder).unwrap();
    let EnvironmentKind::Map { scale, to_world, .. } = scene.environment.as_ref().unwrap().kind else {
        panic!("a map")
    };
    let Texels::Floats(texels) = &scene.images[0].texels else { panic!("floats") };
    let (width, height) = (scene.images[0].width as usize, scene.images[0].height as usize);
    let mut seen = [0; 3];
    for (at, texel) in texels.iter().enumerate() {
        let (azimuth, polar) = (
            ((at % width) as f64 + 0.5) / width as f64 * std::f64::consts::TAU,
            (at / width) as f64 / (height - 1) as f64 * std::f64::consts::PI,
        );
        let own = DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
        let world = to_world.as_dmat3() * own;
        if world.z.abs() < 0.25 || world.x.abs() < 0.1 || world.y.abs() < 0.1 {
            continue;
        }
        let (kind, right) = match (world.z > 0.0, world.x > 0.0 && world.y > 0.0) {
            (false, _) => (0, Vec3::ZERO),
            (true, true) => (1, Vec3::new(3.0, 0.0, 0.0)),
            (true, false) => (2, Vec3::new(3.0, 6.0, 12.0)),
        };
        seen[kind] += 1;
        let found = scale * Vec3::new(texel[0], texel[1], texel[2]);
        assert!((found - right).length() < 0.02, "{world}: {found} is not {right}");
    }
    assert!(seen.iter().all(|&count| count > 5), "{seen:?}");
}
