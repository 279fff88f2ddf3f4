//! Layers for compositing, against closed forms.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;
use lodestar::encode::bvh::Bvh;
use lodestar::film::matte::identifier;
use lodestar::image::exr::{self, FileHeader};
use lodestar::image::layers::Layers;
use lodestar::layers::{Layer, Request};
use lodestar::scene::{Camera, LoadOptions, Scene, load};
use lodestar::session::Options;
use support::instances::{copied, dented_ball, transforms};

use crate::device::Device;

const SAMPLES: u32 = 256;

/// Scene that an orthographic camera sees from x = -1 to 1 and y = -0.5 to 0.5 in 16 x 8 pixels. The axis x points to the right.
fn scene(camera: &str, shapes: &str) -> Scene {
    seen_by("orthographic", camera, shapes)
}

/// Scene with a camera of a plugin.
fn seen_by(plugin: &str, camera: &str, shapes: &str) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0"><sensor type="{plugin}"><float name="shutter_open" value="0"/><float name="shutter_close"
        value="1"/>{camera}<film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="8"/><rfilter
        type="box"/></film></sensor>{shapes}</scene>"#
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, text).expect("a file");
    load(&path, &LoadOptions::default()).expect("a scene")
}

const STILL: &str = r#"<transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>"#;

/// The layers of a scene.
fn layers(device: &Device, scene: &Scene, wanted: &[Layer]) -> (Layers, FileHeader) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("layers.exr");
    write(device, scene, wanted, &path);
    exr::read_layers(&path).expect("layers")
}

fn write(device: &Device, scene: &Scene, layers: &[Layer], path: &Path) {
    let settings = Options::new().settings_for(scene).expect("settings");
    let bvh = Bvh::of_scene(scene);
    let context = device.context();
    let request = Request { context, scene, bvh: &bvh, settings: &settings, samples: SAMPLES, layers };
    let notes = request.write(path, &[], &mut |_| {}).expect("layers");
    assert_eq!(notes, [""; 0]);
}

fn floats<'a>(layers: &'a Layers, name: &str) -> &'a [f32] {
    layers.floats(name).unwrap_or_else(|| panic!("{name}"))
}

/// Shares of a pixel by name, as the file's numbers and names give them.
fn shares(layers: &Layers, header: &FileHeader, layer: &str, pixel: usize) -> HashMap<String, f32> {
    let attribute = |end: &str, value: Option<&str>| {
        let mut found = header.foreign.iter().filter(|(name, text)| {
            name.starts_with("cryptomatte/") && name.ends_with(end) && value.is_none_or(|value| value == text)
        });
        found.next().cloned()
    };
    let (key, _) = attribute("/name", Some(layer)).expect("a name");
    let manifest = key.replace("/name", "/manifest");
    let (_, manifest) = attribute(&manifest, None).expect("a manifest");
    let names: HashMap<String, String> = serde_json::from_str(&manifest).expect("JSON");
    let mut shares = HashMap::new();
    for rank in 0..6 {
        let [id, share] = [["R", "B"][rank % 2], ["G", "A"][rank % 2]]
            .map(|channel| floats(layers, &format!("{layer}{:02}.{channel}", rank / 2))[pixel]);
        let hex = format!("{:08x}", id.to_bits());
        if share > 0.0 {
            let (name, _) = names.iter().find(|(_, hash)| **hash == hex).expect("an object of the manifest");
            assert_eq!(id.to_bits(), identifier(name).to_bits());
            assert_eq!(shares.insert(name.clone(), share), None, "{name} has two shares");
        }
    }
    shares
}

