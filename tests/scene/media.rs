//! Media and phase functions: parameters, defaults, sides, and what is refused.

use glam::{DVec3, Vec3};
use lodestar::Result;
use lodestar::scene::{AlbedoVolume, Boundary, Phase, PhaseLobe, Scene, VolumeWrap};
use support::volumes;

use super::{Folder, load_body, with_sensor};

fn medium(inside: &str) -> lodestar::scene::Medium {
    let scene = load_body(&format!(
        "<shape type='sphere'><bsdf type='null'/><medium name='interior' type='homogeneous'>{inside}</medium></shape>"
    ));
    scene.expect("a scene").media.all[0].clone()
}

fn refused(inside: &str) -> String {
    let body = format!("<shape type='sphere'><medium name='interior' type='homogeneous'>{inside}</medium></shape>");
    load_body(&body).map(drop).expect_err("this should be refused").to_string()
}

#[test]
fn parameters_and_defaults_are_those_of_mitsuba() {
    let plain = medium("");
    assert_eq!((plain.extinction, plain.albedo, plain.phase), (Vec3::ONE, Vec3::splat(0.75), Phase::isotropic()));
    let given = medium(
        "<rgb name='sigma_t' value='1,2,3'/><rgb name='albedo' value='0.1,0.2,1'/><float name='scale' value='2'/>\
         <boolean name='sample_emitters' value='false'/><phase type='hg'><float name='g' value='-0.5'/></phase>",
    );
    assert_eq!((given.extinction, given.albedo), (Vec3::new(2.0, 4.0, 6.0), Vec3::new(0.1, 0.2, 1.0)));
    assert_eq!(given.phase, Phase::of_lobe(PhaseLobe::HenyeyGreenstein(-0.5)));
    let volume = medium("<volume name='sigma_t' type='constvolume'><float name='value' value='7'/></volume>");
    assert_eq!(volume.extinction, Vec3::splat(7.0));
    let old = medium("<rgb name='sigmaA' value='1,2,0'/><rgb name='sigmaS' value='3,2,0'/>");
    assert_eq!((old.extinction, old.albedo), (Vec3::new(4.0, 4.0, 0.0), Vec3::new(0.75, 0.5, 0.0)));
    let blend = medium(
        "<phase type='blendphase'><float name='weight' value='0.2'/><phase type='hg'/><phase type='rayleigh'/></phase>",
    );
    let lobes = [PhaseLobe::HenyeyGreenstein(0.8), PhaseLobe::Rayleigh];
    assert_eq!(blend.phase, Phase { lobes, second_lobe: 0.2 });
}

/// Boundary of a scene's only material.
fn boundary(scene: &Scene) -> Option<Boundary> {
    scene.materials[scene.primitives[0].material as usize].boundary
}

#[test]
fn shapes_and_the_camera_have_media() {
    let fog = "<medium id='fog' type='homogeneous'/>";
    let of = |sides: &str| {
        let scene = load_body(&format!("{fog}<shape type='sphere'><bsdf type='null'/>{sides}</shape>"));
        boundary(&scene.expect("a scene"))
    };
    let side = |name: &str| format!("<ref name='{name}' id='fog'/>");
    assert_eq!(of(""), None);
    assert_eq!(of(&side("interior")), Some(Boundary { interior: Some(0), exterior: None }));
    assert_eq!(of(&(side("exterior") + &side("interior"))), Some(Boundary { interior: Some(0), exterior: Some(0) }));
    // A material that also covers shapes without media keeps its record.
    let body = format!(
        "{fog}<bsdf type='null' id='none'/><shape type='sphere'><ref id='none'/>{}</shape>\
         <shape type='sphere'><ref id='none'/></shape>",
        side("interior")
    );
    let scene = load_body(&body).expect("a scene");
    let boundaries: Vec<_> = scene.primitives.iter().map(|p| scene.materials[p.material as usize].boundary).collect();
    assert_eq!(boundaries, [Some(Boundary { interior: Some(0), exterior: None }), None]);
    let text = "<scene><sensor type='perspective'><medium type='homogeneous'/></sensor><emitter type='point'><ref id='a'/></emitter>\
                <medium type='homogeneous' id='a'/></scene>";
    let scene = Folder::new(&[("scene.xml", text)]).load(&[]).expect("a scene");
    assert_eq!((scene.media.of_camera, scene.media.all.len()), (Some(0), 1));
}

#[test]
fn bad_media_are_refused_in_a_sentence() {
    for (inside, says) in [
        ("<float name='sigma_t' value='-1'/>", "must not be negative"),
        ("<float name='sigma_t' value='nan'/>", "scene.xml:2"),
        ("<rgb name='albedo' value='0.5,1.5,0.5'/>", "the `albedo` of a medium must not exceed 1, as 1.5 does"),
        ("<float name='scale' value='-2'/>", "`scale` of a medium must not be negative, but is -2"),
        ("<float name='scale' value='3e38'/><float name='sigma_t' value='9'/>", "exceeds the range"),
        ("<float name='sigma_a' value='1'/>", "by both `sigma_a` and `sigma_s`"),
        ("<phase type='hg'><float name='g' value='1'/></phase>", "`g` must lie between -1 and 1, but is 1"),
        ("<phase type='sggx'/>", "phase plugin `sggx` is not supported"),
        ("<phase type='blendphase'/>", "needs its parameter `weight`"),
        ("<phase type='blendphase'><float name='weight' value='0.5'/></phase>", "exactly two nested"),
        ("<volume name='sigma_t' type='gridvolume'/>", "volume plugin `gridvolume` is not supported"),
        ("<bsdf type='null'/>", "is not supported in medium `homogeneous`"),
    ] {
        let message = refused(inside);
        assert!(message.contains(says) && !message.contains('\n'), "{inside}: {message}");
    }
    let message = load_body("<shape type='sphere'><medium name='inside' type='homogeneous'/></shape>");
    let message = message.map(drop).expect_err("this should be refused").to_string();
    assert!(message.contains("is named `interior` or `exterior`, not `inside`"), "{message}");
}

