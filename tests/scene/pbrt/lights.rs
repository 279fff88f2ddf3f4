//! Lights, in pbrt's units: a light of the color white has a luminance of 1.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use lodestar::image::Image;
use lodestar::image::exr::encode_rgb;
use lodestar::scene::{DeltaKind, EnvironmentKind, Scene};

use super::{assert_close, load_in, load_text, world};
use crate::Folder;

fn delta(text: &str) -> DeltaKind {
    world(text).unwrap().delta_emitters[0].kind
}

fn intensity(text: &str) -> Vec3 {
    match delta(text) {
        DeltaKind::Point { intensity, .. } | DeltaKind::Spot { intensity, .. } => intensity,
        DeltaKind::Directional { irradiance, .. } => irradiance,
        other => panic!("{other:?}"),
    }
}

fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.212671, 0.715160, 0.072169))
}

#[test]
fn points_spots_and_distant_lights() {
    let placed =
        "Translate 1 0 0 LightSource \"point\" \"rgb I\" [ 1 2 3 ] \"point3 from\" [ 0 5 0 ] \"float scale\" 2";
    let DeltaKind::Point { position, intensity } = delta(placed) else { panic!("a point") };
    assert_eq!((position, intensity), (Vec3::new(1.0, 5.0, 0.0), Vec3::new(2.0, 4.0, 6.0)));
    let distant = "LightSource \"distant\" \"point3 from\" [ 0 3 0 ] \"point3 to\" [ 0 0 0 ] \"rgb L\" [ 3 2 1 ]";
    let DeltaKind::Directional { direction, irradiance } = delta(distant) else { panic!("a distant light") };
    assert_eq!((direction, irradiance), (Vec3::NEG_Y, Vec3::new(3.0, 2.0, 1.0)));
    let spot = "LightSource \"spot\" \"point3 from\" [ 1 1 1 ] \"point3 to\" [ 1 1 -4 ] \"float coneangle\" 40 \"float conedeltaangle\" 10";
    let DeltaKind::Spot { position, direction, cutoff_angle, beam_width, .. } = delta(spot) else { panic!("a spot") };
    assert_eq!((position, direction), (Vec3::ONE, Vec3::NEG_Z));
    assert_close(&[cutoff_angle.to_degrees(), beam_width.to_degrees()], &[40.0, 30.0]);
    assert!(world(spot).unwrap().warnings.join("\n").contains("fades linearly"));
}

/// `power` is 4 pi times the intensity of a point light, and what pbrt computes for a spot. It multiplies the color.
#[test]
fn powers() {
    assert_close(&intensity("LightSource \"point\" \"float power\" 60").to_array(), &[60.0 / (4.0 * PI); 3]);
    let colored = intensity("LightSource \"point\" \"rgb I\" [ 1 0.5 0 ] \"float power\" 60 \"float scale\" 2");
    assert_close(&colored.to_array(), &[120.0 / (4.0 * PI), 60.0 / (4.0 * PI), 0.0]);
    let (start, end) = (25f32.to_radians().cos(), 30f32.to_radians().cos());
    let spot = intensity("LightSource \"spot\" \"float power\" 10");
    assert_close(&spot.to_array(), &[10.0 / (TAU * ((1.0 - start) + 0.5 * (start - end))); 3]);
    let lit = intensity("LightSource \"distant\" \"rgb L\" [ 1 1 1 ] \"float illuminance\" 7");
    assert_close(&lit.to_array(), &[7.0; 3]);
}

/// Spectra and temperatures have a luminance of 1, whatever their numbers are.
#[test]
fn spectra_are_normalized() {
    for color in [
        "\"blackbody I\" 3000",
        "\"blackbody I\" 6500",
        "\"blackbody I\" 10000",
        "\"spectrum I\" [ 300 200 900 200 ]",
        "\"spectrum I\" [ 400 1 500 3 600 5 700 2 ]",
        "\"spectrum I\" \"stdillum-A\"",
        "\"spectrum I\" \"stdillum-F11\"",
    ] {
        let found = luminance(intensity(&format!("LightSource \"point\" {color}")));
        assert!((found - 1.0).abs() < 1e-3, "{color}: {found}");
    }
    // CIE illuminant A is a black body of 2856 K.
    let (a, body) = (
        intensity("LightSource \"point\" \"spectrum I\" \"stdillum-A\""),
        intensity("LightSource \"point\" \"blackbody I\" 2856"),
    );
    assert!((a - body).length() < 0.01, "{a} is not {body}");
    let white = intensity("LightSource \"point\" \"spectrum I\" \"stdillum-D65\"");
    assert_eq!(white, Vec3::ONE);
}

