//! Materials.

use glam::Vec3;
use lodestar::scene::{Bsdf, MaterialKind, Phase, PhaseLobe};

use super::{assert_close, bsdf, surface, world};

fn with(material: &str) -> lodestar::scene::Scene {
    world(&format!("{material}\nShape \"sphere\"")).unwrap_or_else(|error| panic!("{material}: {error}"))
}

fn refused(text: &str, expected: &str) {
    let error = world(&format!("{text} Shape \"sphere\"")).expect_err(expected);
    assert!(error.contains(expected) && error.contains("scene.pbrt:3: "), "{error} lacks {expected}");
}

#[test]
fn diffuse_surfaces_have_two_sides() {
    for (material, expected) in [
        ("", [0.5; 3]),
        ("Material \"diffuse\"", [0.5; 3]),
        ("Material \"diffuse\" \"rgb reflectance\" [ 0.1 0.2 0.3 ]", [0.1, 0.2, 0.3]),
        ("Material \"diffuse\" \"spectrum reflectance\" [ 300 0.25 900 0.25 ]", [0.25; 3]),
        ("Attribute \"material\" \"rgb reflectance\" [ 0.3 0.3 0.3 ] Material \"diffuse\"", [0.3; 3]),
    ] {
        let scene = with(material);
        let Bsdf::Diffuse { reflectance } = bsdf(&scene) else { panic!("{material}") };
        let close = (reflectance.value - Vec3::from(expected)).length() < 2e-3;
        assert!(close && surface(&scene).two_sided, "{material}: {reflectance:?}");
    }
}

/// The color space of a scene is that of its colors.
#[test]
fn colors_become_srgb() {
    let scene = with("ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [ 0.2 0.5 0.3 ]");
    let Bsdf::Diffuse { reflectance } = bsdf(&scene) else { panic!("diffuse") };
    assert!((reflectance.value - Vec3::new(0.01641, 0.53904, 0.28167)).length() < 1e-3, "{reflectance:?}");
    let scene = with("ColorSpace \"aces2065-1\" Material \"diffuse\" \"rgb reflectance\" [ 0.5 0.5 0.5 ]");
    let Bsdf::Diffuse { reflectance } = bsdf(&scene) else { panic!("diffuse") };
    assert!((reflectance.value - Vec3::splat(0.5)).length() < 1e-3, "{reflectance:?}");
    refused("ColorSpace \"aces\"", "the color space `aces` is not known");
}

