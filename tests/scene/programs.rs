//! Textures that are computed, as Mitsuba's scenes and dictionaries write them.

use glam::{DVec3, Vec3};
use lodestar::scene::bsdf::Relief;
use lodestar::scene::program::Program;
use lodestar::scene::texture::Pattern;
use lodestar::scene::{Bsdf, MaterialKind, Scene, SurfaceMaterial};
use support::twins::hashed::fractal;
use support::twins::program::{Point, noise, run};

use super::{Folder, load_body, with_sensor};

fn of(texture: &str) -> String {
    format!(r#"<shape type="disk"><bsdf type="diffuse">{texture}</bsdf></shape>"#)
}

fn surface(scene: &Scene) -> &SurfaceMaterial {
    match &scene.materials[0].kind {
        MaterialKind::Surface(surface) => surface,
        other => panic!("{other:?}"),
    }
}

fn program(scene: &Scene, texture: Option<u32>) -> &Program {
    match &scene.textures[texture.expect("a texture") as usize].pattern {
        Pattern::Program(program) => program,
        other => panic!("{other:?}"),
    }
}

fn at(uv: [f64; 2], position: [f64; 3]) -> Point {
    Point { uv: uv.into(), position: position.into(), normal: DVec3::Z, ..Point::default() }
}

/// Reflectance at a point.
fn reflectance(texture: &str, point: Point) -> DVec3 {
    let scene = load_body(&of(texture)).unwrap_or_else(|error| panic!("{texture}: {error}"));
    assert!(scene.warnings.iter().all(|warning| !warning.contains("unknown")), "{:?}", scene.warnings);
    let Bsdf::Diffuse { reflectance } = &surface(&scene).bsdf else { panic!("diffuse") };
    assert_eq!(reflectance.value, Vec3::ONE);
    run(program(&scene, reflectance.texture), point, (&scene.textures, &scene.images))
}

#[test]
fn checkerboards_of_textures() {
    let inner = r#"<texture name="color1" type="checkerboard"><rgb name="color0" value="1 0 0"/><rgb name="color1" value="0 0 1"/>
        <transform name="to_uv"><scale x="2"/></transform></texture>"#;
    let board = format!(
        r#"<texture name="reflectance" type="checkerboard"><rgb name="color0" value="0 1 0"/>{inner}</texture>"#
    );
    for (uv, expected) in
        [([0.1, 0.1], DVec3::Y), ([0.6, 0.1], DVec3::X), ([0.8, 0.1], DVec3::Z), ([-0.1, 0.1], DVec3::Z)]
    {
        assert_eq!(reflectance(&board, at(uv, [0.0; 3])), expected, "{uv:?}");
    }
    // As in Mitsuba, the colors are exchanged where a checkerboard gives a number.
    let body = r#"<shape type="disk"><bsdf type="mask"><texture name="opacity" type="checkerboard">
        <float name="color0" value="0.25"/><texture name="color1" type="rawconstant"><float name="value" value="0.75"/></texture>
        </texture><bsdf type="diffuse"/></bsdf></shape>"#;
    let scene = load_body(body).unwrap();
    let opacity = program(&scene, surface(&scene).opacity.texture);
    assert_eq!(run(opacity, at([0.1, 0.1], [0.0; 3]), (&[], &[])), DVec3::splat(0.75));
}

#[test]
fn products_of_textures() {
    let scale = r#"<texture name="reflectance" type="scale">
        <texture name="scale" type="component"><texture name="value" type="uv"/><integer name="index" value="1"/></texture>
        <texture type="mix"><rgb name="a" value="0.5 0 0"/><rgb name="b" value="0 0 1"/>
        <texture name="weight" type="component"><texture name="value" type="uv"/></texture></texture></texture>"#;
    let found = reflectance(scale, at([0.25, 0.5], [0.0; 3]));
    assert!((found - DVec3::new(0.1875, 0.0, 0.125)).length() < 1e-6, "{found}");
}

/// Reflectances are clamped to [0, 1], numbers to what they can be; heights are not.
#[test]
fn limits() {
    let noise_of = |name: &str| {
        format!(
            r#"<texture name="{name}" type="multiply"><float name="b" value="10"/><texture name="a" type="fbm">
            <texture name="coordinates" type="transformed"><texture name="coordinates" type="position"/>
            <transform name="to_texture"><scale value="3"/></transform></texture><integer name="octaves" value="1"/></texture></texture>"#
        )
    };
    let place = [0.25, 0.4, 0.9];
    let value = 10.0 * noise(3.0 * DVec3::from(place));
    assert!(value.abs() > 1.0, "{value}");
    assert_eq!(reflectance(&noise_of("reflectance"), at([0.0; 2], place)), DVec3::splat(value.clamp(0.0, 1.0)));
    let bump = format!(
        r#"<shape type="disk"><bsdf type="bumpmap">{}<bsdf type="diffuse"/></bsdf></shape>"#,
        noise_of("heights")
    );
    let scene = load_body(&bump).unwrap();
    let Some(Relief::Bump { texture, .. }) = surface(&scene).relief else { panic!("a bump map") };
    let found = run(program(&scene, Some(texture)), at([0.0; 2], place), (&[], &[])).x;
    assert!((found - value).abs() < 1e-5, "{found} is not {value}");
}

/// A texture that is one image after all is a record as before.
#[test]
fn one_image_is_no_program() {
    let body = of(r#"<texture name="reflectance" type="multiply"><texture name="a" type="bitmap">
        <string name="filename" value="a.png"/></texture><rgb name="b" value="0.5 0.25 1"/></texture>"#);
    let folder = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    image::RgbImage::new(2, 2).save(folder.path("a.png")).unwrap();
    let scene = folder.load(&[]).unwrap();
    let Bsdf::Diffuse { reflectance } = &surface(&scene).bsdf else { panic!("diffuse") };
    assert_eq!(reflectance.value, Vec3::new(0.5, 0.25, 1.0));
    assert!(matches!(scene.textures[..], [ref one] if matches!(one.pattern, Pattern::Bitmap { .. })));
    let placed = body.replace(
        r#"value="a.png"/>"#,
        r#"value="a.png"/><texture name="coordinates" type="spherical"><texture name="coordinates" type="position"/></texture>"#,
    );
    folder.write("scene.xml", with_sensor(&placed).as_bytes());
    let scene = folder.load(&[]).unwrap();
    assert_eq!((scene.textures.len(), scene.images.len()), (2, 1));
}

#[test]
fn what_is_refused() {
    let nested =
        |plugin: &str, inside: &str| of(&format!(r#"<texture name="reflectance" type="{plugin}">{inside}</texture>"#));
    let itself = r#"<texture name="a" type="add" id="t"><ref name="a" id="t"/><float name="b" value="1"/></texture>"#;
    let too_many = "0 ".repeat(3 * 1025);
    let emission = r#"<shape type="disk"><emitter type="area"><texture name="radiance" type="fbm"/></emitter></shape>"#;
    for (body, expected) in [
        (nested("mix", itself), "contains itself, directly or through others"),
        (nested("mix", r#"<float name="a" value="1"/>"#), "`mix` needs its parameter `b`"),
        (nested("fbm", r#"<float name="roughness" value="nan"/>"#), "`nan` is not a finite number"),
        (nested("fbm", r#"<integer name="octaves" value="99"/>"#), "`octaves` must lie in 0..32, not 99"),
        (nested("noise_3d", r#"<string name="kind" value="pink"/>"#), "the kind `pink` is not known; use one of fbm,"),
        (
            nested("table", r#"<texture name="value" type="uv"/><string name="values" value="0 1"/>"#),
            "three for each of its entries",
        ),
        (
            nested("table", &format!(r#"<texture name="value" type="uv"/><string name="values" value="{too_many}"/>"#)),
            "of which there are at most 1024",
        ),
        (
            nested("table", r#"<texture name="value" type="uv"/><string name="values" value="0 nan 1"/>"#),
            "`values` of a table must be finite numbers",
        ),
        (
            nested("absolute", r#"<texture name="value" type="wood"/>"#),
            "texture plugin `wood` is not supported; use one of",
        ),
        (
            nested(
                "absolute",
                r#"<texture name="value" type="mesh_attribute"><string name="name" value="vertex_color"/></texture>"#,
            ),
            "vertex colors within a texture that is computed",
        ),
        (emission.to_owned(), "a texture that is computed cannot emit light"),
    ] {
        let error = load_body(&body).map(drop).expect_err(expected).to_string();
        assert!(error.contains(expected) && error.contains("scene.xml:"), "{error} lacks {expected}");
        assert!(!error.contains('\n'), "{error}");
    }
}

/// Inputs beyond three are numbers, constant or computed; tables are looked up.
#[test]
fn many_inputs_and_tables() {
    let noise = r#"<texture name="reflectance" type="noise_4d"><texture name="coordinates" type="position"/>
        <texture name="w" type="component"><texture name="value" type="uv"/></texture><float name="detail" value="1.5"/>
        <string name="kind" value="ridged_multifractal"/><float name="offset" value="0.9"/></texture>"#;
    let place = [0.3, -0.4, 0.7];
    let expected = fractal(3, true, &[0.3, -0.4, 0.7, 0.25], [1.5, 0.5, 2.0, 0.9, 1.0]);
    let found = reflectance(noise, at([0.25, 0.0], place));
    assert!((found - DVec3::splat(expected.clamp(0.0, 1.0))).length() < 1e-6, "{found} is not {expected}");
    let table = r#"<texture name="reflectance" type="table"><texture name="value" type="uv"/>
        <string name="values" value="0 0.1 0.2 1 0.5 0.4"/></texture>"#;
    assert!((reflectance(table, at([0.25, 0.5], [0.0; 3])) - DVec3::new(0.25, 0.3, 0.2)).length() < 1e-6);
}

/// Scene of a chain or a ladder of textures.
fn chain(length: usize, link: impl Fn(usize) -> String) -> Result<Scene, String> {
    let links: String = (1..=length).map(link).collect();
    let last = of(&format!(r#"<ref name="reflectance" id="t{length}"/>"#));
    let first = r#"<texture type="fbm" id="t0"/>"#;
    load_body(&format!("{first}{links}{last}")).map_err(|error| error.to_string())
}

/// Ladders, in which each part is used twice, are read once; equal parts are one.
#[test]
fn large_graphs_are_bounded() {
    let twice = |at: usize| {
        let before = at - 1;
        format!(
            r#"<texture type="add" id="t{at}"><ref name="a" id="t{before}"/><ref name="b" id="t{before}"/></texture>"#
        )
    };
    let scene = chain(40, twice).unwrap();
    let Bsdf::Diffuse { reflectance } = &surface(&scene).bsdf else { panic!("diffuse") };
    assert_eq!(program(&scene, reflectance.texture).instructions.len(), 41);
    let deep = chain(100_000, twice).unwrap_err();
    assert!(deep.contains("nested more than") && deep.contains("scene.xml:"), "{deep}");
    // One hundred thousand different parts, in a tree that is not deep.
    let tree = |at: usize| match at {
        1..=50_000 => format!(
            r#"<texture type="fbm" id="t{at}"><integer name="octaves" value="{}"/><float name="roughness" value="{at}"/></texture>"#,
            at % 8
        ),
        _ => {
            let (a, b) = (2 * (at - 50_000) - 1, 2 * (at - 50_000));
            format!(r#"<texture type="add" id="t{at}"><ref name="a" id="t{a}"/><ref name="b" id="t{b}"/></texture>"#)
        }
    };
    let wide = chain(99_999, tree).unwrap_err();
    assert!(wide.contains("a texture has more than") && wide.contains("parts"), "{wide}");
}