#[test]
fn exposure_multiplies_all_light() {
    let text = "Film \"rgb\" \"float iso\" 400\nCamera \"perspective\" \"float shutterclose\" 0.5 WorldBegin\n\
                LightSource \"infinite\" \"rgb L\" [ 1 2 3 ]\nLightSource \"point\"\n\
                AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 2 ] Shape \"sphere\"";
    let scene = load_text(text).unwrap();
    assert_eq!(scene.emitters[0].radiance.value, Vec3::new(2.0, 2.0, 4.0));
    let EnvironmentKind::Constant { radiance } = scene.environment.unwrap().kind else { panic!("a constant") };
    assert_eq!(radiance, Vec3::new(2.0, 4.0, 6.0));
    let DeltaKind::Point { intensity, .. } = scene.delta_emitters[0].kind else { panic!("a point") };
    assert_eq!(intensity, Vec3::splat(2.0));
}

fn radiance(shape: &str) -> Vec<Vec3> {
    let scene = world(&format!("Scale 2 2 2 AreaLightSource \"diffuse\" \"float power\" 10 {shape}")).unwrap();
    scene.emitters.iter().map(|emitter| emitter.radiance.value).collect()
}

/// The radiance of a power is the power over pi times the area: of each triangle in the world, but of a sphere in its own space.
#[test]
fn powers_of_shapes() {
    let mesh = |uneven: f32| {
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 0 2 3 ] \"point3 P\" [ 0 0 0 1 0 0 1 {uneven} 0 0 1 0 ]"
        )
    };
    assert_eq!(radiance(&mesh(1.0)).len(), 1);
    assert_close(&radiance(&mesh(1.0))[0].to_array(), &[10.0 / (PI * 2.0); 3]);
    let several = radiance(&mesh(3.0));
    assert_eq!(several.len(), 2);
    assert_close(&[several[0].x, several[1].x], &[10.0 / (PI * 2.0), 10.0 / (PI * 6.0)]);
    assert_close(&[radiance("Shape \"sphere\" \"float radius\" 3")[0].x], &[10.0 / (PI * 36.0 * PI)]);
    assert_close(&[radiance("Shape \"disk\" \"float radius\" 3")[0].x], &[10.0 / (PI * 9.0 * PI)]);
    let both = world("AreaLightSource \"diffuse\" \"float power\" 10 \"bool twosided\" true Shape \"disk\"").unwrap();
    assert_close(&[both.emitters[0].radiance.value.x], &[10.0 / (PI * PI * 2.0)]);
}

/// Side to which a light's primitives face.
fn facing(scene: &Scene) -> Vec<Vec3> {
    let normal =
        |p: &lodestar::scene::Primitive| p.edge_u.cross(p.edge_v).normalize() * if p.flip_normal { -1.0 } else { 1.0 };
    scene.primitives.iter().filter(|primitive| primitive.emitter.is_some()).map(normal).collect()
}

#[test]
fn lights_of_two_sides_are_back_to_back() {
    let light = "AreaLightSource \"diffuse\" \"bool twosided\" true";
    for shape in ["Shape \"disk\"", "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 0  1 -1 0  -1 1 0  1 1 0 ]"] {
        let scene = world(&format!("{light} {shape}")).unwrap();
        for (facing, primitive) in facing(&scene).into_iter().zip(&scene.primitives) {
            assert!(facing.z.abs() > 0.999, "{facing}");
            // The back lies behind the front.
            assert!(primitive.origin.z * facing.z >= 0.0 && primitive.origin.z.abs() < 1e-3, "{primitive:?}");
        }
        let up = facing(&scene).iter().filter(|normal| normal.z > 0.0).count();
        assert_eq!(2 * up, scene.primitives.len());
        assert_eq!(scene.warnings.iter().filter(|warning| warning.contains("back to back")).count(), 1);
    }
}

