//! Surfaces of glTF models: alpha, which covers the emission too, the alpha of vertex colors, and directions of normal maps.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::DVec2;
use lodestar::scene::bsdf::Relief;
use lodestar::scene::texture_lookup::sample;
use lodestar::scene::{MaterialKind, Scene, SurfaceMaterial};
use serde_json::{Value, json};

use crate::gltf::{png_uri, push, read, square};

fn surface(scene: &Scene, material: usize) -> &SurfaceMaterial {
    let MaterialKind::Surface(surface) = &scene.materials[material].kind else { panic!("a surface") };
    surface
}

/// Red of the emission, and the opacity, in the middle of a square with that material; no emission is `None`.
fn emission_and_opacity(material: &Value, images: &[[u8; 4]]) -> (Option<f64>, f64) {
    let mut model = square();
    model["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_texture_transform"]);
    model["images"] = images.iter().map(|texel| json!({"uri": png_uri(*texel)})).collect();
    model["textures"] = (0..images.len()).map(|index| json!({"source": index})).collect();
    model["materials"][0] = material.clone();
    let scene = read(&model).unwrap();
    let lookup = |texture: Option<u32>| {
        texture.map_or(1.0, |texture| sample(&scene.textures[texture as usize], &scene.images, DVec2::splat(0.5)).x)
    };
    let radiance = scene.emitters.first().map(|emitter| emitter.radiance);
    let opacity = surface(&scene, 0).opacity;
    let red = radiance.map(|radiance| f64::from(radiance.value.x) * lookup(radiance.texture));
    (red, f64::from(opacity.value) * lookup(opacity.texture))
}