/// Roughness is remapped by a square root, and below 0.001 a surface is smooth.
#[test]
fn dielectrics() {
    let scene = with("Material \"dielectric\"");
    assert!(matches!(bsdf(&scene), Bsdf::Dielectric { eta, .. } if *eta == 1.5) && !surface(&scene).two_sided);
    let scene = with("Material \"dielectric\" \"float roughness\" 0.25 \"float eta\" 1.3");
    let Bsdf::RoughDielectric { microfacets, eta, .. } = bsdf(&scene) else { panic!("rough") };
    assert_close(&[microfacets.alpha_u.value, microfacets.alpha_v.value, *eta], &[0.5, 0.5, 1.3]);
    let scene =
        with("Material \"dielectric\" \"float uroughness\" 0.2 \"float vroughness\" 0.3 \"bool remaproughness\" false");
    let Bsdf::RoughDielectric { microfacets, .. } = bsdf(&scene) else { panic!("rough") };
    assert_close(&[microfacets.alpha_u.value, microfacets.alpha_v.value], &[0.2, 0.3]);
    let scene = with("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"");
    assert!(matches!(bsdf(&scene), Bsdf::Dielectric { eta, .. } if (eta - 1.5168).abs() < 1e-5));
    assert!(scene.warnings.join("\n").contains("scene.pbrt:3: material `dielectric`: dispersion is not rendered"));
    assert!(
        matches!(bsdf(&with("Material \"thindielectric\" \"float eta\" 1.4")), Bsdf::ThinDielectric { eta, .. } if *eta == 1.4)
    );
}

#[test]
fn conductors() {
    let scene = with("Material \"conductor\"");
    let Bsdf::Conductor { eta, k, .. } = bsdf(&scene) else { panic!("smooth") };
    assert_close(&[eta.x, k.x], &[0.105056, 3.270163]);
    let scene = with(
        "Material \"conductor\" \"spectrum eta\" \"metal-Ag-eta\" \"spectrum k\" \"metal-Ag-k\" \"float roughness\" 0.01",
    );
    let Bsdf::RoughConductor { eta, microfacets, .. } = bsdf(&scene) else { panic!("rough") };
    assert_close(&[eta.y, microfacets.alpha_u.value], &[0.123395, 0.1]);
    // A reflectance at a right angle: ((1 - 1)^2 + k^2) / ((1 + 1)^2 + k^2).
    let scene = with("Material \"conductor\" \"rgb reflectance\" [ 0.2 0.5 0.9 ]");
    let Bsdf::Conductor { eta, k, .. } = bsdf(&scene) else { panic!("smooth") };
    assert_eq!(*eta, Vec3::ONE);
    assert_close(&(*k * *k / (4.0 + *k * *k)).to_array(), &[0.2, 0.5, 0.9]);
    refused(
        "Material \"conductor\" \"rgb reflectance\" [ 1 1 1 ] \"rgb k\" [ 1 1 1 ]",
        "cannot stand beside `reflectance`",
    );
}

#[test]
fn coats() {
    let scene =
        with("Material \"coateddiffuse\" \"rgb reflectance\" [ 0.2 0.3 0.4 ] \"float eta\" 1.4 \"float thickness\" 0");
    let Bsdf::Plastic { eta, diffuse_reflectance, nonlinear, .. } = bsdf(&scene) else { panic!("smooth") };
    assert_close(&[*eta, diffuse_reflectance.value.z], &[1.4, 0.4]);
    assert!(*nonlinear && surface(&scene).two_sided);
    // A coat of pbrt's default thickness absorbs some hundredths of the light.
    let scene = with("Material \"coateddiffuse\" \"rgb reflectance\" [ 0.2 0.3 0.4 ]");
    let Bsdf::Plastic { diffuse_reflectance, .. } = bsdf(&scene) else { panic!("smooth") };
    assert!((0.96..0.98).contains(&(diffuse_reflectance.value.z / 0.4)), "{diffuse_reflectance:?}");
    let scene = with("Material \"coateddiffuse\" \"float roughness\" 0.04");
    assert!(matches!(bsdf(&scene), Bsdf::RoughPlastic { alpha, nonlinear: true, .. } if (alpha - 0.2).abs() < 1e-6));
    assert!(
        scene.warnings.join("\n").contains("scene.pbrt:3: material `coateddiffuse`: it is read as a `roughplastic`")
    );
    let scene = with("Material \"coatedconductor\" \"float conductor.roughness\" 0.04 \"float interface.eta\" 1.6");
    let Bsdf::RoughConductor { eta, .. } = bsdf(&scene) else { panic!("{:?}", bsdf(&scene)) };
    // Copper under a coat of 1.6.
    assert_close(&[eta.x, surface(&scene).coating.as_ref().unwrap().eta], &[0.105056 / 1.6, 1.6]);
    assert!(scene.warnings.join("\n").contains("it is read as a `coating`"));
}

#[test]
fn mixtures_and_holes() {
    let scene = with(
        "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" \"string type\" \"dielectric\"\n\
         Material \"mix\" \"string materials\" [ \"a\" \"b\" ] \"float amount\" 0.3",
    );
    let blend = scene.materials.iter().find_map(|material| match material.kind {
        MaterialKind::Blend { weight, materials } => Some((weight.value, materials)),
        _ => None,
    });
    let (weight, [first, second]) = blend.unwrap();
    let plugin = |index: u32| match &scene.materials[index as usize].kind {
        MaterialKind::Surface(surface) => surface.bsdf.clone(),
        other => panic!("{other:?}"),
    };
    assert!(
        weight == 0.3
            && matches!(plugin(first), Bsdf::Diffuse { .. })
            && matches!(plugin(second), Bsdf::Dielectric { .. })
    );
    assert_eq!(surface(&with("Material \"interface\"")).opacity.value, 0.0);
    assert_eq!(surface(&world("Shape \"sphere\" \"float alpha\" 0.25").unwrap()).opacity.value, 0.25);
    assert_eq!(surface(&world("Attribute \"shape\" \"float alpha\" 0.5 Shape \"sphere\"").unwrap()).opacity.value, 0.5);
    refused(
        "MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"a\" ] NamedMaterial \"a\"",
        "more than 16 deep",
    );
}

/// A `subsurface` is a dielectric around a medium. What is outside stays outside.
#[test]
fn subsurface_is_a_medium_below_a_dielectric() {
    let below = |parameters: &str| {
        let scene = with(&format!("Material \"subsurface\" {parameters}"));
        let boundary = scene.materials.iter().find_map(|material| material.boundary).expect("a boundary");
        assert!((boundary.interior, boundary.exterior) == (Some(0), None), "{boundary:?}");
        scene
    };
    let medium = |parameters: &str| below(parameters).media.all[0].clone();
    let milk = below("\"float roughness\" 0");
    assert!(matches!(bsdf(&milk), Bsdf::Dielectric { eta, .. } if (eta - 1.33).abs() < 1e-6));
    let named = below("\"string name\" \"Ketchup\" \"float scale\" 2 \"float g\" 0.5");
    assert!(
        named.warnings.iter().any(|warning| warning.contains("`g` is ignored beside `name`")),
        "{:?}",
        named.warnings
    );
    let named = &named.media.all[0];
    assert_eq!(named.phase, Phase::of_lobe(PhaseLobe::HenyeyGreenstein(0.0)));
    assert!((named.extinction - 2.0 * Vec3::new(0.241, 1.04, 1.48)).length() < 1e-5, "{named:?}");
    let given = medium("\"rgb sigma_a\" [ 1 2 3 ] \"rgb sigma_s\" [ 3 2 1 ] \"float g\" 0.5");
    assert_eq!((given.extinction, given.albedo.x), (Vec3::splat(4.0), 0.75));
    // Without a boundary that reflects, the fit of the reflectance of a half-space holds: 0.2 and 0.8 for these albedos.
    let fitted = medium("\"rgb reflectance\" [ 0.2 0.8 0 ] \"rgb mfp\" [ 0.5 2 1 ] \"float eta\" 1");
    assert!((fitted.extinction - Vec3::new(2.0, 0.5, 1.0)).length() < 1e-5);
    assert!((fitted.albedo - Vec3::new(0.6134, 0.9906, 0.0)).length() < 1e-3, "{fitted:?}");
    let reflecting = medium("\"rgb reflectance\" [ 0.2 0.8 0 ]");
    assert!(reflecting.albedo.cmpge(fitted.albedo).all(), "{reflecting:?}");
}

#[test]
fn measured_materials_have_two_sides() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/measured/spectral.bsdf");
    let scene = with(&format!("Material \"measured\" \"string filename\" \"{file}\""));
    let Bsdf::Measured(measured) = bsdf(&scene) else { panic!("{:?}", scene.materials) };
    assert!(measured.tables.is_isotropic() && surface(&scene).two_sided);
}

