//! Directives, included files, and words in which a file is refused.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::{DVec3, UVec3, Vec3};
use lodestar::math::perlin::noise;
use lodestar::scene::{AlbedoVolume, Boundary, Bsdf, Phase, PhaseLobe, VolumeWrap};

use super::{bsdf, load_in, load_text, world};
use crate::Folder;

fn center(text: &str) -> Vec3 {
    world(text).unwrap_or_else(|error| panic!("{text}: {error}")).primitives[0].origin
}

/// Transforms apply to what follows, the last one first, and blocks restore them.
#[test]
fn transforms() {
    for (before, expected) in [
        ("Translate 1 2 3", [1.0, 2.0, 3.0]),
        ("Scale 2 2 2 Translate 1 0 0", [2.0, 0.0, 0.0]),
        ("Translate 1 0 0 Scale 2 2 2", [1.0, 0.0, 0.0]),
        ("Rotate 90 0 0 2 Translate 1 0 0", [0.0, 1.0, 0.0]),
        ("Translate 9 9 9 Identity", [0.0; 3]),
        ("Translate 9 9 9 Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 4 5 6 1 ]", [4.0, 5.0, 6.0]),
        ("Transform [ 2 0 0 0 0 2 0 0 0 0 2 0 8 10 12 2 ]", [4.0, 5.0, 6.0]),
        ("Translate 1 1 1 ConcatTransform [ 1 0 0 0 0 1 0 0 0 0 1 0 4 5 6 1 ]", [5.0, 6.0, 7.0]),
        ("AttributeBegin Translate 1 0 0 AttributeEnd", [0.0; 3]),
        ("CoordinateSystem \"here\" Translate 1 0 0 CoordSysTransform \"here\"", [0.0; 3]),
        // The camera stands at (0, 0, -5).
        ("CoordSysTransform \"camera\"", [0.0, 0.0, -5.0]),
        ("Translate 1 0 0 CoordSysTransform \"world\"", [0.0; 3]),
        ("LookAt 1 2 3  1 2 4  0 1 0", [-1.0, -2.0, -3.0]),
    ] {
        let found = center(&format!("{before} Shape \"sphere\""));
        assert!((found - Vec3::from(expected)).length() < 1e-5, "{before}: {found}");
    }
    let old = world("TransformBegin Translate 1 0 0 TransformEnd Shape \"sphere\"").unwrap();
    assert!(old.warnings.join("\n").contains("TransformBegin and TransformEnd are deprecated"));
}

/// Directives change the transforms at the start and at the end of the motion, or one of them.
#[test]
fn motion() {
    let place = |scene: &lodestar::scene::Scene, time: f64| scene.motions[0].at(time).w_axis.truncate().as_vec3();
    let near = |a: Vec3, b: [f32; 3]| assert!(a.abs_diff_eq(b.into(), 1.0e-6), "{a}, not {b:?}");
    let move_end = "ActiveTransform EndTime Translate 1 0 0 ActiveTransform All Translate 0 1 0";
    let moving = world(&format!("{move_end} Shape \"sphere\"")).unwrap();
    near(place(&moving, 0.0), [0.0, 1.0, 0.0]);
    near(place(&moving, 0.25), [0.25, 1.0, 0.0]);
    // Blocks restore both transforms, and coordinate systems hold both.
    for still in [
        format!("AttributeBegin {move_end} AttributeEnd Shape \"sphere\""),
        format!("{move_end} CoordSysTransform \"world\" Shape \"sphere\""),
        format!("{move_end} Identity Shape \"sphere\""),
    ] {
        assert_eq!(world(&still).unwrap().primitives[0].origin, Vec3::ZERO, "{still}");
    }
    // Instances move as a whole. A disk is cut into triangles, and lamps move with their shapes.
    let object = "ObjectBegin \"a\" Shape \"sphere\" Shape \"disk\" ObjectEnd";
    let moving = world(&format!("{object} {move_end} ObjectInstance \"a\"")).unwrap();
    assert_eq!((moving.instances.len(), moving.groups[0].primitives.len(), moving.primitives.len()), (1, 2, 0));
    let lamp = format!("AreaLightSource \"diffuse\" {move_end} Shape \"disk\"");
    let moving = world(&lamp).unwrap();
    assert!(moving.groups[0].primitives.iter().all(|p| p.emitter.is_some()), "{:?}", moving.groups);
    assert!(moving.warnings[0].contains("a disk that moves is cut into triangles"), "{:?}", moving.warnings);
    // What does not move is told or refused.
    let light = world(&format!("{move_end} LightSource \"point\"")).unwrap();
    assert!(light.warnings[0].contains("lights without a shape do not move"), "{:?}", light.warnings);
    let within = world(&format!("ObjectBegin \"a\" {move_end} Shape \"sphere\" ObjectEnd")).map(drop);
    assert!(within.unwrap_err().to_string().contains("move its ObjectInstance"));
}