/// pbrt: the order of vertices before they are transformed decides, and `ReverseOrientation` turns it over.
#[test]
fn fronts_of_lights() {
    let square = "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 0  1 -1 0  -1 1 0  1 1 0 ]";
    let normals =
        "Shape \"trianglemesh\" \"point3 P\" [ -1 -1 0  -1 1 0  1 -1 0 ] \"normal N\" [ 0 0 1  0 0 1  0 0 1 ]";
    for (before, expected) in [
        ("", Vec3::Z),
        ("ReverseOrientation", Vec3::NEG_Z),
        ("Scale -1 1 1", Vec3::Z),
        ("Scale -1 1 1 ReverseOrientation", Vec3::NEG_Z),
        ("Scale 1 1 -1", Vec3::NEG_Z),
        ("Rotate 90 1 0 0", Vec3::NEG_Y),
    ] {
        for shape in [square, normals, "Shape \"disk\""] {
            let scene = world(&format!("{before} AreaLightSource \"diffuse\" {shape}")).unwrap();
            for facing in facing(&scene) {
                assert!((facing - expected).length() < 1e-5, "{before} {shape}: {facing}");
            }
        }
    }
}

/// Spheres emit outward, also where they are mirrored, and inward where they are reversed.
#[test]
fn fronts_of_spheres() {
    let flips = |before: &str, material: &str| {
        let text = format!("{before} AreaLightSource \"diffuse\" {material} Shape \"sphere\"");
        world(&text).unwrap().primitives[0].flip_normal
    };
    let checkers = "Texture \"c\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"c\"";
    for material in ["", checkers] {
        assert!(!flips("", material) && !flips("Scale -1 1 1", material));
        assert!(flips("ReverseOrientation", material) && flips("Scale 1 -1 1 ReverseOrientation", material));
    }
}

/// A map of one bright texel lights from the direction that pbrt looks it up for.
#[test]
fn environments_are_unrolled() {
    let mut pixels = vec![[0.5f32; 3]; 64 * 64];
    // The square's center is +z, and its right corner's middle +x.
    pixels[32 * 64 + 48] = [100.0; 3];
    let folder = Folder::new(&[(
        "scene.pbrt",
        "Camera \"perspective\" WorldBegin Scale 2 2 2 Rotate 90 0 0 1 LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float scale\" 3",
    )]);
    let image = Image { width: 64, height: 64, pixels };
    folder.write("sky.exr", &encode_rgb(std::path::Path::new("sky.exr"), &image).unwrap());
    let scene = load_in(&folder).unwrap();
    let EnvironmentKind::Map { image, scale, to_world } = scene.environment.unwrap().kind else { panic!("a map") };
    assert_eq!(scale, 3.0);
    let map = &scene.images[image as usize];
    assert_eq!((map.width, map.height), (128, 65));
    let lodestar::scene::texture::Texels::Floats(texels) = &map.texels else { panic!("floats") };
    let brightest = (0..texels.len()).max_by(|&a, &b| texels[a][0].total_cmp(&texels[b][0])).unwrap();
    let (column, row) = (brightest % 128, brightest / 128);
    let (azimuth, polar) = ((column as f32 + 0.5) / 128.0 * TAU, row as f32 / 64.0 * PI);
    let direction = Vec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
    // On the square, (48.5, 32.5) / 64 is z = 1 - 0.53^2 and almost along +x; the light is turned from +x to +y.
    let found = to_world * direction;
    assert!(found.y > 0.6 && found.x.abs() < 0.1 && (found.z - 0.72).abs() < 0.1, "{found}");
    let oblong = Image { width: 64, height: 32, pixels: vec![[1.0; 3]; 64 * 32] };
    folder.write("sky.exr", &encode_rgb(std::path::Path::new("sky.exr"), &oblong).unwrap());
    let error = load_in(&folder).unwrap_err();
    assert!(error.contains("pbrt-v4's are square") && error.contains("makeequiarea"), "{error}");
}

/// `illuminance` of an infinite light: that of a surface that faces the light's +z.
#[test]
fn illuminance_of_environments() {
    let constant = world("LightSource \"infinite\" \"rgb L\" [ 1 1 1 ] \"float illuminance\" 10").unwrap();
    let EnvironmentKind::Constant { radiance } = constant.environment.unwrap().kind else { panic!("a constant") };
    assert_close(&radiance.to_array(), &[10.0 / PI; 3]);
    let folder = Folder::new(&[(
        "scene.pbrt",
        "Camera \"perspective\" WorldBegin LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float illuminance\" 10",
    )]);
    let image = Image { width: 16, height: 16, pixels: vec![[2.0; 3]; 256] };
    folder.write("sky.exr", &encode_rgb(std::path::Path::new("sky.exr"), &image).unwrap());
    let EnvironmentKind::Map { scale, .. } = load_in(&folder).unwrap().environment.unwrap().kind else {
        panic!("a map")
    };
    assert_close(&[2.0 * scale], &[10.0 / PI]);
}

