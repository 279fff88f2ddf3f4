//! Spelling, defaults, includes, references, and the effect of every parameter.

use glam::{Mat4, Vec2, Vec3, Vec4};
use lodestar::scene::{
    Bsdf, Crop, Environment, FovAxis, Material, MaterialKind, PrimitiveShape, Projection, ReconstructionFilter,
    SurfaceMaterial, Textured,
};

use super::{Folder, load_body, with_sensor};

const OLD: &str = r#"<scene version="0.6.0">
    <integrator type="path"><integer name="maxDepth" value="9"/><integer name="rrDepth" value="4"/>
        <boolean name="hideEmitters" value="true"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="40"/><string name="fovAxis" value="smaller"/>
        <float name="nearClip" value="0.5"/><float name="farClip" value="50"/>
        <transform name="toWorld"><lookAt origin="1, 2, 3" target="4, 1, 9" up="0, 1, 0"/></transform>
        <sampler type="independent"><integer name="sampleCount" value="32"/></sampler>
        <film type="hdrfilm"><integer name="width" value="80"/><integer name="height" value="60"/>
            <string name="fileFormat" value="openexr"/><integer name="cropOffsetX" value="10"/>
            <integer name="cropWidth" value="20"/><rfilter type="tent"/></film>
    </sensor>
    <shape type="rectangle"><transform name="toWorld"><scale x="2"/><translate x="1"/></transform>
        <boolean name="flipNormals" value="true"/></shape>
</scene>"#;

const NEW: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="9"/><integer name="rr_depth" value="4"/>
        <boolean name="hide_emitters" value="true"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="40"/><string name="fov_axis" value="smaller"/>
        <float name="near_clip" value="0.5"/><float name="far_clip" value="50"/>
        <transform name="to_world"><lookat origin="1, 2, 3" target="4, 1, 9" up="0, 1, 0"/></transform>
        <sampler type="independent"><integer name="sample_count" value="32"/></sampler>
        <film type="hdrfilm"><integer name="width" value="80"/><integer name="height" value="60"/>
            <string name="file_format" value="openexr"/><integer name="crop_offset_x" value="10"/>
            <integer name="crop_width" value="20"/><rfilter type="tent"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale x="2"/><translate x="1"/></transform>
        <boolean name="flip_normals" value="true"/></shape>
</scene>"#;

#[test]
fn both_spellings_give_the_same_scene() {
    let [old, new] = [OLD, NEW].map(|text| Folder::new(&[("name.xml", text), ("scene.xml", text)]).load(&[]).unwrap());
    assert!(old.warnings.len() == 1 && old.warnings[0].contains("black"), "{:?}", old.warnings);
    assert!(new.warnings.is_empty(), "{:?}", new.warnings);
    let text = |scene: &lodestar::scene::Scene| {
        let mut scene = scene.clone();
        scene.name.clear();
        scene.warnings.clear();
        format!("{scene:?}")
    };
    assert_eq!(text(&old), text(&new));
    assert_eq!((old.integrator.max_depth, old.integrator.rr_depth, old.sample_count), (Some(9), Some(4), Some(32)));
    assert!(old.integrator.hide_emitters);
    assert_eq!(old.camera.fov_axis, FovAxis::Smaller);
    assert_eq!((old.camera.near_clip, old.camera.far_clip), (0.5, 50.0));
    assert_eq!(old.film.crop, Some(Crop { x: 10, y: 0, width: 20, height: 60 }));
    assert_eq!(old.film.filter, ReconstructionFilter::Tent { radius: 1.0 });
}

/// Camera transforms by `lookat` have Mitsuba 3.9's numbers.
#[test]
fn lookat_is_mitsubas() {
    let scene = Folder::new(&[("scene.xml", NEW)]).load(&[]).unwrap();
    let expected = Mat4::from_cols(
        Vec4::new(0.894427, 0.0, -0.447214, 0.0),
        Vec4::new(0.065938, 0.989071, 0.131876, 0.0),
        Vec4::new(0.442326, -0.147442, 0.884652, 0.0),
        Vec4::new(1.0, 2.0, 3.0, 1.0),
    );
    assert!(scene.camera.world_from_camera.abs_diff_eq(expected, 1e-5));
}

/// A focal length spans the film's diagonal. Mitsuba 3.9 prints `x_fov = 42.3117` for a 50 mm lens and a film of 200 x
/// 100.
#[test]
fn a_focal_length_spans_the_diagonal() {
    let text = r#"<scene><sensor type="perspective"><string name="focal_length" value="50mm"/></sensor></scene>"#;
    let camera = Folder::new(&[("scene.xml", text)]).load(&[]).unwrap().camera;
    let x_fov = 2.0 * camera.tan_half_fov_x(200, 100).atan().to_degrees();
    assert!((x_fov - 42.3117).abs() < 1e-3, "{x_fov}");
}