/// The camera moves, at times that the file gives.
#[test]
fn motion_of_the_camera_and_its_times() {
    let text = "TransformTimes 1 3\nActiveTransform EndTime Translate -2 0 0 ActiveTransform All\n\
                Camera \"perspective\" \"float shutteropen\" 1 \"float shutterclose\" 2 WorldBegin LightSource \"infinite\"";
    let scene = load_text(text).unwrap();
    let motion = scene.camera_motion.expect("a motion");
    let place = |time: f64| motion.at(time).w_axis.truncate().as_vec3();
    assert!(place(0.0).abs_diff_eq(Vec3::ZERO, 1.0e-6) && place(1.0).abs_diff_eq(Vec3::X, 1.0e-6));
    let wrong = text.replace("TransformTimes 1 3", "TransformTimes 3 3");
    assert!(load_text(&wrong).map(drop).unwrap_err().to_string().contains("the second time must be after the first"));
}

/// An included file changes the state of the file that includes it, and an imported one does not.
#[test]
fn files_within_files() {
    let part = "Material \"diffuse\" \"rgb reflectance\" [ 0.1 0.1 0.1 ] Translate 1 0 0";
    let read = |directive: &str| {
        let text = format!("Camera \"perspective\" WorldBegin {directive} \"parts/a.pbrt\" Shape \"sphere\"");
        let folder = Folder::new(&[("scene.pbrt", &text), ("parts/a.pbrt", "Include \"b.pbrt.gz\"")]);
        let mut compressed = GzEncoder::new(Vec::new(), Compression::default());
        compressed.write_all(part.as_bytes()).unwrap();
        // Names are relative to the folder of the main file.
        folder.write("b.pbrt.gz", &compressed.finish().unwrap());
        load_in(&folder).unwrap()
    };
    let included = read("Include");
    assert_eq!(included.primitives[0].origin, Vec3::X);
    assert!(matches!(bsdf(&included), Bsdf::Diffuse { reflectance } if reflectance.value.x == 0.1));
    let imported = read("Import");
    assert_eq!(imported.primitives[0].origin, Vec3::ZERO);
    assert!(matches!(bsdf(&imported), Bsdf::Diffuse { reflectance } if reflectance.value.x == 0.5));
}

#[test]
fn files_that_include_themselves_end() {
    let folder = Folder::new(&[("scene.pbrt", "WorldBegin Include \"a.pbrt\""), ("a.pbrt", "\nInclude \"a.pbrt\"")]);
    let error = load_in(&folder).unwrap_err();
    assert!(error.contains("a.pbrt:2: files are included more than 64 deep"), "{error}");
    // Each file includes the next one twice: 2^40 files.
    let folder = Folder::new(&[("scene.pbrt", "WorldBegin Include \"0.pbrt\"")]);
    for number in 0..40 {
        let next = format!("Include \"{}.pbrt\" ", number + 1);
        folder.write(&format!("{number}.pbrt"), next.repeat(2).as_bytes());
    }
    folder.write("40.pbrt", b"");
    let error = load_in(&folder).unwrap_err();
    assert!(error.contains("includes more than"), "{error}");
    let folder = Folder::new(&[("scene.pbrt", "WorldBegin\nInclude \"none.pbrt\"")]);
    assert!(load_in(&folder).unwrap_err().contains("scene.pbrt:2: the included file `none.pbrt` does not exist"));
}