#[track_caller]
fn assert_close(found: (Option<f64>, f64), expected: (Option<f64>, f64)) {
    let close = |a: f64, b: f64| (a - b).abs() < 2.0e-3;
    let emits = match (found.0, expected.0) {
        (Some(a), Some(b)) => close(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    assert!(emits && close(found.1, expected.1), "{found:?} is not {expected:?}");
}

/// Holes do not shine, and a surface of alpha 0.25 shines by a quarter.
#[test]
fn alpha_covers_the_emission() {
    let unlit = |mode: &str, base: Value| json!({"alphaMode": mode, "pbrMetallicRoughness": base, "extensions": {"KHR_materials_unlit": {}}});
    let factor = |alpha: f32| json!({"baseColorFactor": [1.0, 1.0, 1.0, alpha]});
    let texture = json!({"baseColorTexture": {"index": 0}});
    for (material, images, expected) in [
        (unlit("MASK", factor(0.0)), [255; 4], (None, 0.0)),
        (unlit("MASK", factor(0.6)), [255; 4], (Some(1.0), 1.0)),
        (unlit("BLEND", factor(0.25)), [255; 4], (Some(0.25), 0.25)),
        (unlit("OPAQUE", factor(0.25)), [255; 4], (Some(1.0), 1.0)),
        (unlit("BLEND", texture.clone()), [255, 255, 255, 51], (Some(0.2), 0.2)),
        (unlit("MASK", texture.clone()), [255, 255, 255, 51], (Some(0.0), 0.0)),
    ] {
        assert_close(emission_and_opacity(&material, &[images]), expected);
    }
    let lit = |emission: Value| {
        let mut material =
            json!({"alphaMode": "BLEND", "pbrMetallicRoughness": texture, "emissiveFactor": [0.5, 0.5, 0.5]});
        material.as_object_mut().unwrap().extend(emission.as_object().unwrap().clone());
        material
    };
    let images = [[0, 0, 0, 102], [188, 188, 188, 255]];
    let half = lodestar::math::srgb::linear_from_srgb(188.0 / 255.0);
    assert_close(emission_and_opacity(&lit(json!({})), &images), (Some(0.5 * 0.4), 0.4));
    let textured = lit(json!({"emissiveTexture": {"index": 1}}));
    assert_close(emission_and_opacity(&textured, &images), (Some(0.5 * half * 0.4), 0.4));
    // Two images that lie differently on the surface.
    let moved = json!({"index": 1, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}});
    assert_close(emission_and_opacity(&lit(json!({"emissiveTexture": moved})), &images), (Some(0.5 * half), 0.4));
}

/// Gives the square's vertices an attribute of four numbers each.
fn with_attribute(name: &str, elements: [[f32; 4]; 4]) -> Value {
    let mut model = square();
    let bytes: Vec<u8> = elements.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes));
    push(&mut model["buffers"], json!({"byteLength": 64, "uri": uri}));
    push(&mut model["bufferViews"], json!({"buffer": 1, "byteLength": 64}));
    push(&mut model["accessors"], json!({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4"}));
    model["meshes"][0]["primitives"][0]["attributes"][name] = json!(3);
    model
}

#[test]
fn the_alpha_of_vertex_colors_counts() {
    let read = |elements: [[f32; 4]; 4], mode: &str| {
        let mut model = with_attribute("COLOR_0", elements);
        model["materials"][0]["alphaMode"] = json!(mode);
        let scene = read(&model).unwrap();
        let warnings = scene.warnings.join("\n");
        (surface(&scene, 0).opacity.value, warnings)
    };
    let even = [[0.0, 0.0, 0.0, 0.25]; 4];
    assert_eq!(read(even, "BLEND").0, 0.25);
    assert_eq!(read(even, "MASK").0, 0.0);
    assert_eq!(read(even, "OPAQUE").0, 1.0);
    let (mean, warnings) = read([[0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4], [0.0; 4]], "BLEND");
    assert_eq!(mean, 0.25);
    assert!(warnings.contains("the alpha of its vertices varies; its mean of 0.250 is used"), "{warnings}");
}

/// Normals of the square's normal map on its materials, in the local frame, whose x-axis is the direction of u.
fn normals(model: &mut Value) -> Vec<[f64; 2]> {
    model["images"] = json!([{"uri": png_uri([204, 179, 230, 255])}]);
    model["textures"] = json!([{"source": 0}]);
    model["materials"][0]["normalTexture"] = json!({"index": 0});
    let scene = read(model).unwrap();
    let normal = |material: usize| {
        let Some(Relief::NormalMap { texture }) = surface(&scene, material).relief else { panic!("a normal map") };
        let color = sample(&scene.textures[texture as usize], &scene.images, DVec2::splat(0.5));
        [color.x, color.y].map(|channel| ((2.0 * channel - 1.0) * 100.0).round() / 100.0)
    };
    let shown = |material: &usize| scene.primitives.iter().any(|primitive| primitive.material as usize == *material);
    (0..scene.materials.len()).filter(shown).map(normal).collect()
}

/// Relief does not turn over where texture coordinates are mirrored, where a node is, or where TANGENT says so.
#[test]
fn normal_maps_follow_mirrored_coordinates() {
    let (upright, turned) = ([0.6, 0.4], [0.6, -0.4]);
    assert_eq!(normals(&mut square()), [upright]);
    let mut mirrored = square();
    mirrored["materials"][0]["normalTexture"] = json!({});
    mirrored["nodes"][0]["scale"] = json!([-1, 1, 1]);
    assert_eq!(normals(&mut mirrored), [turned]);
    // One triangle of the square is mirrored, and the other is not.
    let mut half = square();
    let uvs = [[0.0f32, 1.0], [1.0, 1.0], [1.0, 0.0], [2.0, 1.0]];
    let bytes: Vec<u8> = uvs.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes));
    push(&mut half["buffers"], json!({"byteLength": 32, "uri": uri}));
    half["bufferViews"][1] = json!({"buffer": 1, "byteLength": 32});
    assert_eq!(normals(&mut half), [upright, turned]);
    // Tangents along u with the two hands, and tangents against u.
    for (tangent, expected) in [
        ([1.0, 0.0, 0.0, 1.0], upright),
        ([1.0, 0.0, 0.0, -1.0], turned),
        ([-1.0, 0.0, 0.0, 1.0], [-0.6, -0.4]),
        ([-1.0, 0.0, 0.0, -1.0], [-0.6, 0.4]),
    ] {
        assert_eq!(normals(&mut with_attribute("TANGENT", [tangent; 4])), [expected], "{tangent:?}");
    }
}

/// A body that light enters absorbs it: what remains after the attenuation distance has the attenuation color.
#[test]
fn bodies_absorb() {
    let read_with = |extensions: Value| {
        let mut model = square();
        model["extensionsUsed"] =
            json!(["KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_diffuse_transmission"]);
        model["materials"][0] = json!({"extensions": extensions});
        read(&model).unwrap()
    };
    let volume = |thickness: f32, distance: f32| json!({"thicknessFactor": thickness, "attenuationDistance": distance, "attenuationColor": [0.5, 1.0, 0.25]});
    let body = |volume: Value| {
        read_with(json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume}))
    };
    let scene = body(volume(1.0, 2.0));
    let medium = &scene.media.all[0];
    let expected = [0.5_f32, 1.0, 0.25].map(|channel| -channel.ln() / 2.0);
    assert!((medium.extinction - glam::Vec3::from(expected)).length() < 1e-6, "{medium:?}");
    assert_eq!(medium.albedo, glam::Vec3::ZERO);
    assert!(scene.materials.iter().any(|material| material.boundary.is_some_and(|sides| sides.interior == Some(0))));
    assert!(body(volume(0.0, 2.0)).media.all.is_empty() && body(json!({"thicknessFactor": 1})).media.all.is_empty());
    // What is metal lets no light through.
    for (metal, expected) in [(0.0, 0.3), (0.75, 0.075)] {
        let mut model = square();
        model["extensionsUsed"] = json!(["KHR_materials_diffuse_transmission"]);
        model["materials"][0] = json!({
            "pbrMetallicRoughness": {"metallicFactor": metal},
            "extensions": {"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.3}},
        });
        let sheet = read(&model).unwrap();
        let share = sheet.materials.iter().find_map(|material| match material.kind {
            MaterialKind::Blend { weight, .. } => Some(weight.value),
            _ => None,
        });
        assert_eq!((share, sheet.media.all.len()), (Some(expected), 0));
    }
}

