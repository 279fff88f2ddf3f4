//! Files with arbitrary content give a scene or one sentence, never a panic.

use lodestar::scene::{LoadOptions, convert, fingerprint, load};
use proptest::prelude::*;
use proptest::strategy::Union;

use super::{BOX, load_in};
use crate::Folder;
use crate::fuzz::{check, fuzz, mangled};
use crate::meshes::{ascii_ply, binary_ply};

/// Materials and textures of every kind.
const MATERIALS: &str = r#"Film "rgb" "float iso" 200 "float cropwindow" [ 0 0.5 0 1 ]
Camera "perspective" "float lensradius" 0.1 "float screenwindow" [ -1.7778 1.7778 -1 1 ]
WorldBegin
ColorSpace "rec2020"
Texture "a" "spectrum" "imagemap" "string filename" "a.png" "float uscale" 2 "bool invert" true
Texture "b" "float" "imagemap" "string filename" "a.png" "string encoding" "gamma 2.2" "string wrap" "clamp"
Texture "c" "spectrum" "checkerboard" "rgb tex1" [ 1 0 0 ] "float uscale" 3
Texture "d" "spectrum" "mix" "texture tex1" "a" "rgb tex2" [ 0 1 0 ] "texture amount" "e"
Texture "e" "float" "constant" "float value" 0.3
Texture "f" "float" "scale" "texture tex" "b" "float scale" 0.1
Attribute "shape" "texture alpha" "b"
MakeNamedMaterial "m" "string type" "coateddiffuse" "texture reflectance" "a" "texture roughness" "b" "spectrum eta" "glass-BK7"
MakeNamedMaterial "n" "string type" "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" [ 400 1 700 2 ] "float uroughness" .1
Material "mix" "string materials" [ "m" "n" ] "texture amount" "f"
Shape "sphere" "float zmin" 0.95 "float phimax" 20
Material "coatedconductor" "rgb reflectance" [ .1 .2 .3 ] "float interface.roughness" .1
Shape "disk" "float innerradius" 0.2 "float phimax" 20
Material "dielectric" "float roughness" .3 "string normalmap" "a.png"
Shape "plymesh" "string filename" "mesh.ply"
NamedMaterial "n"
AreaLightSource "diffuse" "string filename" "a.png" "float power" 3 "bool twosided" true
Shape "bilinearmesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 1 1 1 ]
Material "diffuse" "texture reflectance" "c" "texture displacement" "b"
Shape "cylinder" "float zmax" 2 "float phimax" 30
"#;

/// Lights, objects and included files.
const LIGHTS: &str = r#"LookAt 0 0 5 0 0 0 0 1 0
PixelFilter "triangle" Camera "orthographic"
WorldBegin
LightSource "infinite" "string filename" "sky.pfm" "float illuminance" 3 "float scale" 2
LightSource "spot" "blackbody I" 3000 "point3 from" [ 0 1 2 ] "float power" 40
LightSource "distant" "spectrum L" "stdillum-F2" "point3 to" [ 1 1 0 ]
LightSource "point" "spectrum I" [ 400 1 600 2 ] "rgb scale" 1
ObjectBegin "o" Shape "sphere" "float radius" 2 Shape "trianglemesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 ] "normal N" [ 0 0 1 0 0 1 0 0 1 ]
ObjectEnd
AttributeBegin Translate 1 2 3 Rotate 30 1 1 0 ObjectInstance "o" AttributeEnd
Include "part.pbrt" Import "part.pbrt"
AttributeBegin CoordSysTransform "camera" ReverseOrientation AreaLightSource "diffuse" "spectrum L" "light.spd"
Shape "sphere" "float radius" 3 AttributeEnd
Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 4 5 6 1 ] Shape "disk"
"#;

/// A scene of pbrt-v3.
const OLD: &str = r#"Film "image" "float scale" 2 PixelFilter "gaussian" "float xwidth" 2 "float ywidth" 2 "float alpha" 2
Integrator "directlighting" Camera "perspective" "float halffov" 20
WorldBegin
LightSource "infinite" "string mapname" "sky.pfm" "rgb L" [ 1 2 3 ] "integer samples" 4
LightSource "infinite" "string filename" "sky.pfm" "rgb scale" [ 2 2 2 ]
LightSource "point" "blackbody I" [ 4000 3 ]
ColorSpace "aces2065-1"
Texture "a" "color" "imagemap" "string filename" "a.png" "bool trilinear" "true" "float gamma" 2.2
Texture "b" "color" "scale" "texture tex1" "a" "rgb tex2" [ 0.5 0.5 0.5 ]
Material "plastic" "texture Kd" "b" "float roughness" 0.1 AttributeBegin AreaLightSource "area" "integer nsamples" 3
Shape "trianglemesh" "point P" [ 0 0 0 1 0 0 0 1 0 ] "float st" [ 0 0 1 0 0 1 ] "float alpha" 0 AttributeEnd
Material "uber" "color opacity" [ 0.5 0.5 0.5 ] "float index" 1.3 Shape "sphere"
Material "translucent" "texture Kd" "b" "rgb reflect" [ 0.2 0.2 0.2 ] Shape "sphere" "float radius" 2
MakeNamedMaterial "m" "string type" "mirror" MakeNamedMaterial "n" "string type" "glass" "float uroughness" 0.2
Material "mix" "string namedmaterial1" "m" "string namedmaterial2" "n" "rgb amount" [ 0.2 0.2 0.2 ]
WorldEnd
"#;