/// Infinite lights add up, also a constant one and a map.
#[test]
fn infinite_lights_add_up() {
    let two =
        world("LightSource \"infinite\" \"rgb L\" [ 1 2 3 ] LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]").unwrap();
    let EnvironmentKind::Constant { radiance } = two.environment.unwrap().kind else { panic!("a constant") };
    assert_eq!(radiance, Vec3::new(2.0, 3.0, 4.0));
    let map = "LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float scale\" 2";
    let text = format!("Camera \"perspective\" WorldBegin {map} LightSource \"infinite\" \"rgb L\" [ 1 0 0 ]");
    let folder = Folder::new(&[("scene.pbrt", &text)]);
    let image = Image { width: 8, height: 8, pixels: vec![[3.0; 3]; 64] };
    folder.write("sky.exr", &encode_rgb(std::path::Path::new("sky.exr"), &image).unwrap());
    let scene = load_in(&folder).unwrap();
    let lodestar::scene::texture::Texels::Floats(texels) = &scene.images[0].texels else { panic!("floats") };
    assert_close(&texels[0][..3], &[3.5, 3.0, 3.0]);
    folder.write("scene.pbrt", text.replace("\"float scale\" 2", "\"float scale\" 0").as_bytes());
    let EnvironmentKind::Constant { radiance } = load_in(&folder).unwrap().environment.unwrap().kind else {
        panic!("a constant")
    };
    assert_eq!(radiance, Vec3::X);
    // Two maps, 3 x 2 and 3 x 5.
    let more = map.replace("\"float scale\" 2", "\"float scale\" 5");
    folder.write("scene.pbrt", format!("Camera \"perspective\" WorldBegin {map} {more}").as_bytes());
    let scene = load_in(&folder).unwrap();
    let EnvironmentKind::Map { scale, .. } = scene.environment.as_ref().unwrap().kind else { panic!("a map") };
    let lodestar::scene::texture::Texels::Floats(texels) = &scene.images[0].texels else { panic!("floats") };
    assert!(texels.iter().all(|texel| (scale * texel[0] - 21.0).abs() < 1e-3), "{scale} x {:?}", texels[0]);
    // Two maps in other places, of other sizes.
    let image = Image { width: 16, height: 16, pixels: vec![[2.0; 3]; 256] };
    folder.write("large.exr", &encode_rgb(std::path::Path::new("large.exr"), &image).unwrap());
    let more = more.replace("sky.exr", "large.exr");
    folder.write("scene.pbrt", format!("Camera \"perspective\" WorldBegin {map} Rotate 30 0 0 1 {more}").as_bytes());
    let scene = load_in(&folder).unwrap();
    let EnvironmentKind::Map { scale, .. } = scene.environment.as_ref().unwrap().kind else { panic!("a map") };
    let lodestar::scene::texture::Texels::Floats(texels) = &scene.images[0].texels else { panic!("floats") };
    assert!(texels.iter().all(|texel| (scale * texel[0] - 16.0).abs() < 1e-3), "{scale} x {:?}", texels[0]);
}

/// Intensity of a scene's spots with pictures in a direction, by the same steps as the kernels take.
fn thrown(scene: &Scene, towards: Vec3) -> Vec3 {
    let intensity = |kind: &DeltaKind| {
        let DeltaKind::PicturedSpot { direction, axes, intensity, cutoff_angle, beam_width, .. } = kind else {
            panic!("{kind:?}")
        };
        let depth = towards.dot(*direction);
        if depth <= cutoff_angle.cos() * towards.length() {
            return Vec3::ZERO;
        }
        let uv = 0.5 + glam::Vec2::new(towards.dot(axes.u), towards.dot(axes.v)) / depth;
        let texture = &scene.textures[intensity.texture.unwrap() as usize];
        let lodestar::scene::texture::Pattern::Bitmap { image, .. } = texture.pattern else { panic!("a bitmap") };
        let image = &scene.images[image as usize];
        let lodestar::scene::texture::Texels::Floats(texels) = &image.texels else { panic!("floats") };
        let at = texture.to_uv.transform_point2(uv);
        let index = |at: f32, count: u32| ((at * count as f32).floor().max(0.0) as u32).min(count - 1);
        let texel = texels[(index(at.y, image.height) * image.width + index(at.x, image.width)) as usize];
        let color = Vec3::from_slice(&texel[..3]);
        assert!(color == Vec3::ZERO || (depth / towards.length()).acos() <= *beam_width, "the picture leaves the beam");
        intensity.value * color
    };
    scene.delta_emitters.iter().map(|emitter| intensity(&emitter.kind)).sum()
}