/// Film over a surface, and the texture of its thickness at its middle, in nanometers.
fn film_of(scene: &Scene, material: usize) -> Option<(f32, f64)> {
    let film = surface(scene, material).film?;
    let texture = film
        .thickness
        .texture
        .map_or(1.0, |texture| sample(&scene.textures[texture as usize], &scene.images, DVec2::splat(0.5)).x);
    Some((film.eta, f64::from(film.thickness.value) * texture))
}

/// `KHR_materials_iridescence` is a film, of which a factor below 1 covers a part.
#[test]
fn iridescence_is_a_film() {
    let with = |iridescence: Value| {
        let mut model = square();
        model["extensionsUsed"] = json!(["KHR_materials_iridescence"]);
        model["images"] = json!([{"uri": png_uri([51, 153, 0, 255])}]);
        model["textures"] = json!([{"source": 0}]);
        model["materials"][0]["extensions"] = json!({"KHR_materials_iridescence": iridescence});
        let scene = read(&model).unwrap();
        assert!(scene.warnings.iter().all(|warning| !warning.contains("iridescence")), "{:?}", scene.warnings);
        scene
    };
    let whole = |scene: &Scene| film_of(scene, scene.primitives[0].material as usize);
    assert_eq!(whole(&with(json!({}))), None);
    assert_eq!(whole(&with(json!({"iridescenceFactor": 0.0, "iridescenceThicknessMaximum": 300.0}))), None);
    assert_eq!(whole(&with(json!({"iridescenceFactor": 1.0}))), Some((1.3, 400.0)));
    let given = json!({"iridescenceFactor": 1.0, "iridescenceIor": 1.8, "iridescenceThicknessMaximum": 250.0});
    assert_eq!(whole(&with(given)), Some((1.8, 250.0)));
    // Green is 0.6, so the thickness is 0.4 of the least and 0.6 of the most.
    for (least, most) in [(100.0, 400.0), (500.0, 200.0)] {
        let textured = json!({
            "iridescenceFactor": 1.0,
            "iridescenceThicknessMinimum": least,
            "iridescenceThicknessMaximum": most,
            "iridescenceThicknessTexture": {"index": 0},
        });
        let (_, thickness) = whole(&with(textured)).expect("a film");
        assert!((thickness - (0.4 * least + 0.6 * most)).abs() < 2.0, "{thickness}");
    }
    for (part, texture) in [(0.25, json!(null)), (0.5, json!({"index": 0}))] {
        let mut partial = json!({"iridescenceFactor": part});
        if !texture.is_null() {
            partial["iridescenceTexture"] = texture;
        }
        let scene = with(partial);
        let blend = scene.materials.iter().find_map(|material| match &material.kind {
            MaterialKind::Blend { weight, materials } => Some((*weight, *materials)),
            _ => None,
        });
        let (weight, materials) = blend.expect("a blend");
        assert_eq!(weight.value, part as f32);
        assert_eq!(weight.texture.is_some(), part == 0.5);
        let films = materials.map(|material| film_of(&scene, material as usize).is_some());
        assert_eq!(films, [false, true]);
    }
}

/// A sheet without thickness has no film, and a warning says so.
#[test]
fn iridescence_of_a_sheet_is_left_out() {
    let warns = |extensions: Value| {
        let mut model = square();
        model["extensionsUsed"] = json!(["KHR_materials_iridescence", "KHR_materials_transmission"]);
        model["materials"][0]["extensions"] = extensions;
        let scene = read(&model).unwrap();
        scene.warnings.iter().any(|warning| warning.contains("has no film (KHR_materials_iridescence)"))
    };
    let film = json!({"iridescenceFactor": 1.0});
    let transmission = json!({"transmissionFactor": 0.5});
    assert!(warns(json!({"KHR_materials_iridescence": film, "KHR_materials_transmission": transmission})));
    assert!(!warns(json!({"KHR_materials_iridescence": film})));
    assert!(!warns(json!({"KHR_materials_transmission": transmission})));
}