const PART: &str = "Material \"thindielectric\" ConcatTransform [ 1 0 0 0 0 2 0 0 0 0 1 0 4 5 6 1 ] Shape \"sphere\"\n";

const SPECTRUM: &str = "# a comment\n400 1.5\n500 2 600 3\n";

fn sky() -> Vec<u8> {
    let floats = (0..16 * 3).flat_map(|index| (0.1 * index as f32).to_le_bytes());
    b"PF\n4 4\n-1\n".iter().copied().chain(floats).collect()
}

fn png() -> Vec<u8> {
    crate::textures::image_files().remove(0)
}

/// Folder of files for all the scenes above.
fn folder(scene: &[u8]) -> Folder {
    let folder = Folder::new(&[("part.pbrt", PART), ("light.spd", SPECTRUM)]);
    folder.write("scene.pbrt", scene);
    folder.write("mesh.ply", &ascii_ply());
    folder.write("a.png", &png());
    folder.write("sky.pfm", &sky());
    folder
}

fn outcome(folder: &Folder) -> Result<(), TestCaseError> {
    match load_in(folder) {
        Ok(scene) => check(&scene),
        Err(error) => {
            prop_assert!(!error.is_empty());
            Ok(())
        }
    }
}

#[test]
fn scenes() {
    let scenes = [BOX, MATERIALS, LIGHTS, OLD].map(|scene| mangled(scene.into()).boxed());
    fuzz(Union::new(scenes), |scene| outcome(&folder(&scene)));
}

#[test]
fn files_that_scenes_name() {
    const INCLUDES: &str = "Camera \"perspective\" WorldBegin Include \"part.pbrt\" Import \"part.pbrt\"";
    const SHINES: &str = "Camera \"perspective\" WorldBegin LightSource \"point\" \"spectrum I\" \"light.spd\"";
    const SKY: &str = "Camera \"perspective\" WorldBegin LightSource \"infinite\" \"string filename\" \"sky.pfm\" \"float illuminance\" 3";
    const MESH: &str =
        "WorldBegin AreaLightSource \"diffuse\" \"float power\" 3 Shape \"plymesh\" \"string filename\" \"mesh.ply\"";
    const IMAGE: &str = "Camera \"perspective\" WorldBegin Texture \"b\" \"float\" \"imagemap\" \"string filename\" \"a.png\" \
                         Material \"conductor\" \"texture roughness\" \"b\" Shape \"sphere\" \"texture alpha\" \"b\"";
    let files = prop_oneof![
        mangled(PART.into()).prop_map(|bytes| ("part.pbrt", INCLUDES, bytes)),
        mangled(SPECTRUM.into()).prop_map(|bytes| ("light.spd", SHINES, bytes)),
        mangled(sky()).prop_map(|bytes| ("sky.pfm", SKY, bytes)),
        mangled(png()).prop_map(|bytes| ("a.png", IMAGE, bytes)),
        mangled(ascii_ply()).prop_map(|bytes| ("mesh.ply", MESH, bytes)),
        mangled(binary_ply(false)).prop_map(|bytes| ("mesh.ply", MESH, bytes)),
    ];
    fuzz(files, |(name, scene, bytes)| {
        let folder = Folder::new(&[("scene.pbrt", scene)]);
        folder.write(name, &bytes);
        outcome(&folder)
    });
}

/// Scenes converted to Mitsuba's format, with all their files, are the same scenes.
#[test]
fn conversions_keep_everything() {
    for text in [BOX, MATERIALS, LIGHTS, OLD] {
        let folder = folder(text.as_bytes());
        let output = folder.path("out.xml");
        convert(&folder.path("scene.pbrt"), &[], &output, false).unwrap();
        let read = load(&output, &LoadOptions::default()).unwrap();
        assert_eq!(fingerprint(&read).unwrap(), fingerprint(&load_in(&folder).unwrap()).unwrap(), "{text}");
    }
}

#[test]
fn the_unmangled_files_are_fine() {
    for (text, primitives, lights) in [(BOX, 7, 0), (MATERIALS, 0, 0), (LIGHTS, 8, 3)] {
        let scene = load_in(&folder(text.as_bytes())).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!(scene.primitives.len() >= primitives, "{}", scene.primitives.len());
        assert_eq!(scene.delta_emitters.len(), lights);
    }
}