/// Faults of several lines come together.
#[test]
fn all_faults_are_listed() {
    let error = world("Shape \"nurbs\"\nLightSource \"lamp\"\nMaterial \"fourier\" Shape \"sphere\"").unwrap_err();
    for (line, word) in [(3, "nurbs"), (4, "lamp"), (5, "fourier")] {
        assert!(error.contains(&format!("scene.pbrt:{line}: the ")) && error.contains(word), "{error}");
    }
}

#[test]
fn what_is_refused() {
    for (text, expected) in [
        ("Wrong", ":1: `Wrong` is not a directive of pbrt-v4"),
        ("\"text\"", ":1: a directive such as `Shape` should stand here, not \"text\""),
        ("Translate 1 2", ":1: the file ends where one of the 3 numbers of Translate should be"),
        ("Translate 1 2 x", ":1: `x` is not one of the 3 numbers of Translate"),
        ("Translate 1 2 1e99", ":1: `1e99` is not one of the 3 numbers"),
        ("Scale 1 0 1", ":1: Scale: a factor of 0 flattens"),
        ("Rotate 3 0 0 0", ":1: Rotate: the axis has length 0"),
        ("LookAt 0 0 0 0 0 0 0 1 0", ":1: LookAt: the camera looks at its own place"),
        ("LookAt 0 0 0 0 1 0 0 1 0", ":1: LookAt: `up` is zero or parallel"),
        ("Transform [ 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1 ]", ":1: every fourth number of a matrix must be 0"),
        ("Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 0 ]", "must be 0, and the last one must not be 0"),
        ("Transform [ 1 0 0 0 0 0 0 0 0 0 1 0 0 0 0 1 ]", ":1: the matrix has no inverse"),
        ("Shape \"sphere\"", ":1: Shape must stand after WorldBegin"),
        ("WorldBegin Film \"rgb\"", ":1: Film must stand before WorldBegin"),
        ("WorldBegin\nWorldBegin", ":2: a second WorldBegin"),
        ("WorldBegin AttributeEnd", ":1: AttributeEnd without an AttributeBegin"),
        ("WorldBegin ObjectEnd", ":1: ObjectEnd without an ObjectBegin"),
        ("Camera \"perspective\"", "scene.pbrt: it has no WorldBegin"),
        ("Camera perspective", ":1: the type of a directive should stand here between quotes, not `perspective`"),
        ("Camera \"perspective\" \"float\" 1", ":1: \"float\" should be a type and a name"),
        ("Camera \"perspective\" \"float fov\" [ 1 \"a\" ]", ":1: \"a\" cannot be a value of the parameter `fov` here"),
        ("Camera \"perspective\" \"float fov\" 1 \"float fov\" 2", "is given twice"),
        ("Camera \"perspective\" \"float fov\" [ 1", ":1: the file ends where `]` should be"),
        ("Camera \"perspective", ":1: a text between quotes does not end"),
        (
            "WorldBegin MediumInterface \"fog\" \"\"",
            ":1: the medium `fog` is not defined; define it by MakeNamedMedium",
        ),
        (
            "WorldBegin MediumInterface \"fog\" \"\" MakeNamedMedium \"fog\" \"string type\" \"mist\"",
            ":1: the medium `fog` of the type `mist` is not supported; use `homogeneous`, `uniformgrid`, `rgbgrid`, `cloud` or `nanovdb`",
        ),
        (
            "WorldBegin MediumInterface \"fog\" \"\" MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1 -2 0 ]",
            "of a medium must not be negative",
        ),
        ("WorldBegin CoordSysTransform \"none\"", ":1: there is no coordinate system `none`"),
        ("WorldBegin Attribute \"wrong\" \"float a\" 1", ":1: `wrong` has no attributes"),
        ("WorldBegin MakeNamedMaterial \"a\"", ":1: MakeNamedMaterial needs its parameter \"string type\""),
        ("WorldBegin Texture \"a\" \"wrong\" \"constant\"", ":1: a texture gives `float` or `spectrum`, not `wrong`"),
    ] {
        let error = load_text(text).expect_err(expected);
        assert!(error.contains(expected), "{error} lacks {expected}");
        assert!(!error.contains('\n') || error.contains("faults:"), "{error}");
    }
    let empty =
        world("MediumInterface \"\" \"\" MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" Shape \"sphere\"")
            .unwrap();
    assert_eq!((empty.primitives.len(), empty.media.all.len()), (1, 0));
}

