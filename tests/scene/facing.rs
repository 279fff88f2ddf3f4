//! Lamps that face what they light: `facingdisk` and `spotarea`.

use glam::Vec3;
use lodestar::scene::{MaterialKind, PrimitiveShape, Scene, Textured};

use super::load_body;

const AREA: &str = "<emitter type='area'><rgb name='radiance' value='3'/></emitter>";

fn read(inside: &str) -> Scene {
    let scene = load_body(&format!("<shape type='facingdisk'>{inside}</shape>")).expect("a scene");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    scene
}

fn refused(body: &str, words: &str) {
    let error = load_body(body).map(drop).expect_err("refused").to_string();
    assert!(error.contains(words) && error.contains("scene.xml:"), "{error}");
}

#[test]
fn a_facing_disk_is_a_sphere_that_light_passes() {
    let place = "<transform name='to_world'><scale value='-2'/></transform><point name='center' x='1' y='0' z='0'/>";
    let scene = read(&format!("{place}<float name='radius' value='0.5'/>{AREA}"));
    let disk = &scene.primitives[0];
    assert_eq!((disk.origin, disk.edge_u.length(), disk.flip_normal), (Vec3::new(-2.0, 0.0, 0.0), 1.0, false));
    assert_eq!(disk.shape, PrimitiveShape::FacingDisk);
    let MaterialKind::Surface(surface) = &scene.materials[disk.material as usize].kind else { panic!("no surface") };
    assert_eq!((surface.opacity, scene.emitters[0].cone), (Textured::constant(0.0), None));
    let hidden = read(&format!("<boolean name='visible_to_camera' value='false'/>{AREA}"));
    assert!(hidden.primitives[0].unseen && !disk.unseen);
}

/// Every shape may be invisible to the camera, unless it bounds a medium.
#[test]
fn shapes_hide_from_the_camera() {
    let hidden = "<boolean name='visible_to_camera' value='false'/>";
    for plugin in ["rectangle", "disk", "cube", "sphere", "cylinder"] {
        for (inside, unseen) in [("", false), (hidden, true)] {
            let scene = load_body(&format!("<shape type='{plugin}'>{inside}</shape>")).expect("a scene");
            assert!(
                scene.warnings.iter().all(|warning| !warning.contains("visible_to_camera")),
                "{:?}",
                scene.warnings
            );
            assert!(scene.primitives.iter().all(|primitive| primitive.unseen == unseen), "{plugin}, {inside}");
        }
    }
    let fog = "<medium name='interior' type='homogeneous'/>";
    refused(
        &format!("<shape type='sphere'>{hidden}{fog}</shape>"),
        "bounds a medium cannot be invisible to the camera",
    );
}

#[test]
fn a_cone_lies_about_the_axis_of_its_shape() {
    let spot = "<transform name='to_world'><rotate x='1' angle='-90'/></transform><emitter type='spotarea'>\
                <float name='cutoff_angle' value='60'/><float name='beam_width' value='30'/></emitter>";
    let cone = read(spot).emitters[0].cone.expect("a cone");
    assert!(cone.axis.abs_diff_eq(Vec3::Y, 1.0e-6), "{cone:?}");
    assert!((cone.cos_cutoff - 0.5).abs() < 1.0e-6 && (cone.cos_beam - 0.75_f64.sqrt()).abs() < 1.0e-6, "{cone:?}");
    assert!((cone.share() - 0.5 * (1.0 - 0.5 * (0.5 + 0.75_f64.sqrt()))).abs() < 1.0e-6);
    // A beam as wide as the cone has a sharp edge.
    let sharp = "<emitter type='spotarea'><float name='cutoff_angle' value='60'/><float name='beam_width' value='60'/></emitter>";
    let cone = read(sharp).emitters[0].cone.expect("a cone");
    assert!(cone.cos_beam > cone.cos_cutoff && cone.cos_beam < 0.501, "{cone:?}");
    // Also that of a narrow cone.
    let narrow = "<emitter type='spotarea'><float name='cutoff_angle' value='0.2'/><float name='beam_width' value='0.2'/></emitter>";
    let cone = read(narrow).emitters[0].cone.expect("a cone");
    assert!(cone.cos_cutoff < cone.cos_beam && cone.cos_beam < 1.0 && cone.share() > 0.0, "{cone:?}");
    assert!((cone.share() / (0.5 * (1.0 - 0.2_f64.to_radians().cos())) - 1.0).abs() < 1.0e-3, "{cone:?}");
}

/// Light leaves on the side of the normal.
#[test]
fn a_cone_turns_with_the_normal() {
    let spot = "<emitter type='spotarea'/>";
    for (inside, axis) in [
        ("", Vec3::Z),
        ("<boolean name='flip_normals' value='true'/>", Vec3::NEG_Z),
        ("<transform name='to_world'><scale z='-1'/></transform>", Vec3::NEG_Z),
    ] {
        let scene = load_body(&format!("<shape type='rectangle'>{inside}{spot}</shape>")).expect("a scene");
        let primitive = &scene.primitives[0];
        let side = if primitive.flip_normal { -1.0 } else { 1.0 };
        let normal = side * primitive.edge_u.cross(primitive.edge_v).normalize();
        let cone = scene.emitters[0].cone.expect("a cone");
        assert!(
            cone.axis.abs_diff_eq(axis, 1.0e-6) && normal.abs_diff_eq(axis, 1.0e-6),
            "{inside}: {cone:?}, {normal}"
        );
    }
}

#[test]
fn what_a_facing_disk_cannot_have_is_refused() {
    let disk = |inside: &str| format!("<shape type='facingdisk'>{inside}</shape>");
    refused(&disk(""), "a `facingdisk` is a lamp; give it an `area` emitter");
    refused(&disk(&format!("{AREA}<bsdf type='diffuse'/>")), "a `facingdisk` has no BSDF, because all light passes it");
    refused(&disk(&format!("{AREA}<boolean name='flip_normals' value='true'/>")), "has no `flip_normals`");
    let fog = "<medium name='interior' type='homogeneous'/>";
    refused(&disk(&format!("{AREA}{fog}")), "a `facingdisk` bounds no medium");
    let textured = "<emitter type='area'><texture type='checkerboard' name='radiance'/></emitter>";
    refused(&disk(textured), "cannot be a texture, because the disk turns");
    let uneven = "<transform name='to_world'><scale x='2'/></transform>";
    refused(&disk(&format!("{uneven}{AREA}")), "the `to_world` of a facingdisk must not scale unevenly or shear");
    let narrow = "<emitter type='spotarea'><float name='cutoff_angle' value='0.1'/></emitter>";
    refused(&disk(narrow), "`cutoff_angle` of a `spotarea` must be at least 0.2, not 0.1");
    let group = disk("<emitter type='spotarea'/>");
    refused(
        &format!("<shape type='shapegroup'>{group}</shape>"),
        "a `spotarea` emitter cannot stand in a `shapegroup`",
    );
    let keys = "<animation name='to_world'><transform time='0'/><transform time='1'><translate x='1'/></transform></animation>";
    refused(&disk(&format!("{keys}<emitter type='spotarea'/>")), "a `spotarea` emitter cannot move");
}