/// Scene of a light with an image of these colors.
fn with_image(light: &str, width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Scene {
    let text = format!("Camera \"perspective\" WorldBegin {light} \"string filename\" \"a.exr\"");
    let folder = Folder::new(&[("scene.pbrt", &text)]);
    let image = Image { width, height, pixels };
    folder.write("a.exr", &encode_rgb(std::path::Path::new("a.exr"), &image).unwrap());
    load_in(&folder).unwrap()
}

/// A projection throws its image into a pyramid around `+z`: its top to `+y`, its left to `-x`, each texel as bright from all points.
#[test]
fn projections_throw_their_image() {
    let pixels: Vec<[f32; 3]> = (0..8).map(|at| [at as f32, 1.0, 0.5]).collect();
    for (light, height) in [
        ("LightSource \"projection\" \"float fov\" 60 \"float scale\" 2", 2),
        ("LightSource \"projection\" \"float fov\" 170 \"float scale\" 2", 4),
    ] {
        let scene = with_image(light, 8 / height, height, pixels.clone());
        let width = 8 / height;
        let tangent = if height == 2 { 30f32 } else { 85f32 }.to_radians().tan();
        // The angle belongs to the shorter side.
        let half =
            glam::Vec2::new((width as f32 / height as f32).max(1.0), (height as f32 / width as f32).max(1.0)) * tangent;
        for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
            let place = glam::Vec2::new((column as f32 + 0.3) / width as f32, (row as f32 + 0.6) / height as f32);
            let across = (2.0 * place - 1.0) * half * glam::Vec2::new(1.0, -1.0);
            let pixel = pixels[(row * width + column) as usize];
            let found = thrown(&scene, across.extend(1.0) * 3.0);
            assert_close(&found.to_array(), &pixel.map(|channel| 2.0 * channel));
        }
        for beyond in [glam::Vec2::new(1.01, 0.0), glam::Vec2::new(-1.01, 0.9), glam::Vec2::new(0.2, 1.01)] {
            assert_eq!(thrown(&scene, (beyond * half).extend(1.0)), Vec3::ZERO);
        }
        assert_eq!(thrown(&scene, Vec3::new(0.1, 0.1, -1.0)), Vec3::ZERO);
    }
    let mirrored = with_image("Scale -1 1 1 Rotate 90 0 1 0 LightSource \"projection\"", 4, 2, pixels.clone());
    // The light's +z is the mirrored world's -x, and its -x is the world's +z.
    let found = thrown(&mirrored, Vec3::new(-1.0, 0.4, 1.2));
    assert_close(&found.to_array(), &pixels[0]);
    // The power is the integral of the intensity.
    let powered = with_image("LightSource \"projection\" \"float fov\" 90 \"float power\" 12", 1, 1, vec![[2.0; 3]]);
    let steps = 200;
    let mut power = 0.0;
    for (x, y) in (0..steps).flat_map(|x| (0..steps).map(move |y| (x, y))) {
        let at = (glam::Vec2::new(x as f32, y as f32) + 0.5) / steps as f32 * 2.0 - 1.0;
        let direction = at.extend(1.0);
        power += thrown(&powered, direction).x * direction.length().powi(-3) * (4.0 / (steps * steps) as f32);
    }
    // pbrt takes the middle of each texel for all of it: here cos^3 of 0.
    assert!((power / 12.0 * 4.0 / (std::f32::consts::TAU / 3.0) - 1.0).abs() < 1e-3, "{power}");
}