#[test]
fn sensors() {
    let camera = |plugin: &str, parameters: &str| {
        let text = format!(r#"<scene><sensor type="{plugin}">{parameters}</sensor></scene>"#);
        let scene = Folder::new(&[("scene.xml", &text)]).load(&[]).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        scene.camera
    };
    let lens = |parameters: &str| camera("thinlens", parameters).projection;
    let parameters = r#"<float name="aperture_radius" value="0.1"/><float name="focusDistance" value="5"/>"#;
    assert_eq!(lens(parameters), Projection::ThinLens { aperture_radius: 0.1, focus_distance: 5.0 });
    // Mitsuba focuses on the far plane by default.
    let parameters = r#"<float name="aperture_radius" value="0.1"/><float name="far_clip" value="70"/>"#;
    assert_eq!(lens(parameters), Projection::ThinLens { aperture_radius: 0.1, focus_distance: 70.0 });
    // A lens may be shifted, too.
    let shift =
        r#"<float name="principal_point_offset_x" value="0.25"/><float name="principal_point_offset_y" value="-0.5"/>"#;
    let lens = r#"<float name="aperture_radius" value="0.1"/>"#;
    assert_eq!(camera("thinlens", &format!("{lens}{shift}")).principal_point, Vec2::new(0.25, -0.5));
    assert_eq!(camera("perspective", shift).principal_point, Vec2::new(0.25, -0.5));
    let scaled = r#"<transform name="to_world"><scale x="3" y="2"/></transform><float name="near_clip" value="0.5"/>"#;
    let orthographic = camera("orthographic", scaled);
    assert_eq!(orthographic.projection, Projection::Orthographic);
    assert_eq!((orthographic.near_clip, orthographic.world_from_camera.x_axis.x), (0.5, 3.0));
    assert_eq!(orthographic.half_extent(200, 100), Vec2::new(1.0, 0.5));
    assert_eq!(camera("perspective", "").projection, Projection::Perspective);
    let whole = Projection::Equirectangular { longitude: [-180.0, 180.0], latitude: [-90.0, 90.0] };
    assert_eq!(camera("spherical", "").projection, whole);
    let limits = r#"<float name="longitude_min" value="10"/><float name="longitude_max" value="90"/><float name="latitude_max" value="0"/>"#;
    let part = Projection::Equirectangular { longitude: [10.0, 90.0], latitude: [-90.0, 0.0] };
    assert_eq!(camera("spherical", limits).projection, part);
    assert_eq!(camera("spherical", r#"<string name="mapping" value="equal_area"/>"#).projection, Projection::EqualArea);
}

#[test]
fn what_a_bare_sensor_leaves_open_is_mitsubas_default() {
    let scene = load_body("").unwrap();
    assert_eq!((scene.film.width, scene.film.height, scene.film.crop), (768, 576, None));
    assert_eq!(scene.film.filter, ReconstructionFilter::Gaussian { stddev: 0.5 });
    assert_eq!((scene.camera.near_clip, scene.camera.far_clip), (1e-2, 1e4));
    assert_eq!((scene.integrator.max_depth, scene.sample_count), (None, None));
    assert_eq!(scene.environment, None);
    assert_eq!(scene.bounds(), None);
}

#[test]
fn defaults_are_replaced_from_outside() {
    let text = r#"<scene>
        <default name="w" value="10"/><default name="w" value="11"/><default name="h" value="$w"/>
        <sensor type="perspective"><film type="hdrfilm">
            <integer name="width" value="$w"/><integer name="height" value="$h"/></film></sensor></scene>"#;
    let folder = Folder::new(&[("scene.xml", text)]);
    let size = |defines: &[(&str, &str)]| {
        let film = folder.load(defines).unwrap().film;
        (film.width, film.height)
    };
    assert_eq!(size(&[]), (10, 10));
    assert_eq!(size(&[("w", "7")]), (7, 7));
    assert_eq!(size(&[("w", "7"), ("h", "5")]), (7, 5));
}

#[test]
fn a_use_without_default_takes_a_define() {
    let text = with_sensor(r#"<shape type="$kind"/>"#);
    let scene = Folder::new(&[("scene.xml", &text)]).load(&[("kind", "disk")]).unwrap();
    assert_eq!(scene.primitives[0].shape, PrimitiveShape::Disk);
}

#[test]
fn includes_share_parameters_and_find_files_from_where_they_stand() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let mesh = |name: &str| format!(r#"<shape type="obj"><string name="filename" value="{name}"/></shape>"#);
    let part = format!("<scene><default name=\"file\" value=\"$top\"/>{}{}</scene>", mesh("near.obj"), mesh("$file"));
    let folder = Folder::new(&[
        ("scene.xml", &with_sensor(r#"<default name="top" value="far.obj"/><include filename="parts/a.xml"/>"#)),
        ("parts/a.xml", &part),
        ("parts/near.obj", triangle),
        ("far.obj", triangle),
    ]);
    assert_eq!(folder.load(&[]).unwrap().primitives.len(), 2);
}

#[test]
fn the_same_file_may_be_included_twice() {
    let text = with_sensor(r#"<include filename="a.xml"/><include filename="a.xml"/>"#);
    let folder = Folder::new(&[("scene.xml", &text), ("a.xml", r#"<shape type="disk"/>"#)]);
    assert_eq!(folder.load(&[]).unwrap().primitives.len(), 2);
}

fn surface(material: &Material) -> &SurfaceMaterial {
    let MaterialKind::Surface(surface) = &material.kind else { panic!("{} is no surface", material.name) };
    surface
}

fn diffuse(reflectance: Vec3) -> Bsdf {
    Bsdf::Diffuse { reflectance: Textured::constant(reflectance) }
}

#[test]
fn references_reach_forward_and_share_materials() {
    let scene = load_body(
        r#"<shape type="disk"><ref id="late"/></shape>
           <bsdf type="twosided" id="late"><ref id="inner"/></bsdf>
           <shape type="disk"><ref id="late"/></shape>
           <bsdf type="diffuse" id="inner"><rgb name="reflectance" value="0.1 0.2,0.3"/></bsdf>
           <shape type="disk"/>"#,
    )
    .unwrap();
    let [first, second, third] = [0, 1, 2].map(|i| &scene.materials[scene.primitives[i].material as usize]);
    assert_eq!(first, second);
    assert!(surface(first).two_sided && !surface(third).two_sided);
    assert_eq!(first.name, "late");
    assert_eq!(surface(first).bsdf, diffuse(Vec3::new(0.1, 0.2, 0.3)));
    assert_eq!(surface(third).bsdf, diffuse(Vec3::splat(0.5)));
}

#[test]
fn colors() {
    let reflectance = |color: &str| {
        let scene = load_body(&format!(r#"<shape type="disk"><bsdf type="diffuse">{color}</bsdf></shape>"#)).unwrap();
        let Bsdf::Diffuse { reflectance } = surface(&scene.materials[0]).bsdf else { panic!("not diffuse") };
        reflectance.value
    };
    assert_eq!(reflectance(r#"<rgb name="reflectance" value="0.25"/>"#), Vec3::splat(0.25));
    assert_eq!(reflectance(r#"<spectrum name="reflectance" value="0.25"/>"#), Vec3::splat(0.25));
    assert_eq!(reflectance(r#"<float name="reflectance" value="0.25"/>"#), Vec3::splat(0.25));
    let expected = Vec3::new(1.0, 0.215_860_5, 0.0);
    for value in ["#ff8000", "1, 0.501960784, 0"] {
        let color = reflectance(&format!(r#"<srgb name="reflectance" value="{value}"/>"#));
        assert!(color.abs_diff_eq(expected, 1e-5), "{color}");
    }
}

#[test]
fn emitters() {
    let scene = load_body(
        r#"<emitter type="constant"><rgb name="radiance" value="1, 2, 3"/></emitter>
           <shape type="cube"><emitter type="area"><rgb name="radiance" value="17, 12, 4"/></emitter></shape>
           <shape type="disk"/>"#,
    )
    .unwrap();
    assert_eq!(scene.environment, Some(Environment::constant(Vec3::new(1.0, 2.0, 3.0))));
    assert_eq!(scene.emitters.len(), 1);
    assert_eq!(scene.emitters[0].radiance, Textured::constant(Vec3::new(17.0, 12.0, 4.0)));
    assert!(scene.primitives[..6].iter().all(|primitive| primitive.emitter == Some(0)));
    assert_eq!(scene.primitives[6].emitter, None);
}

#[test]
fn what_is_not_honored_is_said() {
    let warning = |body: &str| {
        let warnings = load_body(body).unwrap().warnings;
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].contains("scene.xml:2: "), "{}", warnings[0]);
        warnings[0].clone()
    };
    assert!(warning(r#"<shape type="disk"><float name="wobble" value="1"/></shape>"#).contains("`wobble`"));
    assert!(warning(r#"<sensor type="perspective"/>"#).contains("<sensor>"));
    let clamped = warning(r#"<bsdf type="diffuse"><rgb name="reflectance" value="2"/></bsdf>"#);
    assert!(clamped.contains("`reflectance`"));
    let text = r#"<scene>
        <sensor type="perspective"><film type="hdrfilm"><rfilter type="lanczos"/></film></sensor></scene>"#;
    let scene = Folder::new(&[("scene.xml", text)]).load(&[]).unwrap();
    assert!(scene.warnings[0].contains("lanczos"));
    assert_eq!(scene.film.filter, ReconstructionFilter::Gaussian { stddev: 0.5 });
}

#[test]
fn a_scene_is_named_by_its_file_or_folder() {
    let folder = Folder::new(&[("attic/scene.xml", &with_sensor("")), ("attic/cellar.xml", &with_sensor(""))]);
    let name = |path: &str| lodestar::scene::load(&folder.path(path), &Default::default()).unwrap().name;
    assert_eq!(name("attic/scene.xml"), "attic");
    assert_eq!(name("attic/cellar.xml"), "cellar");
}