/// The medium inside and outside of a shape, and that of the camera.
#[test]
fn media_are_those_of_the_interface() {
    let fog = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1 2 0 ] \"rgb sigma_s\" [ 3 2 0 ] \
               \"float scale\" 2 \"float g\" 0.5 ";
    let sphere = "Shape \"sphere\" ";
    let scene = load_text(&format!(
        "{fog}MediumInterface \"\" \"fog\" Camera \"perspective\" WorldBegin {sphere}\
         MediumInterface \"fog\" Material \"interface\" {sphere}MediumInterface \"fog\" \"\" {sphere}"
    ))
    .unwrap();
    assert_eq!((scene.media.of_camera, scene.media.all.len()), (Some(0), 1));
    let medium = &scene.media.all[0];
    assert_eq!((medium.extinction, medium.albedo), (Vec3::new(8.0, 8.0, 0.0), Vec3::new(0.75, 0.5, 0.0)));
    assert_eq!(medium.phase, Phase::of_lobe(PhaseLobe::HenyeyGreenstein(0.5)));
    let boundaries: Vec<_> = scene.primitives.iter().map(|p| scene.materials[p.material as usize].boundary).collect();
    let side = |interior, exterior| Some(Boundary { interior, exterior });
    // A shape with the same medium on both sides does not change it.
    assert_eq!(boundaries, [side(None, Some(0)), None, side(Some(0), None)]);
}