/// Mitsuba's `path` leaves media out.
#[test]
fn a_scene_for_path_is_told_that_its_media_are_rendered() {
    let body = "<integrator type='path'/><shape type='sphere'><medium name='interior' type='homogeneous'/></shape>";
    let warnings = load_body(body).expect("a scene").warnings;
    assert!(warnings.iter().any(|warning| warning.contains("`path` leaves media out")), "{warnings:?}");
}

/// Medium of a sphere that is a grid, with `smoke.vol` and `colors.vol` of 2 x 1 x 1 voxels beside it.
fn grid(inside: &str) -> Result<Scene> {
    let text = with_sensor(&format!(
        "<shape type='sphere'><bsdf type='null'/><medium name='interior' type='heterogeneous'>{inside}</medium></shape>"
    ));
    let folder = Folder::new(&[("scene.xml", &text)]);
    folder.write("smoke.vol", &volumes::file([2, 1, 1], &[0.5, 2.0]));
    folder.write("colors.vol", &volumes::file([2, 1, 1], &[0.1, 0.2, 0.3, 0.4, 0.5, 1.0]));
    folder.write("holes.vol", &volumes::file([2, 1, 1], &[f32::NAN, 1.0]));
    folder.write("cut.vol", &volumes::file([2, 2, 1], &[0.5, 2.0]));
    folder.load(&[])
}

fn volume(name: &str, file: &str, more: &str) -> String {
    format!("<volume name='{name}' type='gridvolume'><string name='filename' value='{file}'/>{more}</volume>")
}

#[test]
fn grids_have_the_parameters_of_mitsuba() {
    let scaled = "<transform name='to_world'><scale value='4'/></transform>";
    let inside = volume("sigma_t", "smoke.vol", scaled)
        + &volume(
            "albedo",
            "colors.vol",
            "<string name='wrap_mode' value='repeat'/><string name='filter_type' value='nearest'/>",
        )
        + "<float name='scale' value='3'/>";
    let medium = grid(&inside).expect("a scene").media.all[0].clone();
    assert_eq!((medium.extinction, medium.albedo), (Vec3::splat(3.0), Vec3::ONE));
    let volumes = medium.volumes.expect("volumes");
    let extinction = volumes.extinction;
    assert_eq!((extinction.size.to_array(), &extinction.values[..]), ([2, 1, 1], &[0.5, 2.0][..]));
    assert_eq!((extinction.wrap, extinction.is_nearest, extinction.has_colors), (VolumeWrap::Clamp, false, false));
    assert_eq!(extinction.bounds().1.to_array(), [4.0; 3]);
    let Some(AlbedoVolume::Share(albedo)) = volumes.albedo else { panic!("no grid of albedo") };
    assert_eq!((albedo.wrap, albedo.is_nearest, albedo.has_colors), (VolumeWrap::Repeat, true, true));
    // A color stands for a `constvolume`, which fills the unit cube.
    let constant = grid("<float name='sigma_t' value='5'/>").expect("a scene").media.all[0].clone();
    let bounds = constant.volumes.map(|volumes| (volumes.extinction.bounds(), volumes.extinction.most()));
    assert_eq!(bounds, Some(((DVec3::ZERO, DVec3::ONE), Vec3::splat(5.0))));
    // Mitsuba 0.6 has a density.
    let old =
        volume("density", "smoke.vol", "") + "<rgb name='sigmaA' value='1,2,0'/><rgb name='sigmaS' value='3,2,0'/>";
    let old = grid(&old).expect("a scene").media.all[0].clone();
    assert_eq!((old.extinction, old.albedo), (Vec3::new(4.0, 4.0, 0.0), Vec3::new(0.75, 0.5, 0.0)));
}

#[test]
fn bad_grids_are_refused_in_a_sentence() {
    for (inside, says) in [
        (volume("sigma_t", "none.vol", ""), "the volume `none.vol` does not exist"),
        (volume("sigma_t", "scene.xml", ""), "`scene.xml` is no `.vol` file"),
        (volume("sigma_t", "holes.vol", ""), "`holes.vol` has a value that is no finite number"),
        (volume("sigma_t", "cut.vol", ""), "`cut.vol` has 0 channels"),
        (volume("albedo", "smoke.vol", ""), "the `albedo` of a medium must not exceed 1, as 2 does"),
        (
            volume("sigma_t", "smoke.vol", "<float name='scale' value='1'/>") + "<float name='scale' value='2e38'/>",
            "exceeds the range",
        ),
        (
            volume("sigma_t", "smoke.vol", "<string name='wrap_mode' value='torus'/>"),
            "`wrap_mode` of a volume should be",
        ),
        (
            volume("sigma_t", "smoke.vol", "<string name='filter_type' value='cubic'/>"),
            "`filter_type` of a volume should be",
        ),
        (
            volume("sigma_t", "smoke.vol", "<transform name='to_world'><scale x='0'/></transform>"),
            "the `to_world` of a volume flattens it",
        ),
        ("<volume name='sigma_t' type='fog'/>".to_owned(), "volume plugin `fog` is not supported"),
        ("<float name='sigma_a' value='1'/>".to_owned(), "`sigma_a` of `heterogeneous` is not supported"),
    ] {
        let message = grid(&inside).map(drop).expect_err(says).to_string();
        assert!(message.contains(says) && !message.contains('\n'), "{inside}: {message}");
    }
}
