//! Readers of `phong`, `ward`, `pplastic` and `principledthin`.

use glam::Vec3;
use lodestar::scene::bsdf::{Distribution, Microfacets, PrincipledThin, WardVariant};
use lodestar::scene::{Bsdf, MaterialKind, Scene, Textured};

use super::{Folder, load_body, with_sensor};

fn shape(plugin: &str, parameters: &str) -> String {
    format!(r#"<shape type="disk"><bsdf type="{plugin}" id="a">{parameters}</bsdf></shape>"#)
}

#[track_caller]
fn bsdf_of(scene: &Scene) -> Bsdf {
    let MaterialKind::Surface(surface) = &scene.materials[0].kind else { panic!("no surface") };
    surface.bsdf.clone()
}

#[track_caller]
fn bsdf(plugin: &str, parameters: &str) -> Bsdf {
    let scene = load_body(&shape(plugin, parameters)).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    bsdf_of(&scene)
}

#[track_caller]
fn refuse(plugin: &str, parameters: &str, word: &str) {
    let message = load_body(&shape(plugin, parameters)).map(drop).expect_err("this should be refused").to_string();
    assert!(message.contains("scene.xml:2: ") && message.contains(word), "{message}");
}

fn gray(value: f32) -> Textured<Vec3> {
    Textured::constant(Vec3::splat(value))
}

fn number(value: f32) -> Textured<f32> {
    Textured::constant(value)
}

#[test]
fn phong() {
    let phong = |exponent, diffuse, specular| Bsdf::Phong {
        exponent: number(exponent),
        diffuse_reflectance: gray(diffuse),
        specular_reflectance: gray(specular),
    };
    // Mitsuba 0.6's defaults.
    assert_eq!(bsdf("phong", ""), phong(30.0, 0.5, 0.2));
    let given = r#"<float name="exponent" value="8"/><rgb name="diffuseReflectance" value="0.1"/>
        <rgb name="specularReflectance" value="0.4"/>"#;
    assert_eq!(bsdf("phong", given), phong(8.0, 0.1, 0.4));
    refuse("phong", r#"<float name="exponent" value="-1"/>"#, "`exponent`");
}

#[test]
fn ward() {
    let ward = |variant, alpha_u, alpha_v| Bsdf::Ward {
        variant,
        alpha_u: number(alpha_u),
        alpha_v: number(alpha_v),
        diffuse_reflectance: gray(0.5),
        specular_reflectance: gray(0.2),
    };
    assert_eq!(bsdf("ward", ""), ward(WardVariant::Balanced, 0.1, 0.1));
    assert_eq!(bsdf("ward", r#"<float name="alphaU" value="0.3"/>"#), ward(WardVariant::Balanced, 0.3, 0.1));
    let both = r#"<float name="alpha" value="0.3"/><float name="alphaV" value="0.2"/>"#;
    assert_eq!(bsdf("ward", both), ward(WardVariant::Balanced, 0.3, 0.2));
    for (name, variant) in [("ward", WardVariant::Ward), ("ward-duer", WardVariant::Duer)] {
        let parameters = format!(r#"<string name="variant" value="{name}"/>"#);
        assert_eq!(bsdf("ward", &parameters), ward(variant, 0.1, 0.1));
    }
    refuse("ward", r#"<string name="variant" value="cook"/>"#, "`cook`");
}

/// Both reflectances are scaled by 0.99 over the largest channel of their sum, as in Mitsuba 0.6.
#[test]
fn energy_is_conserved() {
    let bright = r#"<rgb name="diffuseReflectance" value="0.9, 0.1, 0.1"/>
        <rgb name="specularReflectance" value="0.6, 0.6, 0.1"/>"#;
    let board = r#"<texture type="checkerboard" name="diffuseReflectance"><rgb name="color0" value="0.9"/>
        <rgb name="color1" value="0.1"/></texture><rgb name="specularReflectance" value="0.6"/>"#;
    for plugin in ["phong", "ward"] {
        for (parameters, specular) in [(bright, Vec3::new(0.6, 0.6, 0.1)), (board, Vec3::splat(0.6))] {
            let scene = load_body(&shape(plugin, parameters)).unwrap();
            let (Bsdf::Phong { specular_reflectance, .. } | Bsdf::Ward { specular_reflectance, .. }) = bsdf_of(&scene)
            else {
                panic!("another BSDF")
            };
            assert!(specular_reflectance.value.abs_diff_eq(specular * (0.99 / 1.5), 1e-6), "{specular_reflectance:?}");
            assert!(scene.warnings.len() == 1 && scene.warnings[0].contains("`a`"), "{:?}", scene.warnings);
        }
        // A sum of 1 stays.
        let whole = r#"<rgb name="diffuseReflectance" value="0.5"/><rgb name="specularReflectance" value="0.5"/>"#;
        bsdf(plugin, whole);
    }
    let off = r#"<boolean name="ensureEnergyConservation" value="false"/>"#;
    let warnings = load_body(&shape("phong", off)).unwrap().warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("`ensureEnergyConservation`"), "{warnings:?}");
}

#[test]
fn polarized_plastic() {
    let expected = |distribution, alpha_u, alpha_v| Bsdf::PolarizedPlastic {
        microfacets: Microfacets { distribution, alpha_u: number(alpha_u), alpha_v: number(alpha_v) },
        eta: 1.49 / 1.000277,
        diffuse_reflectance: gray(0.5),
        specular_reflectance: gray(1.0),
        weighted_base: false,
        base_weight: number(1.0),
        rough_base: false,
        base_roughness: number(0.0),
    };
    assert_eq!(bsdf("pplastic", ""), expected(Distribution::Beckmann, 0.1, 0.1));
    let given = r#"<string name="distribution" value="ggx"/><float name="alpha_u" value="0.3"/>
        <float name="alpha_v" value="0.2"/>"#;
    assert_eq!(bsdf("pplastic", given), expected(Distribution::Ggx, 0.3, 0.2));
    refuse("pplastic", r#"<float name="int_ior" value="1.5"/><float name="ext_ior" value="1.5"/>"#, "differ");
    // A weight of 1 is not the same as none: the facets take nothing from the base.
    for weight in [0.25, 1.0] {
        let read = bsdf("pplastic", &format!(r#"<float name="base_weight" value="{weight}"/>"#));
        let Bsdf::PolarizedPlastic { weighted_base, base_weight, .. } = read else { panic!("{read:?}") };
        assert_eq!((weighted_base, base_weight), (true, number(weight)));
    }
}

#[test]
fn principled_thin() {
    let plain = PrincipledThin {
        base_color: gray(0.5),
        roughness: number(0.5),
        anisotropic: number(0.0),
        spec_trans: number(0.0),
        eta: 1.5,
        spec_tint: number(0.0),
        sheen: number(0.0),
        sheen_tint: number(0.0),
        flatness: number(0.0),
        crossing: number(0.0),
    };
    assert_eq!(bsdf("principledthin", ""), Bsdf::PrincipledThin(plain.clone()));
    let given = r#"<float name="eta" value="1.33"/><float name="spec_trans" value="0.8"/>
        <float name="diff_trans" value="0.3"/>"#;
    let expected = PrincipledThin { eta: 1.33, spec_trans: number(0.8), crossing: number(0.15), ..plain };
    assert_eq!(bsdf("principledthin", given), Bsdf::PrincipledThin(expected));
    let board = r#"<texture type="checkerboard" name="diff_trans"/>"#;
    let Bsdf::PrincipledThin(textured) = bsdf("principledthin", board) else { panic!("another BSDF") };
    assert!(textured.crossing.texture.is_some() && textured.crossing.value == 0.5, "{:?}", textured.crossing);
    let warnings = load_body(&shape("principledthin", r#"<float name="diff_trans" value="3"/>"#)).unwrap().warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("`diff_trans`"), "{warnings:?}");
    // Light always may cross a thin sheet, so that it has no place inside `twosided`.
    let inside = r#"<shape type="disk"><bsdf type="twosided"><bsdf type="principledthin"/></bsdf></shape>"#;
    let message = load_body(inside).map(drop).expect_err("this should be refused").to_string();
    assert!(message.contains("`twosided`"), "{message}");
}

/// A material that a shape of a group has is scaled once.
#[test]
fn energy_is_conserved_once() {
    let body = r#"<bsdf type="phong" id="a"><rgb name="diffuseReflectance" value="1"/></bsdf>
<shape type="disk"><ref id="a"/></shape><shape type="disk"><ref id="a"/></shape>"#;
    let scene = Folder::new(&[("scene.xml", &with_sensor(body))]).load(&[]).unwrap();
    assert_eq!((scene.materials.len(), scene.warnings.len()), (1, 1), "{:?}", scene.warnings);
}
