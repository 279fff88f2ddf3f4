//! Media and phase functions: parameters, defaults, sides, and what is refused.

use glam::Vec3;
use lodestar::scene::{Boundary, Phase, PhaseLobe, Scene};

use super::{Folder, load_body};

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