/// Positions and coordinates of a tilted rectangle are linear. Nothing moves.
#[test]
fn positions_and_coordinates() {
    let device = Device::validated();
    let tilted = r#"<shape type="rectangle"><transform name="to_world"><scale x="0.75"/><rotate y="1" angle="60"/></transform></shape>"#;
    let (found, _) = layers(&device, &scene(STILL, tilted), &Layer::ALL);
    for y in 0..8 {
        for x in 0..16 {
            let pixel = 16 * y + x;
            let at = |name: &str| floats(&found, name)[pixel];
            let [across, up] = [(x as f32 + 0.5) / 8.0 - 1.0, 0.5 - (y as f32 + 0.5) / 8.0];
            // The rectangle is 0.75 wide, as the camera sees it.
            let is_hit = across.abs() < 0.375;
            let expected = if is_hit { [across, up, -across * 3.0_f32.sqrt()] } else { [0.0; 3] };
            let uv = if is_hit { [0.5 + across / 0.75, 0.5 + up / 2.0] } else { [0.0; 2] };
            let position = ["position.X", "position.Y", "position.Z"].map(at);
            for (found, expected) in position.iter().zip(expected).chain(["uv.U", "uv.V"].map(at).iter().zip(uv)) {
                assert!((found - expected).abs() < 0.01, "{x}, {y}: {position:?}");
            }
            assert_eq!(["motion.X", "motion.Y"].map(at), [0.0; 2]);
        }
    }
}