/// A goniometric light has the intensity of its square map around `+y` in each direction, and a cone has no light elsewhere.
#[test]
fn goniometric_lights_have_the_intensity_of_their_map() {
    let side = 16;
    let pixels: Vec<[f32; 3]> =
        (0..side * side).map(|at| [1.0 + (at % side) as f32, 0.5 * (at / side) as f32, 1.0]).collect();
    let scene = with_image("LightSource \"goniometric\" \"rgb I\" [ 1 2 3 ]", side, side, pixels.clone());
    assert_eq!(scene.delta_emitters.len(), 6);
    assert!(scene.warnings.iter().any(|warning| warning.contains("read as six spots")), "{:?}", scene.warnings);
    let mut sum = 0.0;
    for at in 0..side * side {
        let pixel = pixels[at as usize];
        let mean = pixel.iter().sum::<f32>() / 3.0;
        // Beside the middle of the texel, because sides of the cube meet there, on the square from -1 to 1, whose +z is the light's +y.
        let place = (glam::DVec2::new(f64::from(at % side), f64::from(at / side)) + glam::DVec2::new(0.45, 0.52))
            / f64::from(side)
            * 2.0
            - 1.0;
        let towards = lodestar::math::equal_area::square_to_sphere(place);
        let found = thrown(&scene, Vec3::new(towards.x as f32, towards.z as f32, towards.y as f32));
        assert_close(&found.to_array(), &[mean, 2.0 * mean, 3.0 * mean]);
        sum += mean;
    }
    let mean = sum / (side * side) as f32;
    let powered = with_image("LightSource \"goniometric\" \"float power\" 7", side, side, pixels.clone());
    let found = thrown(&powered, Vec3::new(0.1, 0.9, 0.2)) / thrown(&scene, Vec3::new(0.1, 0.9, 0.2)).x;
    assert_close(&found.to_array(), &[7.0 / (4.0 * PI * mean); 3]);
    // The inner half of the square is what lies above.
    let above = |at: u32| (at % side).abs_diff(side / 2) + (at / side).abs_diff(side / 2) < side / 4 - 1;
    let narrow = (0..side * side).map(|at| if above(at) { [1.0; 3] } else { [0.0; 3] }).collect();
    assert_eq!(with_image("LightSource \"goniometric\"", side, side, narrow).delta_emitters.len(), 1);
}

/// A light whose alpha is 0 shines, and lets light pass.
#[test]
fn lights_with_an_alpha_of_0_shine() {
    let scene = world("AreaLightSource \"diffuse\" \"rgb L\" [ 1 2 3 ] Shape \"sphere\" \"float alpha\" 0").unwrap();
    assert_eq!(super::surface(&scene).opacity.value, 0.0);
    assert_eq!(scene.emitters[scene.primitives[0].emitter.unwrap() as usize].radiance.value, Vec3::new(1.0, 2.0, 3.0));
    let sentence = "a light with an `alpha` of 0 lights the scene, but is seen by the camera and in mirrors";
    assert!(scene.warnings.iter().any(|warning| warning.contains(sentence)), "{:?}", scene.warnings);
}

/// A portal helps pbrt find the light, which stays the same.
#[test]
fn portals_are_ignored_with_a_warning() {
    let scene =
        world("LightSource \"infinite\" \"rgb L\" [ 1 2 3 ] \"point3 portal\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ]").unwrap();
    let EnvironmentKind::Constant { radiance } = scene.environment.unwrap().kind else { panic!("a constant") };
    assert_eq!(radiance, Vec3::new(1.0, 2.0, 3.0));
    let sentence = "scene.pbrt:3: the `portal` of an infinite light is ignored";
    assert!(scene.warnings.iter().any(|warning| warning.contains(sentence)), "{:?}", scene.warnings);
}

#[test]
fn what_is_refused() {
    for (text, expected) in [
        ("LightSource \"goniometric\"", "the light needs its parameter \"string filename\""),
        ("LightSource \"projection\" \"string filename\" \"none.exr\"", "the image file `none.exr` does not exist"),
        ("LightSource \"projection\" \"float fov\" 180", "`fov` must lie between 0 and 180 degrees, not 180"),
        ("LightSource \"infinite\" \"string mapname\" \"sky.exr\"", "the image file `sky.exr` does not exist"),
        ("LightSource \"infinite\" \"string filename\" \"none.exr\"", "the image file `none.exr` does not exist"),
        ("LightSource \"point\" \"rgb I\" [ 1 -2 3 ]", "must not be negative"),
        ("LightSource \"point\" \"spectrum I\" [ 500 1 400 2 ]", "wavelengths that do not increase"),
        ("LightSource \"point\" \"spectrum I\" \"none\"", "the spectrum `none`, which is neither a file nor"),
        ("LightSource \"point\" \"blackbody I\" 0", "must be a temperature above 0"),
        (
            "LightSource \"point\" \"blackbody I\" [ 6000 1 ]",
            "has two numbers, but pbrt-v4 takes the temperature alone",
        ),
        ("LightSource \"distant\" \"point3 to\" [ 0 0 0 ]", "`from` and `to` of a distant light must differ"),
        ("AreaLightSource \"wrong\" Shape \"sphere\"", "the area light `wrong` is not known"),
    ] {
        let error = world(text).expect_err(expected);
        assert!(error.contains(expected) && error.contains("scene.pbrt:3: "), "{error} lacks {expected}");
    }
}