#[test]
fn what_is_refused() {
    refused("Material \"measured\" \"string filename\" \"gone.bsdf\"", "`gone.bsdf` does not exist");
    refused("Material \"measured\"", "the material `measured` needs its \"string filename\"");
    let wrong = |parameters: &str, message: &str| refused(&format!("Material \"subsurface\" {parameters}"), message);
    wrong("\"string name\" \"Jam\"", "names the medium `Jam`, which pbrt does not know");
    wrong("\"rgb mfp\" [ 1 1 1 ]", "needs its `reflectance`, too");
    wrong("\"rgb reflectance\" [ 1 1 1 ] \"rgb mfp\" [ 1 0 1 ]", "must be greater than 0");
    wrong("\"rgb sigma_a\" [ 1 1 1 ]", "both `sigma_a` and `sigma_s`, or neither");
    wrong("\"float g\" 1", "must lie between -1 and 1");
    wrong("\"float scale\" -1", "must not be negative");
    refused("Material \"fourier\"", "the material `fourier` of pbrt-v3 is not supported");
    refused("Material \"wrong\"", "the material `wrong` is not known");
    refused("NamedMaterial \"none\"", "the material `none` is not defined");
    refused("Material \"diffuse\" \"texture reflectance\" \"none\"", "the texture `none`");
    refused("Material \"diffuse\" \"float reflectance\" 0.5", "should be `rgb`, `spectrum` or `texture`");
    refused("Material \"diffuse\" \"rgb reflectance\" [ 0.5 ]", "should have three numbers, not 1");
    refused("Material \"dielectric\" \"float eta\" -2", "must be greater than 0");
    let warned = with("Material \"diffuse\" \"float wrong\" 1").warnings.join("\n");
    assert!(
        warned.contains("scene.pbrt:3: the parameter `wrong` of Material `diffuse` is not known; ignored"),
        "{warned}"
    );
}

/// Diffuse transmission: the base color is the sum, and half of the light of a sheet that reflects as much passes through.
#[test]
fn sheets() {
    let scene = with(
        "Material \"diffusetransmission\" \"rgb reflectance\" [ 0.3 0.2 0.1 ] \"rgb transmittance\" [ 0.1 0.066667 0.033333 ]",
    );
    let Bsdf::PrincipledThin(thin) = bsdf(&scene) else { panic!("{:?}", bsdf(&scene)) };
    assert_close(&thin.base_color.value.to_array(), &[0.4, 0.266667, 0.133333]);
    assert!((thin.crossing.value - 0.25).abs() < 1e-3 && thin.spec_trans.value == 0.0 && !surface(&scene).two_sided);
    let of_sheet = scene.warnings.iter().filter(|warning| warning.contains("material `diffusetransmission`"));
    assert_eq!(of_sheet.count(), 1, "{:?}", scene.warnings);
    let scene = with(
        "Material \"diffusetransmission\" \"rgb reflectance\" [ 0.5 0 0 ] \"rgb transmittance\" [ 0 0.5 0 ] \"float scale\" 0.5",
    );
    let Bsdf::PrincipledThin(thin) = bsdf(&scene) else { panic!("thin") };
    assert_close(&thin.base_color.value.to_array(), &[0.25, 0.25, 0.0]);
    assert!(scene.warnings.join("\n").contains("the same share of each color passes through"));
}
