//! Plugins that are read as something else: they give the scene of an equivalent file, or Mitsuba's own values
//! (`tests/data/reader/make.py`).

use glam::{DVec2, Mat3, Vec2, Vec3, Vec4};
use lodestar::scene::bsdf::{Distribution, Microfacets};
use lodestar::scene::texture::Pattern;
use lodestar::scene::texture_lookup::sample;
use lodestar::scene::{Bsdf, IntegratorDescription, Primitive, Scene, Textured};
use serde_json::Value;

use super::{Folder, load_body, with_sensor};

const RED: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.9, 0.1, 0.1"/></bsdf>"#;
const GLASS: &str = r#"<bsdf type="dielectric"/>"#;
const BLACK: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>"#;

fn mitsuba(part: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("../data/reader/mitsuba.json")).expect("JSON");
    all[part].as_array().expect("a list").clone()
}

fn numbers(value: &Value) -> Vec<f32> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number") as f32).collect()
}

/// All of a scene that changes its picture, as text.
fn content(scene: &Scene) -> String {
    let mut scene = scene.clone();
    scene.name.clear();
    scene.warnings.clear();
    scene.materials.iter_mut().for_each(|material| material.name.clear());
    format!("{scene:?}")
}

fn disk(bsdf: &str) -> String {
    format!(r#"<shape type="disk">{bsdf}</shape>"#)
}

#[track_caller]
fn assert_equal(body: &str, expected: &str) {
    let [body, expected] = [body, expected].map(|body| load_body(body).unwrap());
    assert_eq!(content(&body), content(&expected));
}

#[track_caller]
fn one_warning(body: &str, parts: &[&str]) -> Scene {
    let scene = load_body(body).unwrap();
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    for part in [&["scene.xml:"], parts].concat() {
        assert!(scene.warnings[0].contains(part), "`{part}` is missing in: {}", scene.warnings[0]);
    }
    scene
}

#[track_caller]
fn refuse(body: &str, parts: &[&str]) {
    let message = load_body(body).map(drop).expect_err("this should be refused").to_string();
    for part in [&["scene.xml:2: "], parts].concat() {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

#[test]
fn integrators_are_taken_for_path() {
    let read = |xml: &str, names: &str| one_warning(xml, &["integrator", names, "`path`"]).integrator;
    let open = IntegratorDescription::default();
    for plugin in ["bdpt", "photonmapper", "ptracer", "guided_path", "volpathmis", "transient_path"] {
        let xml = format!(r#"<integrator type="{plugin}"><integer name="photons" value="9"/></integrator>"#);
        assert_eq!(read(&xml, &format!("`{plugin}`")), open);
    }
    let given = r#"<integer name="maxDepth" value="7"/><integer name="rrDepth" value="3"/>
        <boolean name="hideEmitters" value="true"/>"#;
    let all = IntegratorDescription { max_depth: Some(7), rr_depth: Some(3), hide_emitters: true };
    assert_eq!(read(&format!(r#"<integrator type="bdpt">{given}</integrator>"#), "`bdpt`"), all);
    // Mitsuba's default of the differentiable integrators is 6.
    assert_eq!(read(r#"<integrator type="prb"/>"#, "of 6").max_depth, Some(6));
    let direct = r#"<integrator type="direct"><integer name="bsdf_samples" value="4"/></integrator>"#;
    let of_2 = IntegratorDescription { max_depth: Some(2), ..open };
    assert_eq!(read(direct, "of 2"), of_2);
    // One of the two samplings alone misses light in Mitsuba.
    for (none, missing) in
        [("emitter_samples", "the lights without a size"), ("bsdf_samples", "smooth mirrors and glass")]
    {
        let direct = format!(r#"<integrator type="direct"><integer name="{none}" value="0"/></integrator>"#);
        assert_eq!(read(&direct, missing), of_2);
    }
    let wrapped = format!(
        r#"<integrator type="aov"><string name="aovs" value="d:depth"/><integrator type="moment">
        <integrator type="path">{given}</integrator></integrator></integrator>"#
    );
    assert_eq!(read(&wrapped, "`aov` around `moment` around `path`"), all);
    let path = load_body(r#"<integrator type="path"/>"#).unwrap();
    assert!(path.warnings.is_empty() && path.integrator == open);
}

#[test]
fn integrators_of_other_pictures_are_refused() {
    refuse(r#"<integrator type="depth"/>"#, &["integrator plugin `depth`", "`path`"]);
    refuse(r#"<integrator type="aov"/>"#, &["`aov`", "one nested <integrator>"]);
    refuse(r#"<integrator type="aov"><integrator type="depth"/></integrator>"#, &["`depth`"]);
    let blind = r#"<integrator type="direct"><integer name="emitter_samples" value="0"/><integer name="bsdf_samples" value="0"/></integrator>"#;
    refuse(blind, &["`emitter_samples` and `bsdf_samples` of 0"]);
    refuse(r#"<integrator type="moment" id="a"><ref id="a"/></integrator>"#, &["too deep"]);
}

#[test]
fn null_is_a_mask_of_opacity_0() {
    let mask = format!(r#"<bsdf type="mask"><float name="opacity" value="0"/>{BLACK}</bsdf>"#);
    let null = r#"<bsdf type="null"/>"#;
    assert_equal(&disk(null), &disk(&mask));
    let masked = format!(r#"<bsdf type="mask"><float name="opacity" value="0.3"/>{null}</bsdf>"#);
    assert_equal(&disk(&masked), &disk(&mask));
    refuse(&disk(&format!(r#"<bsdf type="twosided">{null}</bsdf>"#)), &["transmit nothing"]);
}

#[test]
fn a_mixture_is_nested_blends() {
    let mixture = |weights: &str, parts: &str| {
        disk(&format!(r#"<bsdf type="mixturebsdf"><string name="weights" value="{weights}"/>{parts}</bsdf>"#))
    };
    let blend = |weight: &str, parts: &str| {
        format!(r#"<bsdf type="blendbsdf"><float name="weight" value="{weight}"/>{parts}</bsdf>"#)
    };
    assert_equal(&mixture("0.75, 0.25", &format!("{RED}{GLASS}")), &disk(&blend("0.25", &format!("{RED}{GLASS}"))));
    // The first two weigh 0.5, of which the second has half.
    let inner = blend("0.5", &format!("{RED}{GLASS}"));
    let three = mixture("0.25 0.25 0.5", &format!("{RED}{GLASS}{BLACK}"));
    assert_equal(&three, &disk(&blend("0.5", &format!("{inner}{BLACK}"))));
    // What the weights lack is absorbed.
    assert_equal(&mixture("0.75", RED), &disk(&blend("0.25", &format!("{RED}{BLACK}"))));
    let much = mixture("1.5, 0.5", &format!("{RED}{GLASS}"));
    assert_equal(&much, &disk(&blend("0.25", &format!("{RED}{GLASS}"))));
    one_warning(&much, &["sum is 2"]);
    refuse(&mixture("1", &format!("{RED}{GLASS}")), &["1 for 2"]);
    refuse(&mixture("-1, 2", &format!("{RED}{GLASS}")), &["negative"]);
    refuse(&disk(&format!(r#"<bsdf type="mixturebsdf">{RED}</bsdf>"#)), &["`weights`"]);
}

#[test]
fn old_names_of_materials() {
    for plugin in ["diffuse", "roughdiffuse"] {
        let bsdf = |name: &str| disk(&format!(r#"<bsdf type="{plugin}"><rgb name="{name}" value="0.1"/></bsdf>"#));
        assert_equal(&bsdf("diffuseReflectance"), &bsdf("reflectance"));
    }
    let metal = r#"<rgb name="eta" value="0.5"/><rgb name="k" value="2"/><float name="alpha" value="0.3"/>"#;
    let conductor = |plugin: &str, more: &str| disk(&format!(r#"<bsdf type="{plugin}">{metal}{more}</bsdf>"#));
    let ggx = r#"<string name="distribution" value="ggx"/>"#;
    assert_equal(&conductor("roughconductorGGX", ""), &conductor("roughconductor", ggx));
    refuse(&conductor("roughconductorGGX", ggx), &["leave `distribution` out"]);
    // Mitsuba 0.6 divides both parts of the index by the exterior's.
    let scene = load_body(&conductor("roughconductor", r#"<float name="extEta" value="2"/>"#)).unwrap();
    let lodestar::scene::MaterialKind::Surface(surface) = &scene.materials[0].kind else { panic!("no surface") };
    let alpha = Textured::constant(0.3);
    let expected = Bsdf::RoughConductor {
        microfacets: Microfacets { distribution: Distribution::Beckmann, alpha_u: alpha, alpha_v: alpha },
        eta: Vec3::splat(0.25),
        k: Vec3::splat(1.0),
        specular_reflectance: Textured::constant(Vec3::ONE),
    };
    assert_eq!(surface.bsdf, expected);
}

#[test]
fn an_area_emitter_may_stand_in_the_scene() {
    let emitter = |id: &str| format!(r#"<emitter type="area"{id}><rgb name="radiance" value="3"/></emitter>"#);
    let reference = r#"<shape type="disk"><ref id="a"/></shape>"#;
    let inside = format!(r#"<shape type="disk">{}</shape>"#, emitter(""));
    assert_equal(&format!("{}{reference}", emitter(" id=\"a\"")), &inside);
    assert_equal(&format!("{reference}{}", emitter(" id=\"a\"")), &inside);
    let unused = one_warning(&emitter(""), &["no shape refers", "dark"]);
    assert!(unused.emitters.is_empty());
}

#[test]
fn what_has_no_effect_in_the_scene_is_said() {
    one_warning(r#"<sampler type="independent"/>"#, &["<sampler>", "no effect"]);
    one_warning(r#"<integer name="samples" value="4"/>"#, &["`samples`", "ignored"]);
    let text = r#"<scene><film type="hdrfilm" id="f"><integer name="width" value="5"/></film>
        <sensor type="perspective"><ref id="f"/></sensor></scene>"#;
    let scene = Folder::new(&[("scene.xml", text)]).load(&[]).unwrap();
    assert!(scene.warnings.is_empty() && scene.film.width == 5, "{:?}", scene.warnings);
    let bsdf = RED.replace("\"diffuse\"", "\"diffuse\" id=\"a\"");
    assert_equal(
        &format!(r#"{bsdf}<alias id="a" as="b"/><shape type="disk"><ref id="b"/></shape>"#),
        &format!(r#"{bsdf}<shape type="disk"><ref id="a"/></shape>"#),
    );
    refuse(r#"<alias id="a" as="b"/>"#, &["no", "`a`"]);
}

/// Mitsuba ignores text between elements.
#[test]
fn text_between_elements() {
    let scene = load_body("<shape type=\"disk\"/>\u{200b}\u{feff}").unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    one_warning("<shape type=\"disk\"/> ...", &["scene.xml:2", "`...`", "ignored"]);
}

/// The latest `<path>` comes first, and all come before the scene's own folder, wherever they stand: as in Mitsuba.
#[test]
fn folders_are_searched_as_in_mitsuba() {
    for case in mitsuba("folders") {
        let order = case["paths"].as_str().expect("text");
        let paths: String = order.chars().map(|name| format!(r#"<path value="{name}"/>"#)).collect();
        let shape = r#"<shape type="obj"><string name="filename" value="m.obj"/></shape>"#;
        let folder = Folder::new(&[("scene.xml", &with_sensor(&format!("{shape}{paths}")))]);
        for (scale, name) in [(1, "m.obj"), (2, "a/m.obj"), (3, "b/m.obj")] {
            folder.write(name, format!("v 0 0 0\nv {scale} 0 0\nv 0 1 0\nf 1 2 3\n").as_bytes());
        }
        let scene = folder.load(&[]).unwrap();
        assert_eq!(f64::from(scene.bounds().unwrap().1.x), case["width"].as_f64().unwrap(), "{order}");
    }
    one_warning(r#"<path value="gone"/>"#, &["`gone`", "does not exist"]);
}

#[test]
fn an_include_and_a_spectrum_are_found_in_a_path() {
    let spectrum = r#"<spectrum name="reflectance" filename="s.spd"/>"#;
    let body = format!(
        r#"<path value="more"/><include filename="i.xml"/><shape type="disk"><ref id="a"/></shape>
        <bsdf type="diffuse" id="b">{spectrum}</bsdf>"#
    );
    let folder = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    folder.write("more/i.xml", format!(r#"<bsdf type="diffuse" id="a">{spectrum}</bsdf>"#).as_bytes());
    folder.write("more/s.spd", b"400 0.5\n700 0.6\n");
    assert_eq!(folder.load(&[]).unwrap().materials.len(), 1);
}

#[test]
fn spectra_are_mitsubas() {
    for case in mitsuba("spectra") {
        let xml = case["xml"].as_str().expect("text");
        let body = format!(r#"<shape type="sphere"><emitter type="area">{xml}</emitter></shape>"#);
        let scene = load_body(&body).unwrap();
        let Textured { value, texture } = scene.emitters[0].radiance;
        let factor = texture.map_or(Vec3::ONE, |texture| {
            let texture = &scene.textures[texture as usize];
            sample(texture, &scene.images, DVec2::splat(0.3)).truncate().as_vec3()
        });
        assert!((value * factor).abs_diff_eq(Vec3::from_slice(&numbers(&case["rgb"])), 1e-6), "{xml}");
    }
    let bad = r#"<bsdf type="diffuse"><spectrum type="blackbody" name="reflectance"/></bsdf>"#;
    refuse(bad, &["spectrum plugin `blackbody`"]);
}

/// In a file of version 2 or later, an axis whose length is not 1 scales the shape, as in Mitsuba 3. In an older file, it
/// is normalized, as in Mitsuba 0.6.
#[test]
fn rotations_are_those_of_the_files_version() {
    for case in mitsuba("rotations") {
        let axis = numbers(&case["axis"]);
        let angle = case["angle"].as_f64().expect("a number");
        let body = format!(
            r#"<shape type="rectangle"><transform name="to_world"><rotate x="{}" y="{}" z="{}" angle="{angle}"/>
            </transform></shape>"#,
            axis[0], axis[1], axis[2]
        );
        let expected = Mat3::from_cols_slice(&numbers(&case["rows"])).transpose();
        let scene = load_body(&body).unwrap();
        let [u, v] = [scene.primitives[0].edge_u, scene.primitives[0].edge_v];
        assert!(u.abs_diff_eq(expected.x_axis, 1e-6) && v.abs_diff_eq(expected.y_axis, 1e-6), "{case}");
        let is_unit = Vec3::from_slice(&axis).is_normalized();
        assert_eq!(scene.warnings.len(), usize::from(!is_unit), "{:?}", scene.warnings);
        let old = with_sensor(&body).replace("3.0.0", "0.6.0").replace("to_world", "toWorld");
        let old = Folder::new(&[("scene.xml", &old)]).load(&[]).unwrap();
        assert!(old.primitives[0].edge_u.is_normalized() && old.primitives[0].edge_v.is_normalized(), "{case}");
        assert_eq!(old.warnings.len(), usize::from(!is_unit), "{:?}", old.warnings);
    }
}

/// A fitted camera stands where Mitsuba 0.6 puts one, and sees the scene's whole box.
#[test]
fn a_scene_without_a_sensor_gets_a_camera() {
    let shape =
        r#"<shape type="cube"><transform name="to_world"><scale x="2" z="3"/><translate x="1"/></transform></shape>"#;
    let text = |sensor: &str| format!("<scene version=\"3.0.0\">{sensor}{shape}</scene>");
    let fitted = Folder::new(&[("scene.xml", &text(""))]).load(&[]).unwrap();
    assert!(
        fitted.warnings.len() == 1 && fitted.warnings[0].contains("looks along +z was fitted to the scene"),
        "{:?}",
        fitted.warnings
    );
    // The box spans 4, 2 and 6 units; the tangent of 22.5 degrees is 0.41421356.
    let distance = 6.0 / (2.0 * 0.414_213_56);
    let sensor = format!(
        r#"<sensor type="perspective"><float name="fov" value="45"/><float name="near_clip" value="{}"/>
        <float name="far_clip" value="{}"/><transform name="to_world"><translate x="1" z="{}"/></transform></sensor>"#,
        distance / 100.0,
        30.0 + distance,
        -3.0 - distance
    );
    let given = Folder::new(&[("scene.xml", &text(&sensor))]).load(&[]).unwrap();
    let (a, b) = (fitted.camera, given.camera);
    assert!(a.world_from_camera.abs_diff_eq(b.world_from_camera, 1e-5));
    assert!((a.near_clip - b.near_clip).abs() < 1e-6 && (a.far_clip - b.far_clip).abs() < 1e-4);
    assert_eq!((a.fov, a.fov_axis, a.projection, fitted.film), (b.fov, b.fov_axis, b.projection, given.film));
    let empty = Folder::new(&[("scene.xml", "<scene/>")]).load(&[]).unwrap_err().to_string();
    assert!(empty.contains("<sensor>"), "{empty}");
}

/// A nested object that the plugin does not know would change the picture, so it is no warning.
#[test]
fn nested_objects_that_are_not_understood_are_errors() {
    let texture = r#"<texture type="checkerboard" name="texture"/>"#;
    refuse(&format!(r#"<emitter type="point">{texture}</emitter>"#), &["<texture>", "`texture`", "`point`"]);
    refuse(&disk(&format!(r#"<bsdf type="diffuse">{texture}</bsdf>"#)), &["<texture>", "`texture`", "`diffuse`"]);
    one_warning(
        r#"<sensor type="perspective"><film type="hdrfilm"><string name="pixel_format" value="luminance"/></film></sensor>"#
            .replacen("<sensor", "<bsdf type=\"diffuse\"/>\n<sensor", 1)
            .as_str(),
        &["second <sensor>"],
    );
    let film = r#"<scene><sensor type="perspective"><film type="hdrfilm">
        <string name="pixel_format" value="luminance"/></film></sensor></scene>"#;
    let scene = Folder::new(&[("scene.xml", film)]).load(&[]).unwrap();
    assert!(scene.warnings.len() == 1 && scene.warnings[0].contains("`luminance`"), "{:?}", scene.warnings);
}

const COLORS: &str =
    r#"<texture type="mesh_attribute" name="radiance"><string name="name" value="vertex_color"/></texture>"#;

fn ply_scene(ply: &[u8], inside: &str) -> lodestar::Result<Scene> {
    let body = format!(r#"<shape type="ply"><string name="filename" value="colors.ply"/>{inside}</shape>"#);
    let folder = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    folder.write("colors.ply", ply);
    folder.load(&[])
}

/// Texture coordinates of a point of the plane z = 0 that lies in the triangle.
fn uv_at(triangle: &Primitive, at: Vec2) -> Option<DVec2> {
    let (u, v, d) = (triangle.edge_u.truncate(), triangle.edge_v.truncate(), at - triangle.origin.truncate());
    let area = u.perp_dot(v);
    let (b, c) = (d.perp_dot(v) / area, u.perp_dot(d) / area);
    let [p, q, r] = triangle.uvs.map(|uv| uv.as_dvec2());
    (b >= 0.0 && c >= 0.0 && b + c <= 1.0).then(|| p + (q - p) * f64::from(b) + (r - p) * f64::from(c))
}

#[test]
fn vertex_colors_are_mitsubas() {
    let ply = include_bytes!("../data/reader/colors.ply");
    let scene = ply_scene(ply, &format!(r#"<emitter type="area">{COLORS}</emitter>"#)).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let texture = &scene.textures[scene.emitters[0].radiance.texture.unwrap() as usize];
    for case in mitsuba("colors") {
        let at = Vec2::from_slice(&numbers(&case["at"]));
        let uv = scene.primitives.iter().find_map(|triangle| uv_at(triangle, at)).expect("a triangle");
        let color = sample(texture, &scene.images, uv).truncate().as_vec3();
        assert!(color.abs_diff_eq(Vec3::from_slice(&numbers(&case["rgb"])), 1e-5), "{case}: {color}");
    }
}

#[test]
fn vertex_colors_of_many_triangles_stay_apart() {
    let (mut vertices, mut faces) = (String::new(), String::new());
    let color = |vertex: usize| [vertex % 7, vertex % 5, vertex % 3].map(|number| number as f32 / 8.0);
    for triangle in 0..23 {
        for (corner, y) in [(0, 0), (1, 0), (2, 1)] {
            let [r, g, b] = color(3 * triangle + corner);
            vertices += &format!("{} {y} {triangle} {r} {g} {b}\n", corner % 2);
        }
        faces += &format!("3 {} {} {}\n", 3 * triangle, 3 * triangle + 1, 3 * triangle + 2);
    }
    let names: String = ["x", "y", "z", "red", "green", "blue"].map(|n| format!("property float {n}\n")).concat();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 69\n{names}element face 23\nproperty list uchar int vertex_indices\nend_header\n{vertices}{faces}"
    );
    let bsdf = format!(r#"<bsdf type="diffuse">{}</bsdf>"#, COLORS.replace("radiance", "reflectance"));
    let scene = ply_scene(ply.as_bytes(), &bsdf).unwrap();
    let lodestar::scene::MaterialKind::Surface(surface) = &scene.materials[0].kind else { panic!("no surface") };
    let Bsdf::Diffuse { reflectance } = surface.bsdf else { panic!("not diffuse") };
    let texture = &scene.textures[reflectance.texture.unwrap() as usize];
    assert!(matches!(texture.pattern, Pattern::Bitmap { .. }) && scene.primitives.len() == 23);
    for (at, triangle) in scene.primitives.iter().enumerate() {
        for corner in 0..3 {
            let found = sample(texture, &scene.images, triangle.uvs[corner].as_dvec2());
            let expected = Vec4::from((Vec3::from(color(3 * at + corner)), 1.0));
            assert!(found.as_vec4().abs_diff_eq(expected, 1e-5), "triangle {at}, corner {corner}: {found}");
        }
    }
}

/// Attributes of any name, of faces too, and of one channel.
#[test]
fn attributes_of_vertices_and_faces_color() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float heat_0\n\
               property float tint_r\nproperty float tint_g\nproperty float tint_b\nelement face 2\nproperty list uchar int vertex_indices\n\
               property float age_0\nend_header\n0 0 0 0.1 1 0 0\n1 0 0 0.2 0 1 0\n1 1 0 0.3 0 0 1\n0 1 0 0.4 0.5 0.5 0.5\n\
               3 0 1 2 0.25\n3 0 2 3 0.75\n";
    let corner = |name: &str, parameter: &str, triangle: usize, corner: usize| {
        let texture = COLORS.replace("radiance", parameter).replace("vertex_color", name);
        let bsdf = format!(r#"<bsdf type="roughconductor">{texture}</bsdf>"#);
        let scene = ply_scene(ply.as_bytes(), &bsdf).unwrap();
        sample(&scene.textures[0], &scene.images, scene.primitives[triangle].uvs[corner].as_dvec2())
            .truncate()
            .as_vec3()
    };
    for (name, triangle, at, right) in [
        ("vertex_heat", 0, 1, Vec3::splat(0.2)),
        ("vertex_heat", 1, 2, Vec3::splat(0.4)),
        ("vertex_tint_color", 0, 2, Vec3::Z),
        ("face_age", 0, 2, Vec3::splat(0.25)),
        ("face_age", 1, 0, Vec3::splat(0.75)),
    ] {
        let found = corner(name, "specular_reflectance", triangle, at);
        assert!(found.abs_diff_eq(right, 1e-6), "{name}: {found} is not {right}");
    }
    assert!(corner("vertex_heat", "alpha", 0, 0).abs_diff_eq(Vec3::splat(0.1), 1e-6));
    let refused = |textures: &str, says: &str| {
        let error = ply_scene(ply.as_bytes(), &format!(r#"<bsdf type="roughconductor">{textures}</bsdf>"#));
        let error = error.map(drop).expect_err(says).to_string();
        assert!(error.contains(says), "{error}");
    };
    let one = |parameter: &str, name: &str| COLORS.replace("radiance", parameter).replace("vertex_color", name);
    refused(&one("alpha", "vertex_cold"), "needs a `ply` with the attribute `vertex_cold`");
    refused(&one("alpha", "heat"), "the attribute `heat` should begin with `vertex_` or `face_`");
    let two = one("alpha", "vertex_heat") + &one("specular_reflectance", "face_age");
    refused(&two, "the attributes `vertex_heat` and `face_age` on one shape");
}

#[test]
fn vertex_colors_that_cannot_be_are_refused() {
    let names = |kind: &str| ["red", "green", "blue"].map(|name| format!("property {kind} {name}\n")).concat();
    let ply = |kind: &str, color: &str| {
        let vertices = format!("0 0 0 {color}\n1 0 0 {color}\n0 1 0 {color}\n");
        format!("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{}element face 1\nproperty list uchar int vertex_indices\nend_header\n{vertices}3 0 1 2\n", names(kind)).into_bytes()
    };
    let colors = COLORS.replace("radiance", "reflectance");
    let bsdf = format!(r#"<bsdf type="diffuse">{colors}</bsdf>"#);
    let says = |result: lodestar::Result<Scene>, word: &str| {
        let message = result.map(drop).expect_err("this should be refused").to_string();
        assert!(message.contains(word) && message.contains("scene.xml:2: "), "{message}");
    };
    says(ply_scene(&ply("float", "0 -1 0"), &bsdf), "negative");
    says(ply_scene(&ply("float", "0 nan 0"), &bsdf), "no number");
    // Colors that nobody shows may be anything.
    assert!(ply_scene(&ply("float", "0 nan 0"), "").is_ok());
    let other = bsdf.replace("vertex_color", "face_color");
    says(ply_scene(&ply("float", "0 0 0"), &other), "`face_color`");
    let both = format!(
        r#"<bsdf type="plastic">{}<texture type="checkerboard" name="specular_reflectance"/></bsdf>"#,
        colors.replace("name=\"reflectance\"", "name=\"diffuse_reflectance\"")
    );
    says(ply_scene(&ply("float", "0 0 0"), &both), "beside other textures");
    // What is computed from texture coordinates needs others; what is computed from directions does not.
    let computed = |source: &str| {
        let dot = format!(
            r#"<texture type="dot" name="base_weight"><texture type="{source}" name="a"/><texture type="incoming" name="b"/></texture>"#
        );
        both.replace(r#"<texture type="checkerboard" name="specular_reflectance"/>"#, &dot)
    };
    says(ply_scene(&ply("float", "0 0 0"), &computed("uv")), "beside other textures");
    let apart = ply_scene(&ply("float", "0 0 0"), &computed("shading_normal")).expect("a scene");
    assert!(apart.warnings.is_empty(), "{:?}", apart.warnings);
    refuse(&disk(&bsdf), &["`mesh_attribute`", "`ply`"]);
    let bytes = ply_scene(&ply("uchar", "255 51 0"), &bsdf).unwrap();
    assert!(bytes.warnings.len() == 1 && bytes.warnings[0].contains("whole numbers"), "{:?}", bytes.warnings);
    let texel = sample(&bytes.textures[0], &bytes.images, bytes.primitives[0].uvs[0].as_dvec2());
    assert!(texel.as_vec4().abs_diff_eq(Vec4::new(1.0, 0.2, 0.0, 1.0), 1e-6), "{texel}");
}

/// One warning says in what an old file's picture differs from that of Mitsuba 0.6.
#[test]
fn old_files_whose_picture_differs_get_one_warning() {
    let warnings = |version: &str, body: &str| {
        let text = format!("<scene version=\"{version}\"><sensor type=\"perspective\"/>\n{body}\n</scene>");
        Folder::new(&[("scene.xml", &text)]).load(&[]).unwrap().warnings
    };
    let lamp = r#"<emitter type="constant"><spectrum name="radiance" value="2"/></emitter>"#;
    let mirror = r#"<shape type="sphere"><bsdf type="conductor"/></shape>"#;
    let hidden = r#"<integrator type="path"><boolean name="hideEmitters" value="true"/></integrator>"#;
    for (body, words) in [(lamp, "tinted"), (mirror, "copper"), (hidden, "black")] {
        let found = warnings("0.6.0", body);
        assert!(found.len() == 1 && found[0].contains("scene.xml:2: ") && found[0].contains(words), "{found:?}");
        assert_eq!(warnings("3.0.0", body), [""; 0]);
    }
    let all = warnings("0.5.0", &format!("{lamp}{mirror}{mirror}{hidden}"));
    assert!(all.len() == 1 && ["tinted", "copper", "black"].iter().all(|word| all[0].contains(word)), "{all:?}");
    let same = r#"<emitter type="constant"><rgb name="radiance" value="2"/></emitter>
        <shape type="sphere"><bsdf type="conductor"><string name="material" value="Cu"/></bsdf></shape>
        <shape type="cube"><bsdf type="diffuse"><spectrum name="reflectance" value="0.5"/></bsdf></shape>"#;
    assert_eq!(warnings("0.6.0", same), [""; 0]);
}

/// Mitsuba 3 writes spectra that are plugins as textures.
#[test]
fn spectra_written_as_textures_are_spectra() {
    let texture = |plugin: &str, name: &str, entries: &str| {
        format!(r#"<texture type="{plugin}" id="s" name="{name}">{entries}</texture>"#)
    };
    let diffuse = |color: &str| format!(r#"<shape type="disk"><bsdf type="diffuse">{color}</bsdf></shape>"#);
    let lamp = |color: &str| format!(r#"<shape type="disk"><emitter type="area">{color}</emitter></shape>"#);
    let regular = r#"<float name="wavelength_min" value="400"/><float name="wavelength_max" value="700"/><string name="values" value="0.5, 0.6, 0.7"/>"#;
    let irregular =
        r#"<string name="wavelengths" value="400, 500, 700"/><string name="values" value="0.5, 0.6, 0.7"/>"#;
    for (plugin, entries, plain) in [
        ("uniform", r#"<float name="value" value="0.25"/>"#, r#"<rgb name="NAME" value="0.25"/>"#),
        ("srgb", r#"<rgb name="color" value="0.1 0.2 0.3"/>"#, r#"<rgb name="NAME" value="0.1 0.2 0.3"/>"#),
        ("d65", r#"<float name="scale" value="0.5"/>"#, r#"<rgb name="NAME" value="0.5"/>"#),
        ("regular", regular, r#"<spectrum name="NAME" value="400:0.5, 550:0.6, 700:0.7"/>"#),
        ("irregular", irregular, r#"<spectrum name="NAME" value="400:0.5, 500:0.6, 700:0.7"/>"#),
    ] {
        let written = load_body(&diffuse(&texture(plugin, "reflectance", entries))).unwrap();
        let wanted = load_body(&diffuse(&plain.replace("NAME", "reflectance"))).unwrap();
        assert_eq!(written.materials[0].kind, wanted.materials[0].kind, "{plugin}");
        let apart = texture(plugin, "any", entries) + &diffuse(r#"<ref id="s" name="reflectance"/>"#);
        let apart = load_body(&apart).unwrap();
        assert_eq!(apart.materials[0].kind, wanted.materials[0].kind, "{plugin} by its id");
        assert!(apart.warnings.iter().chain(&written.warnings).all(|warning| !warning.contains("unknown")));
        let written = load_body(&lamp(&texture(plugin, "radiance", entries))).unwrap();
        let wanted = load_body(&lamp(&plain.replace("NAME", "radiance"))).unwrap();
        assert_eq!(written.emitters[0].radiance, wanted.emitters[0].radiance, "{plugin} as light");
    }
    refuse(
        &diffuse(&texture("uniform", "reflectance", "")),
        &["spectrum plugin `uniform` needs its parameter `value`"],
    );
    let short = irregular.replace("0.5, ", "");
    refuse(&diffuse(&texture("irregular", "reflectance", &short)), &["2 values for 3 wavelengths"]);
    let flat = regular.replace("0.5, 0.6, ", "");
    refuse(&diffuse(&texture("regular", "reflectance", &flat)), &["two or more"]);
}
