//! One small file per BSDF plugin, and the effect of every parameter.

use glam::Vec3;
use lodestar::scene::bsdf::{Coating, Distribution, Film, Microfacets, Principled, Relief, ReliefRules, Sheen};
use lodestar::scene::{Bsdf, Material, MaterialKind, Scene, SurfaceMaterial, Textured};

use super::{Folder, load_body, with_sensor};

const BK7: f32 = 1.5046 / 1.000277;
const POLYPROPYLENE: f32 = 1.49 / 1.000277;

fn shape(bsdf: &str) -> String {
    format!(r#"<shape type="disk">{bsdf}</shape>"#)
}

/// Scene of a disk with this `<bsdf>`, loaded without a warning.
#[track_caller]
fn scene(bsdf: &str) -> Scene {
    let scene = load_body(&shape(bsdf)).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    scene
}

#[track_caller]
fn surface_of(material: &Material) -> &SurfaceMaterial {
    let MaterialKind::Surface(surface) = &material.kind else { panic!("{material:?} is no surface") };
    surface
}

/// Surface of a disk with this `<bsdf>`.
#[track_caller]
fn surface(bsdf: &str) -> SurfaceMaterial {
    let scene = scene(bsdf);
    surface_of(&scene.materials[scene.primitives[0].material as usize]).clone()
}

#[track_caller]
fn bsdf(plugin: &str, parameters: &str) -> Bsdf {
    surface(&format!(r#"<bsdf type="{plugin}">{parameters}</bsdf>"#)).bsdf
}

#[track_caller]
fn refuse(bsdf: &str, parts: &[&str]) {
    let message = load_body(&shape(bsdf)).map(drop).expect_err("this should be refused").to_string();
    for part in [&["scene.xml:2: "], parts].concat() {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

fn gray(value: f32) -> Textured<Vec3> {
    Textured::constant(Vec3::splat(value))
}

fn number(value: f32) -> Textured<f32> {
    Textured::constant(value)
}

#[test]
fn diffuse() {
    assert_eq!(bsdf("diffuse", ""), Bsdf::Diffuse { reflectance: gray(0.5) });
    let given = bsdf("diffuse", r#"<rgb name="reflectance" value="0.1, 0.2, 0.3"/>"#);
    assert_eq!(given, Bsdf::Diffuse { reflectance: Textured::constant(Vec3::new(0.1, 0.2, 0.3)) });
    // The figure is Mitsuba 3.9's reduction.
    let spectrum = bsdf("diffuse", r#"<spectrum name="reflectance" value="400:0.5, 700:0.6"/>"#);
    let Bsdf::Diffuse { reflectance } = spectrum else { panic!() };
    assert!(reflectance.value.abs_diff_eq(Vec3::new(0.578086, 0.547524, 0.511059), 1e-5), "{reflectance:?}");
}

#[test]
fn rough_diffuse() {
    let given = r#"<float name="alpha" value="0.4"/><boolean name="useFastApprox" value="true"/>"#;
    let kept = r#"<float name="alpha" value="1"/><boolean name="energy_preserving" value="true"/>"#;
    for (parameters, alpha, fast_approximation, energy_preserving) in
        [("", 0.2, false, false), (given, 0.4, true, false), (kept, 1.0, false, true)]
    {
        let expected =
            Bsdf::RoughDiffuse { reflectance: gray(0.5), alpha: number(alpha), fast_approximation, energy_preserving };
        assert_eq!(bsdf("roughdiffuse", parameters), expected);
    }
    let both = format!(r#"<bsdf type="roughdiffuse">{given}<boolean name="energy_preserving" value="true"/></bsdf>"#);
    refuse(&both, &["`use_fast_approx` or `energy_preserving`, not both"]);
}

#[test]
fn dielectrics() {
    let plain = |eta| Bsdf::Dielectric { eta, specular_reflectance: gray(1.0), specular_transmittance: gray(1.0) };
    assert_eq!(bsdf("dielectric", ""), plain(BK7));
    let numbers = r#"<float name="intIOR" value="1.5"/><float name="extIOR" value="1"/>"#;
    assert_eq!(bsdf("dielectric", numbers), plain(1.5));
    let names = r#"<string name="int_ior" value="Diamond"/><string name="ext_ior" value="water"/>"#;
    assert_eq!(bsdf("dielectric", names), plain(2.419 / 1.333));
    let tinted = r#"<rgb name="specularReflectance" value="0.2"/><rgb name="specularTransmittance" value="0"/>"#;
    let expected =
        Bsdf::ThinDielectric { eta: BK7, specular_reflectance: gray(0.2), specular_transmittance: gray(0.0) };
    assert_eq!(bsdf("thindielectric", tinted), expected);
}

fn facets(distribution: Distribution, alpha_u: f32, alpha_v: f32) -> Microfacets {
    Microfacets { distribution, alpha_u: number(alpha_u), alpha_v: number(alpha_v) }
}

#[test]
fn rough_dielectric() {
    let expected = |microfacets| Bsdf::RoughDielectric {
        microfacets,
        eta: BK7,
        specular_reflectance: gray(1.0),
        specular_transmittance: gray(1.0),
    };
    assert_eq!(bsdf("roughdielectric", ""), expected(facets(Distribution::Beckmann, 0.1, 0.1)));
    let given = r#"<string name="distribution" value="GGX"/>
        <float name="alphaU" value="0.3"/><float name="alpha_v" value="0"/>"#;
    // Roughness is at least 1e-4, as in Mitsuba.
    assert_eq!(bsdf("roughdielectric", given), expected(facets(Distribution::Ggx, 0.3, 1e-4)));
}

#[test]
fn what_would_change_the_noise_only_is_a_warning() {
    let parameter = |plugin, name| {
        load_body(&format!(r#"<bsdf type="{plugin}"><float name="{name}" value="0.5"/></bsdf>"#)).unwrap().warnings
    };
    for (plugin, name) in [
        ("plastic", "specular_sampling_weight"),
        ("roughplastic", "specular_sampling_weight"),
        ("principled", "clearcoat_sampling_rate"),
        ("roughconductor", "sample_visible"),
    ] {
        let warnings = parameter(plugin, name);
        assert!(warnings.len() == 1 && warnings[0].contains(&format!("`{name}`")), "{plugin}: {warnings:?}");
        assert!(warnings[0].contains("scene.xml:2: ") && warnings[0].contains("noise"), "{warnings:?}");
    }
}

#[test]
fn conductors() {
    let conductor = |eta, k| Bsdf::Conductor { eta, k, specular_reflectance: gray(1.0) };
    let mirror = conductor(Vec3::ZERO, Vec3::ONE);
    assert_eq!(bsdf("conductor", ""), mirror);
    assert_eq!(bsdf("conductor", r#"<string name="material" value="none"/>"#), mirror);
    let gold = bsdf("conductor", r#"<string name="material" value="Au"/>"#);
    assert_eq!(gold, conductor(Vec3::new(0.143036, 0.375307, 1.442045), Vec3::new(3.982997, 2.385556, 1.603359)));
    // Fits may be negative. Mitsuba uses them unchanged.
    let fitted = r#"<rgb name="eta" value="-0.05, 4.1, 4.7"/><float name="k" value="2"/>"#;
    let expected = Bsdf::RoughConductor {
        microfacets: facets(Distribution::Beckmann, 0.1, 0.1),
        eta: Vec3::new(-0.05, 4.1, 4.7),
        k: Vec3::splat(2.0),
        specular_reflectance: gray(1.0),
    };
    assert_eq!(bsdf("roughconductor", fitted), expected);
}

#[test]
fn plastics() {
    let smooth = bsdf("plastic", r#"<boolean name="nonlinear" value="true"/>"#);
    let expected = Bsdf::Plastic {
        eta: POLYPROPYLENE,
        diffuse_reflectance: gray(0.5),
        specular_reflectance: gray(1.0),
        nonlinear: true,
        weighted_base: false,
        base_weight: number(1.0),
        rough_base: false,
        base_roughness: number(0.0),
    };
    assert_eq!(smooth, expected);
    let weighted = bsdf("plastic", r#"<float name="base_weight" value="0.25"/>"#);
    let Bsdf::Plastic { weighted_base: true, base_weight, .. } = weighted else { panic!("{weighted:?}") };
    assert_eq!(base_weight, number(0.25));
    let rough =
        bsdf("plastic", r#"<float name="base_weight" value="0.25"/><float name="base_roughness" value="0.5"/>"#);
    let Bsdf::Plastic { rough_base: true, base_roughness, .. } = rough else { panic!("{rough:?}") };
    assert_eq!(base_roughness, number(0.5));
    let alone = r#"<bsdf type="pplastic"><float name="base_roughness" value="0.5"/></bsdf>"#;
    refuse(alone, &["`base_roughness` needs `base_weight`"]);
    let both =
        r#"<bsdf type="plastic"><boolean name="nonlinear" value="true"/><float name="base_weight" value="1"/></bsdf>"#;
    refuse(both, &["`nonlinear` or `base_weight`, not both"]);
    let rough = bsdf("roughplastic", r#"<float name="alphaU" value="0.2"/><float name="alphaV" value="0.2"/>"#);
    let expected = Bsdf::RoughPlastic {
        distribution: Distribution::Beckmann,
        alpha: 0.2,
        eta: POLYPROPYLENE,
        diffuse_reflectance: gray(0.5),
        specular_reflectance: gray(1.0),
        nonlinear: false,
    };
    assert_eq!(rough, expected);
}

#[test]
fn principled() {
    let parse = |parameters: &str| {
        let Bsdf::Principled(principled) = bsdf("principled", parameters) else { panic!() };
        principled
    };
    let zero = number(0.0);
    let expected = Principled {
        base_color: gray(0.5),
        roughness: number(0.5),
        anisotropic: zero,
        metallic: zero,
        spec_trans: zero,
        eta: 1.5,
        spec_tint: zero,
        sheen: zero,
        sheen_tint: zero,
        flatness: zero,
        clearcoat: zero,
        clearcoat_gloss: zero,
    };
    let default = parse("");
    assert!((default.eta - expected.eta).abs() < 1e-6);
    assert_eq!(Principled { eta: expected.eta, ..default }, expected);
    let names = ["roughness", "anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"];
    let names = names.into_iter().chain(["clearcoat", "clearcoat_gloss"]).enumerate();
    let given: String = names.map(|(i, name)| format!(r#"<float name="{name}" value="0.{i}"/>"#)).collect();
    let given = parse(&(given + r#"<float name="eta" value="1.7"/><rgb name="base_color" value="0.3"/>"#));
    let numbers = [given.roughness, given.anisotropic, given.metallic, given.spec_trans, given.spec_tint, given.sheen];
    let more = [given.sheen_tint, given.flatness, given.clearcoat, given.clearcoat_gloss];
    for (i, parsed) in numbers.into_iter().chain(more).enumerate() {
        assert_eq!(parsed, number(i as f32 / 10.0), "{i}");
    }
    assert_eq!((given.eta, given.base_color), (1.7, gray(0.3)));
    // A surface that transmits must refract.
    let specular = r#"<float name="specular" value="0"/>"#;
    assert_eq!(parse(specular).eta, 1.0);
    assert!(parse(&format!(r#"{specular}<float name="spec_trans" value="1"/>"#)).eta > 1.0);
}

const RED: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.9, 0, 0"/></bsdf>"#;
const BLUE: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0, 0, 0.9"/></bsdf>"#;

#[test]
fn masks() {
    let masked = surface(&format!(r#"<bsdf type="mask"><bsdf type="twosided">{RED}</bsdf></bsdf>"#));
    assert_eq!((masked.opacity, masked.two_sided), (number(0.5), true));
    // A number is the mean of a color.
    let masked = surface(&format!(r#"<bsdf type="mask"><rgb name="opacity" value="0.1, 0.5, 0.9"/>{RED}</bsdf>"#));
    assert!((masked.opacity.value - 0.5).abs() < 1e-6);
    let masked = surface(&format!(r#"<bsdf type="mask"><spectrum name="opacity" value="0.6"/>{RED}</bsdf>"#));
    assert!((masked.opacity.value - 0.6).abs() < 1e-6);
    let twice = surface(&format!(
        r#"<bsdf type="mask"><bsdf type="mask"><float name="opacity" value="0.4"/>{RED}</bsdf></bsdf>"#
    ));
    assert_eq!(twice.opacity, number(0.2));
}

#[test]
fn two_sides() {
    let scene = scene(&format!(r#"<bsdf type="twosided" id="a">{RED}{BLUE}</bsdf>"#));
    let sides = &scene.materials[scene.primitives[0].material as usize];
    let MaterialKind::Sides { front, back } = sides.kind else { panic!("{sides:?}") };
    for (side, color) in [(front, Vec3::new(0.9, 0.0, 0.0)), (back, Vec3::new(0.0, 0.0, 0.9))] {
        let side = surface_of(&scene.materials[side as usize]);
        assert!(side.two_sided);
        assert_eq!(side.bsdf, Bsdf::Diffuse { reflectance: Textured::constant(color) });
    }
    let twice = surface(&format!(r#"<bsdf type="twosided"><bsdf type="twosided">{RED}</bsdf></bsdf>"#));
    assert!(twice.two_sided);
}

/// Blends hand the materials around them to their parts.
#[test]
fn blends() {
    let blend = format!(r#"<bsdf type="blendbsdf"><float name="weight" value="0.3"/>{RED}{BLUE}</bsdf>"#);
    let scene = scene(&format!(r#"<bsdf type="mask"><bsdf type="twosided">{blend}</bsdf></bsdf>"#));
    let material = &scene.materials[scene.primitives[0].material as usize];
    let MaterialKind::Blend { weight, materials } = material.kind else { panic!("{material:?}") };
    assert_eq!(weight, number(0.3));
    for part in materials {
        let part = surface_of(&scene.materials[part as usize]);
        assert_eq!((part.opacity, part.two_sided), (number(0.5), true));
    }
    assert_eq!(scene.materials.len(), 3);
}

fn with_image(bsdf: &str) -> lodestar::Result<Scene> {
    let folder = Folder::new(&[("scene.xml", &with_sensor(&shape(bsdf)))]);
    image::RgbImage::from_pixel(2, 2, image::Rgb([1, 2, 3])).save(folder.path("a.png")).unwrap();
    folder.load(&[])
}

#[test]
fn reliefs() {
    let map = |name: &str| {
        format!(r#"<texture name="{name}" type="bitmap"><string name="filename" value="a.png"/></texture>"#)
    };
    let surface = |bsdf: &str| {
        let scene = with_image(bsdf).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        surface_of(&scene.materials[0]).clone()
    };
    let bump = format!(r#"<bsdf type="bumpmap">{}<float name="scale" value="3"/>{RED}</bsdf>"#, map("anything"));
    assert_eq!(surface(&bump).relief, Some(Relief::Bump { texture: 0, scale: 3.0 }));
    let inside = surface(&format!(r#"<bsdf type="twosided">{bump}</bsdf>"#));
    assert!(inside.two_sided && !inside.relief_outside);
    let normals = format!(
        r#"<bsdf type="normalmap">{}<boolean name="flip_invalid_normals" value="true"/>
           <bsdf type="twosided">{RED}</bsdf></bsdf>"#,
        map("normalmap")
    );
    let outside = surface(&normals);
    assert_eq!(outside.relief, Some(Relief::NormalMap { texture: 0 }));
    assert!(outside.two_sided && outside.relief_outside);
    let scaled = r#"<texture name="map" type="scale"><float name="scale" value="2"/>"#;
    let scaled = format!(r#"<bsdf type="bumpmap">{scaled}{}</texture>{RED}</bsdf>"#, map("any"));
    assert_eq!(surface(&scaled).relief, Some(Relief::Bump { texture: 0, scale: 2.0 }));
    let unnamed = with_image(&format!(r#"<bsdf type="normalmap">{}{RED}</bsdf>"#, map("other")));
    assert!(unnamed.unwrap_err().to_string().contains("named `normalmap`"));
    let with_rule = |rule: &str, value| {
        format!(r#"<bsdf type="bumpmap">{}<boolean name="{rule}" value="{value}"/>{RED}</bsdf>"#, map("a"))
    };
    assert_eq!(surface(&bump).relief_rules, ReliefRules { shadows: true, raises: false });
    let unshadowed = surface(&with_rule("use_shadowing_function", false)).relief_rules;
    assert_eq!(unshadowed, ReliefRules { shadows: false, raises: false });
    let raised = surface(&with_rule("raise_invalid_normals", true)).relief_rules;
    assert_eq!(raised, ReliefRules { shadows: true, raises: true });
    let mask = |inner: &str| format!(r#"<bsdf type="mask">{}{inner}</bsdf>"#, map("opacity"));
    let half = format!(r#"<bsdf type="mask">{RED}</bsdf>"#);
    assert_eq!(surface(&mask(&half)).opacity, Textured { value: 0.5, texture: Some(0) });
    assert!(with_image(&mask(&mask(RED))).unwrap_err().to_string().contains("inside another"));
    let off = with_image(&with_rule("flip_invalid_normals", false));
    assert!(off.unwrap_err().to_string().contains("`flip_invalid_normals`"));
    let twice = with_image(&format!(r#"<bsdf type="bumpmap">{}{bump}</bsdf>"#, map("b")));
    assert!(twice.unwrap_err().to_string().contains("inside another"));
}

#[test]
fn coatings() {
    let given = r#"<float name="intIOR" value="1.7"/><float name="extIOR" value="1"/><float name="thickness" value="2"/>
        <rgb name="sigmaA" value="0.1, 0.2, 0.3"/><rgb name="specularReflectance" value="0.8"/>"#;
    let coated = surface(&format!(r#"<bsdf type="twosided"><bsdf type="coating">{given}{RED}</bsdf></bsdf>"#));
    let expected =
        Coating { eta: 1.7, optical_thickness: Vec3::new(0.2, 0.4, 0.6), specular_reflectance: Vec3::splat(0.8) };
    assert_eq!(coated.coating.as_deref(), Some(&expected));
    let plain = surface(&format!(r#"<bsdf type="coating">{RED}</bsdf>"#)).coating.unwrap();
    assert_eq!((plain.eta, plain.optical_thickness), (BK7, Vec3::ZERO));
    // A coating is alike on both sides, so it does not matter which is around which.
    let outside = surface(&format!(r#"<bsdf type="coating">{given}<bsdf type="twosided">{RED}</bsdf></bsdf>"#));
    assert_eq!(outside, coated);
    refuse(r#"<bsdf type="coating"><bsdf type="dielectric"/></bsdf>"#, &["transmits light"]);
}

#[test]
fn sheens() {
    let given = r#"<rgb name="reflectance" value="0.1, 0.2, 0.3"/><float name="roughness" value="0.7"/>"#;
    let over = surface(&format!(r#"<bsdf type="twosided"><bsdf type="sheen">{given}{RED}</bsdf></bsdf>"#));
    let reflectance = Textured::constant(Vec3::new(0.1, 0.2, 0.3));
    assert_eq!(over.sheen.as_deref(), Some(&Sheen { reflectance, roughness: number(0.7) }));
    assert!(over.two_sided && over.bsdf == surface(RED).bsdf);
    let outside = surface(&format!(r#"<bsdf type="sheen">{given}<bsdf type="twosided">{RED}</bsdf></bsdf>"#));
    assert_eq!(outside, over);
    // Below the sheen alone nothing scatters.
    let alone = surface(r#"<bsdf type="sheen"/>"#);
    assert_eq!(alone.sheen.as_deref(), Some(&Sheen { reflectance: gray(1.0), roughness: number(0.5) }));
    assert_eq!(alone.bsdf, Bsdf::Diffuse { reflectance: gray(0.0) });
    // Every part of a choice has it.
    let parts = format!(
        r#"<bsdf type="sheen"><bsdf type="blendbsdf"><float name="weight" value="0.5"/>{RED}<bsdf type="dielectric"/></bsdf></bsdf>"#
    );
    let scene = scene(&parts);
    let is_covered = |material: &Material| matches!(&material.kind, MaterialKind::Surface(s) if s.sheen.is_some());
    assert_eq!(scene.materials.iter().filter(|material| is_covered(material)).count(), 2);
    for (inside, part) in [
        (r#"<bsdf type="null"/>"#, "lets light go straight on"),
        (r#"<bsdf type="thindielectric"/>"#, "lets light go straight on"),
        (r#"<bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="diffuse"/></bsdf>"#, "straight on"),
        (r#"<bsdf type="coating"><bsdf type="diffuse"/></bsdf>"#, "around a `coating`"),
        (r#"<bsdf type="sheen"/>"#, "another `sheen`"),
    ] {
        refuse(&format!(r#"<bsdf type="sheen">{inside}</bsdf>"#), &[part]);
    }
    refuse(r#"<bsdf type="coating"><bsdf type="sheen"/></bsdf>"#, &["around a `sheen`"]);
}

#[test]
fn films() {
    let given = r#"<float name="film_thickness" value="300"/><float name="film_eta" value="1.8"/>"#;
    let weighted = r#"<float name="base_weight" value="0.7"/>"#;
    for (plugin, inside) in [
        ("principled", ""),
        ("dielectric", ""),
        ("roughdielectric", ""),
        ("conductor", ""),
        ("roughconductor", ""),
        ("plastic", weighted),
        ("pplastic", weighted),
    ] {
        let film = surface(&format!(r#"<bsdf type="{plugin}">{given}{inside}</bsdf>"#)).film;
        assert_eq!(film, Some(Film { thickness: number(300.0), eta: 1.8 }), "{plugin}");
        let none = |thickness: &str| surface(&format!(r#"<bsdf type="{plugin}">{thickness}{inside}</bsdf>"#)).film;
        assert_eq!([none(""), none(r#"<float name="film_thickness" value="0"/>"#)], [None, None]);
    }
    let default = surface(r#"<bsdf type="conductor"><float name="film_thickness" value="50"/></bsdf>"#).film;
    assert_eq!(default.map(|film| film.eta), Some(1.3));
    refuse(r#"<bsdf type="conductor"><float name="film_thickness" value="-1"/></bsdf>"#, &["must not be negative"]);
    refuse(r#"<bsdf type="conductor"><float name="film_eta" value="1.5"/></bsdf>"#, &["needs `film_thickness`"]);
    refuse(&format!(r#"<bsdf type="plastic">{given}</bsdf>"#), &["needs `base_weight`"]);
    let warnings = load_body(&shape(&format!(r#"<bsdf type="diffuse">{given}</bsdf>"#))).unwrap().warnings;
    assert_eq!(warnings.len(), 2, "{warnings:?}");
}

/// A `difftrans` is a thin sheet whose light all crosses. A `twosided` of two BSDFs may have parts that transmit light.
#[test]
fn light_passes_diffusely() {
    let sheet = |inside: &str| surface(&format!(r#"<bsdf type="difftrans">{inside}</bsdf>"#));
    let color = r#"<rgb name="transmittance" value="0.2 0.4 0.8"/>"#;
    let Bsdf::PrincipledThin(thin) = sheet(color).bsdf else { panic!("a thin sheet") };
    assert_eq!((thin.base_color.value, thin.crossing.value), (Vec3::new(0.2, 0.4, 0.8), 1.0));
    let within = r#"<float name="int_ior" value="3"/><float name="ext_ior" value="2"/>"#;
    let Bsdf::PrincipledThin(thin) = sheet(within).bsdf else { panic!("a thin sheet") };
    assert_eq!(thin.base_color.value, Vec3::splat(0.5 * 2.25));
    let front = r#"<bsdf type="roughdielectric"/>"#;
    let body = format!(r#"<bsdf type="twosided">{front}<bsdf type="difftrans"/></bsdf>"#);
    let scene = load_body(&format!("<shape type=\"sphere\">{body}</shape>")).expect("a scene");
    assert!(scene.materials.iter().any(|material| matches!(material.kind, MaterialKind::Sides { .. })));
    refuse(&format!(r#"<bsdf type="twosided">{front}<bsdf type="null"/></bsdf>"#), &["transmit nothing"]);
    refuse(&format!(r#"<bsdf type="twosided">{front}<bsdf type="thindielectric"/></bsdf>"#), &["transmit nothing"]);
}

#[test]
fn what_mitsuba_refuses_is_refused() {
    refuse(r#"<bsdf type="twosided"><bsdf type="dielectric"/></bsdf>"#, &["transmit nothing"]);
    refuse(&format!(r#"<bsdf type="twosided"><bsdf type="mask">{RED}</bsdf></bsdf>"#), &["transmit nothing"]);
    let transmits = r#"<bsdf type="principled"><float name="spec_trans" value="0.5"/></bsdf>"#;
    refuse(&format!(r#"<bsdf type="twosided">{transmits}</bsdf>"#), &["transmit nothing"]);
    refuse(&format!(r#"<bsdf type="twosided">{RED}{RED}{RED}</bsdf>"#), &["exactly one"]);
    refuse(r#"<bsdf type="mask"/>"#, &["exactly one"]);
    refuse(&format!(r#"<bsdf type="bumpmap">{RED}</bsdf>"#), &["<texture>"]);
    refuse(&format!(r#"<bsdf type="blendbsdf">{RED}{BLUE}</bsdf>"#), &["`weight`"]);
    refuse(&format!(r#"<bsdf type="blendbsdf"><float name="weight" value="1"/>{RED}</bsdf>"#), &["exactly two"]);
    let conductor = |parameters: &str| format!(r#"<bsdf type="conductor">{parameters}</bsdf>"#);
    refuse(&conductor(r#"<string name="material" value="Unobtainium"/>"#), &["`Unobtainium`"]);
    refuse(&conductor(r#"<string name="material" value="Au"/><float name="eta" value="1"/>"#), &["not both"]);
    let rough = |parameters: &str| format!(r#"<bsdf type="roughconductor">{parameters}</bsdf>"#);
    refuse(&rough(r#"<float name="alpha_u" value="0.1"/>"#), &["`alpha_v`"]);
    refuse(&rough(r#"<float name="alpha" value="1"/><float name="alpha_u" value="1"/>"#), &["either `alpha`"]);
    refuse(&rough(r#"<float name="alpha" value="-1"/>"#), &["`alpha`", "negative"]);
    refuse(&rough(r#"<string name="distribution" value="phong"/>"#), &["`phong`"]);
    refuse(r#"<bsdf type="dielectric"><float name="int_ior" value="0"/></bsdf>"#, &["`int_ior`"]);
    refuse(r#"<bsdf type="dielectric"><string name="int_ior" value="jelly"/></bsdf>"#, &["`jelly`", "`diamond`"]);
    let equal = r#"<float name="int_ior" value="1"/><float name="ext_ior" value="1"/>"#;
    refuse(&format!(r#"<bsdf type="roughdielectric">{equal}</bsdf>"#), &["differ"]);
    let uneven = r#"<float name="alpha_u" value="0.1"/><float name="alpha_v" value="0.2"/>"#;
    refuse(&format!(r#"<bsdf type="roughplastic">{uneven}</bsdf>"#), &["equal"]);
    let both = r#"<float name="eta" value="1.3"/><float name="specular" value="0.3"/>"#;
    refuse(&format!(r#"<bsdf type="principled">{both}</bsdf>"#), &["not both"]);
    refuse(r#"<bsdf type="fourier"/>"#, &["`fourier`", "`roughplastic`"]);
    refuse(r#"<bsdf type="diffuse"><string name="reflectance" value="a"/></bsdf>"#, &["`reflectance`", "<string>"]);
    refuse(r#"<bsdf type="plastic"><float name="nonlinear" value="1"/></bsdf>"#, &["`nonlinear`", "<boolean>"]);
    refuse(&format!(r#"<bsdf type="diffuse">{RED}</bsdf>"#), &["<bsdf>"]);
}

/// Unused materials are read and checked, but not kept.
#[test]
fn materials_that_nobody_uses_are_read_but_not_kept() {
    let error = load_body(r#"<bsdf type="mask"/>"#).unwrap_err().to_string();
    assert!(error.contains("exactly one"), "{error}");
    let warnings = load_body(r#"<bsdf type="diffuse"><float name="glow" value="1"/></bsdf>"#).unwrap().warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("scene.xml:2: ") && warnings[0].contains("`glow`"));
    assert_eq!(load_body(RED).unwrap().materials.len(), 0);
}

/// Measured material of a file.
const MEASURED: &str = concat!(
    "<string name=\"filename\" value=\"",
    env!("CARGO_MANIFEST_DIR"),
    "/tests/data/measured/isotropic.bsdf\"/>"
);

#[test]
fn every_unknown_parameter_is_named_once() {
    let plugins = [
        ("diffuse", ""),
        ("roughdiffuse", ""),
        ("dielectric", ""),
        ("thindielectric", ""),
        ("roughdielectric", ""),
        ("conductor", ""),
        ("roughconductor", ""),
        ("plastic", ""),
        ("roughplastic", ""),
        ("principled", ""),
        ("pplastic", ""),
        ("principledthin", ""),
        ("phong", ""),
        ("ward", ""),
        ("hair", ""),
        ("measured", MEASURED),
        ("mask", RED),
        ("twosided", RED),
        ("coating", RED),
        ("sheen", RED),
        ("null", ""),
        ("mixturebsdf", r#"<string name="weights" value="0.5, 0.5"/><bsdf type="diffuse"/><bsdf type="diffuse"/>"#),
        ("blendbsdf", r#"<float name="weight" value="0.5"/><bsdf type="diffuse"/><bsdf type="diffuse"/>"#),
    ];
    for (plugin, inside) in plugins {
        let unknown = "<float name=\"wobble\" value=\"1\"/>\n<string name=\"extra\" value=\"a\"/>";
        let bsdf = format!("<bsdf type=\"{plugin}\">{unknown}{inside}</bsdf>");
        let warnings = load_body(&format!("{bsdf}<shape type=\"disk\">{bsdf}</shape>")).unwrap().warnings;
        assert_eq!(warnings.len(), 4, "{warnings:?}");
        assert!(warnings[0].contains("scene.xml:2: ") && warnings[0].contains("`wobble`"), "{warnings:?}");
        assert!(warnings[1].contains("scene.xml:3: ") && warnings[1].contains("`extra`"), "{warnings:?}");
    }
}

#[test]
fn values_out_of_range_are_clamped_with_a_warning() {
    for bsdf in [
        r#"<bsdf type="diffuse"><float name="reflectance" value="2"/></bsdf>"#,
        r#"<bsdf type="mask"><float name="opacity" value="1.5"/><bsdf type="diffuse"/></bsdf>"#,
        r#"<bsdf type="principled"><float name="sheen" value="-0.5"/></bsdf>"#,
    ] {
        let warnings = load_body(&shape(bsdf)).unwrap().warnings;
        assert!(warnings.len() == 1 && warnings[0].contains("clamped"), "{warnings:?}");
    }
}

#[test]
fn materials_that_never_end() {
    let itself = r#"<bsdf type="twosided" id="a"><ref id="a"/></bsdf>"#;
    let through =
        r#"<bsdf type="twosided" id="a"><ref id="b"/></bsdf><bsdf type="twosided" id="b"><ref id="a"/></bsdf>"#;
    for body in [itself, through] {
        let error = load_body(body).unwrap_err().to_string();
        assert!(error.contains("contains itself"), "{error}");
    }
    let mut doubling = r#"<bsdf type="diffuse" id="b0"/>"#.to_string();
    let mut chain = r#"<bsdf type="diffuse" id="t0"/>"#.to_string();
    for i in 1..100 {
        let both = format!(r#"<ref id="b{0}"/><ref id="b{0}"/>"#, i - 1);
        doubling += &format!(r#"<bsdf type="blendbsdf" id="b{i}"><float name="weight" value="0.5"/>{both}</bsdf>"#);
        chain += &format!(r#"<bsdf type="twosided" id="t{i}"><ref id="t{}"/></bsdf>"#, i - 1);
    }
    assert!(load_body(&doubling).unwrap_err().to_string().contains("surfaces"));
    // Any depth is accepted if inner materials come first. If outer ones come first, there is a bound.
    assert!(load_body(&chain).is_ok());
    let mut links: Vec<_> = chain.split_inclusive("</bsdf>").collect();
    links.reverse();
    let inward = links.concat();
    assert!(load_body(&format!(r#"<shape type="disk"><ref id="t99"/></shape>{inward}"#)).is_err());
}

#[test]
fn more_textures_than_links_are_refused() {
    let names = ["roughness", "anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"];
    let texture = |name: &&str| format!(r#"<texture name="{name}" type="checkerboard"/>"#);
    let eight: String = names.iter().map(texture).collect();
    let scene = load_body(&shape(&format!(r#"<bsdf type="principled">{eight}</bsdf>"#))).unwrap();
    assert_eq!(scene.textures.len(), 8);
    refuse(&format!(r#"<bsdf type="principled">{eight}{}</bsdf>"#, texture(&"base_color")), &["9 textured", "8"]);
}

#[test]
fn deeper_choices_than_the_kernels_follow_are_refused() {
    let nested = |depth: u32| {
        let blend = |inner: String| {
            format!(r#"<bsdf type="blendbsdf"><float name="weight" value="0.5"/><bsdf type="diffuse"/>{inner}</bsdf>"#)
        };
        (0..depth).fold(r#"<bsdf type="diffuse"/>"#.to_owned(), |inner, _| blend(inner))
    };
    // There are eight blends, eight surfaces beside them, and one innermost surface.
    assert_eq!(scene(&nested(8)).materials.len(), 17);
    refuse(&nested(9), &["more than 8 deep"]);
}