/// Shapes that move or turn go a known way over the picture, and so does all that a moving camera sees.
#[test]
fn motion_over_the_picture() {
    let device = Device::validated();
    let moving = |shape: &str, end: &str| {
        format!(
            r#"<shape type="{shape}"><animation name="to_world"><transform time="0"/><transform time="1">{end}</transform>
            </animation></shape>"#
        )
    };
    let at = |camera: &str, shapes: &str, pixel: usize| {
        let (found, _) = layers(&device, &scene(camera, shapes), &[Layer::Motion]);
        ["motion.X", "motion.Y"].map(|name| floats(&found, name)[pixel])
    };
    let near = |found: [f32; 2], expected: [f32; 2], tolerance: f32| {
        let differs = found.iter().zip(expected).any(|(found, expected)| (found - expected).abs() > tolerance);
        assert!(!differs, "{found:?} is not {expected:?}");
    };
    let center = 16 * 4 + 8;
    let way = r#"<translate x="0.25" y="-0.125"/>"#;
    for shape in ["rectangle", "sphere", "cube"] {
        // 8 pixels are as long as one unit.
        near(at(STILL, &moving(shape, way), center), [2.0, -1.0], 1.0e-3);
    }
    let camera = r#"<animation name="to_world"><transform time="0"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
        <transform time="1"><lookat origin="0.25,-0.125,5" target="0.25,-0.125,0" up="0,1,0"/></transform></animation>"#;
    near(at(camera, r#"<shape type="rectangle"/>"#, center), [-2.0, 1.0], 1.0e-3);
    // A point at (x, y) of a square that is turned goes to (x c - y s, x s + y c) around the center, wherever it is met on its way. The
    // pixel's mean is that of the points which the square shows there at all times.
    let turned = at(STILL, &moving("rectangle", r#"<rotate z="1" angle="10"/>"#), 16 * 4 + 12);
    let (s, c) = 10.0_f32.to_radians().sin_cos();
    let mut expected = [0.0; 2];
    for i in 0..1000 {
        let (s0, c0) = (-(i as f32 + 0.5) / 100.0).to_radians().sin_cos();
        let [x, y] = [0.5625, -0.0625];
        let [x, y] = [x * c0 - y * s0, x * s0 + y * c0];
        expected = [expected[0] + 8.0 * (x * c - y * s - x) / 1000.0, expected[1] + 8.0 * (x * s + y * c - y) / 1000.0];
    }
    near(turned, expected, 0.05);
    // The points of a ball go with it where it turns about its axis.
    let ball = at(STILL, &moving("sphere", r#"<rotate y="1" angle="3"/>"#), center);
    near(ball, [8.0 * 3.0_f32.to_radians(), 0.0], 0.01);
}

/// A mask of opacity 0.25 shows a quarter of itself, and what is behind it. Shapes whose ids differ behind `#` are one object, and an
/// instance with an id is one.
#[test]
fn mattes() {
    let device = Device::validated();
    let shapes = r##"
        <bsdf type="mask" id="veil"><float name="opacity" value="0.25"/><bsdf type="diffuse"/></bsdf>
        <bsdf type="diffuse" id="wall#1"/>
        <shape type="rectangle" id="front"><ref id="veil"/></shape>
        <shape type="rectangle" id="back#1"><ref id="wall#1"/><transform name="to_world"><scale x="0.5"/><translate x="-0.5"
        z="-1"/></transform></shape>
        <shape type="rectangle" id="back#2"><ref id="wall#1"/><transform name="to_world"><scale x="0.5"/><translate x="0.5"
        z="-1"/></transform></shape>
        <shape type="shapegroup" id="group"><shape type="sphere" id="ball"/></shape>
        <shape type="instance" id="shown"><ref id="group"/><transform name="to_world"><scale value="0.3"/><translate z="2"/>
        </transform></shape>
        <shape type="instance"><ref id="group"/><transform name="to_world"><scale value="0.1"/><translate x="0.9375" z="2"/>
        </transform></shape>"##;
    let (found, header) = layers(&device, &scene(STILL, shapes), &[Layer::Objects, Layer::Materials]);
    let at = |layer: &str, x: usize| shares(&found, &header, layer, 16 * 4 + x);
    let [edge, objects, materials] = [at("CryptoObject", 15), at("CryptoObject", 2), at("CryptoMaterial", 2)];
    assert_eq!(at("CryptoObject", 8), HashMap::from([("shown".to_owned(), 1.0)]));
    assert!(edge.contains_key("ball") && edge.len() == 3, "{edge:?}");
    // Five standard deviations of 256 samples.
    for (shares, front, behind) in [(&objects, "front", "back"), (&materials, "veil", "wall")] {
        assert!((shares[front] - 0.25).abs() < 0.14, "{shares:?}");
        assert_eq!(shares[front] + shares[behind], 1.0, "{shares:?}");
        assert_eq!(shares.len(), 2, "{shares:?}");
    }
    // The seam between both parts lies in one object.
    assert_eq!(at("CryptoObject", 3).len(), 2);
}

/// Instances show the points that their copies show, however they are placed.
#[test]
fn instances_show_what_copies_show() {
    let device = Device::validated();
    let of = |scene: &Scene| layers(&device, scene, &[Layer::Position, Layer::Uv, Layer::Objects]).0;
    for (what, transform) in transforms() {
        let mut scene = dented_ball();
        scene.camera = Camera::look_at([0.5, 0.4, 6.0], [0.0; 3], 40.0);
        let group = scene.group_from(0);
        scene.add_instance(group, &transform);
        let [shown, copies] = [of(&scene), of(&copied(&scene))];
        let values = |name: &str| floats(&shown, name).iter().zip(floats(&copies, name)).collect::<Vec<_>>();
        let [shares, positions] = [values("CryptoObject00.G"), values("position.Z")];
        assert!(shares.iter().filter(|(share, _)| **share > 0.0).count() > 20, "{what}");
        assert!(shares.iter().all(|(a, b)| (*a - *b).abs() < 0.01), "{what}");
        // At an edge, one of both may have a sample that the other has not.
        let near = positions.iter().zip(&shares).filter(|(_, (share, _))| **share == 1.0);
        assert!(near.clone().count() > 10, "{what}");
        assert!(near.clone().all(|((a, b), _)| (*a - *b).abs() < 1.0e-3), "{what}");
    }
}

/// Each pixel of a panorama looks in its direction. A ball around the camera shows them.
#[test]
fn panoramas_look_all_around() {
    let device = Device::validated();
    let ball = r#"<shape type="sphere"><float name="radius" value="10"/></shape>"#;
    let [w, h] = [16, 8];
    let whole = |x: f64, y: f64| [std::f64::consts::TAU * (x - 0.5), std::f64::consts::PI * (0.5 - y)];
    let part = |x: f64, y: f64| [(10.0 + 80.0 * x).to_radians(), (40.0 - 60.0 * y).to_radians()];
    let limits = r#"<float name="longitude_min" value="10"/><float name="longitude_max" value="90"/><float name="latitude_min"
        value="-20"/><float name="latitude_max" value="40"/>"#;
    type Angles<'a> = &'a dyn Fn(f64, f64) -> [f64; 2];
    for (limits, angles) in [("", &whole as Angles), (limits, &part)] {
        let scene = panorama(limits, ball);
        let (found, header) = layers(&device, &scene, &[Layer::Position, Layer::Motion]);
        assert_eq!(header.film_from_world, None);
        for (pixel, (x, y)) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).enumerate() {
            let at = |name: &str| f64::from(floats(&found, name)[pixel]);
            // Means of a pixel's directions lie a little within the ball.
            let position = DVec3::new(at("position.X"), at("position.Y"), at("position.Z")).normalize();
            let [longitude, latitude] = angles((x as f64 + 0.5) / w as f64, (y as f64 + 0.5) / h as f64);
            // The camera looks along -z, with x to the right.
            let [(s, c), (up, flat)] = [longitude, latitude].map(f64::sin_cos);
            let expected = DVec3::new(s * flat, up, -c * flat);
            assert!(position.distance(expected) < 0.03, "{x}, {y}: {position} is not {expected}");
            assert_eq!([at("motion.X"), at("motion.Y")], [0.0; 2]);
        }
    }
    // The middle of pbrt's square is up, the middles of its sides are the horizon, and its corners are down.
    let (found, _) =
        layers(&device, &panorama(r#"<string name="mapping" value="equal_area"/>"#, ball), &[Layer::Position]);
    let at = |x: usize, y: usize| {
        let position = ["position.X", "position.Y", "position.Z"].map(|name| floats(&found, name)[w * y + x]);
        DVec3::from(position.map(f64::from)).normalize()
    };
    let near = |found: DVec3, expected: DVec3| assert!(found.distance(expected) < 0.35, "{found} is not {expected}");
    near(at(7, 3), DVec3::Y);
    near(at(0, 0), DVec3::NEG_Y);
    near(at(15, 3), DVec3::X);
    near(at(7, 7), DVec3::NEG_Z);
    near(at(7, 0), DVec3::Z);
}

/// Shapes that turn are followed over the whole panorama, also over its sides.
#[test]
fn motion_over_a_panorama() {
    let device = Device::validated();
    let turning = |angle: f64| {
        format!(
            r#"<shape type="sphere"><animation name="to_world"><transform time="0"><scale value="10"/></transform><transform time="1">
            <scale value="10"/><rotate y="1" angle="{angle}"/></transform></animation></shape>"#
        )
    };
    let (found, _) = layers(&device, &panorama("", &turning(-9.0)), &[Layer::Motion]);
    // Clockwise from above, which is to the right: 9 of 360 degrees are 0.4 of 16 pixels.
    let [x, y] = ["motion.X", "motion.Y"].map(|name| floats(&found, name));
    assert!(x.iter().all(|x| (x - 0.4).abs() < 1.0e-3), "{x:?}");
    assert!(y.iter().all(|y| y.abs() < 1.0e-3), "{y:?}");
}

/// Scene around a panorama at the origin that looks along -z.
fn panorama(parameters: &str, shapes: &str) -> Scene {
    let place = r#"<transform name="to_world"><lookat origin="0,0,0" target="0,0,-1" up="0,1,0"/></transform>"#;
    seen_by("spherical", &format!("{place}{parameters}"), shapes)
}