/// A grid of densities and one of colors, each in the space where it is defined.
#[test]
fn media_may_be_grids() {
    let grid = |kind: &str, values: &str| {
        let fog = format!(
            "Scale 2 2 2 MakeNamedMedium \"fog\" \"string type\" \"{kind}\" {values} \"integer nx\" 2 \
             \"point3 p0\" [ 1 0 0 ] \"point3 p1\" [ 0 1 3 ]"
        );
        load_text(&format!("Camera \"perspective\" WorldBegin {fog} MediumInterface \"fog\" \"\" Shape \"sphere\""))
    };
    let of = |kind: &str, values: &str| grid(kind, values).expect("a scene").media.all[0].clone();
    let uniform = of(
        "uniformgrid",
        "\"float density\" [ 0.5 2 ] \"rgb sigma_s\" [ 3 1 1 ] \"float scale\" 2 \"rgb Le\" [ 1 2 3 ] \"float Lescale\" [ 0 4 ]",
    );
    assert_eq!((uniform.extinction, uniform.albedo), (Vec3::new(8.0, 4.0, 4.0), Vec3::new(0.75, 0.5, 0.5)));
    assert_eq!(uniform.emission, Vec3::new(1.0, 2.0, 3.0));
    let volumes = uniform.volumes.expect("volumes");
    assert_eq!((&volumes.extinction.values[..], volumes.extinction.wrap), (&[0.5, 2.0][..], VolumeWrap::Zero));
    assert_eq!(volumes.extinction.bounds().1.to_array(), [2.0, 2.0, 6.0]);
    assert_eq!(volumes.emission.map(|emission| emission.values.to_vec()), Some(vec![0.0, 4.0]));
    let colors = of("rgbgrid", "\"rgb sigma_a\" [ 1 2 3 0 0 0 ] \"rgb sigma_s\" [ 0 1 2 3 4 5 ]");
    let volumes = colors.volumes.expect("volumes");
    assert_eq!(&volumes.extinction.values[..], &[1.0, 3.0, 5.0, 3.0, 4.0, 5.0]);
    let Some(AlbedoVolume::Scattering(scattering)) = volumes.albedo else { panic!("no grid of scattering") };
    assert_eq!(&scattering.values[..], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    // Without wisps, a cloud is the sum of five octaves of noise that fade with the height, over a layer of fog.
    let cloud = of("cloud", "\"float density\" 2 \"float wispiness\" 0 \"float frequency\" 3");
    let volume = cloud.volumes.expect("volumes").extinction;
    assert_eq!((volume.size, volume.wrap), (UVec3::splat(128), VolumeWrap::Zero));
    for voxel in [UVec3::new(5, 70, 90), UVec3::new(100, 80, 3), UVec3::new(64, 10, 64)] {
        let at = (voxel.as_dvec3() + 0.5) / 128.0 * DVec3::new(1.0, 1.0, 3.0);
        let octaves = [1.0_f64, 1.99, 1.99 * 1.99, 1.99_f64.powi(3), 1.99_f64.powi(4)];
        let sum: f64 = (1..).zip(octaves).map(|(n, scale)| 0.5_f64.powi(n) * noise(scale * 3.0 * at)).sum();
        let expected = (((1.0 - at.y) * 9.0 * sum).clamp(0.0, 1.0) + 2.0 * (0.5 - at.y).max(0.0)).clamp(0.0, 1.0);
        let found = volume.values[((voxel.z * 128 + voxel.y) * 128 + voxel.x) as usize];
        assert!((f64::from(found) - expected).abs() < 1e-6, "{voxel}: {found} is not {expected}");
    }
    for (kind, values, says) in [
        ("uniformgrid", "", "the medium needs its parameter `density`"),
        ("uniformgrid", "\"float density\" [ 1 2 3 ]", "has 3 numbers, but 2 x 1 x 1 voxels need 2"),
        ("uniformgrid", "\"float density\" [ 1 -2 ]", "has the negative value -2"),
        ("uniformgrid", "\"float density\" [ 1 2 ] \"integer ny\" 2147483647 \"integer nz\" 2147483647", "at most"),
        (
            "uniformgrid",
            "\"float density\" [ 1 2 ] \"float temperature\" [ 1 ]",
            "has 3 numbers, but 2 x 1 x 1 voxels need 6",
        ),
        ("rgbgrid", "", "neither `sigma_a` nor `sigma_s`"),
        ("rgbgrid", "\"rgb sigma_a\" [ 1 2 ]", "some are missing"),
        ("rgbgrid", "\"rgb sigma_a\" [ 1 2 3 1 2 -3 ]", "has the negative value -3"),
    ] {
        let error = grid(kind, values).expect_err(says);
        assert!(error.contains(says) && !error.contains('\n'), "{error} lacks {says}");
    }
}

/// A number of a parameter that is none of this reader's gives a warning with file and line; options of pbrt give none.
#[test]
fn unknown_parameters_are_named() {
    let text = "Option \"bool disablepixeljitter\" true Option \"seed\" 3\nFilm \"rgb\" \"float wrong\" 1\nCamera \"perspective\"\nWorldBegin\n\
                Shape \"sphere\" \"float odd\" 1\nLightSource \"point\" \"float strange\" 1";
    let warnings = load_text(text).unwrap().warnings;
    for (line, name, owner) in
        [(2, "wrong", "Film `rgb`"), (5, "odd", "Shape `sphere`"), (6, "strange", "LightSource `point`")]
    {
        let expected = format!("scene.pbrt:{line}: the parameter `{name}` of {owner} is not known; ignored");
        assert!(warnings.iter().any(|warning| warning.ends_with(&expected)), "{warnings:?} lack {expected}");
    }
    assert_eq!(warnings.len(), 3, "{warnings:?}");
}
