//! Reader of pbrt-v4.

mod cameras;
mod computed;
mod directives;
mod fuzzing;
mod hair;
mod lights;
mod materials;
mod nanovdb;
mod old_files;
mod shapes;
mod textures;

use lodestar::scene::{Bsdf, LoadOptions, MaterialKind, Scene, SurfaceMaterial, fingerprint, load};

use crate::Folder;

/// Loads a scene whose world is `world`, which begins on line 3.
fn world(world: &str) -> Result<Scene, String> {
    load_text(&format!("LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\" WorldBegin\n{world}\n"))
}

fn load_text(text: &str) -> Result<Scene, String> {
    load_in(&Folder::new(&[("scene.pbrt", text)]))
}

/// Loads the file `scene.pbrt` of a folder.
fn load_in(folder: &Folder) -> Result<Scene, String> {
    load(&folder.path("scene.pbrt"), &LoadOptions::default()).map_err(|error| error.to_string())
}

/// The surface that is the scene's only material, without a choice.
fn surface(scene: &Scene) -> &SurfaceMaterial {
    match &scene.materials[0].kind {
        MaterialKind::Surface(surface) => surface,
        other => panic!("{other:?}"),
    }
}

fn bsdf(scene: &Scene) -> &Bsdf {
    &surface(scene).bsdf
}

fn assert_close(found: &[f32], expected: &[f32]) {
    let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-5 * b.abs().max(1.0);
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(close), "{found:?} is not {expected:?}");
}

/// The Cornell box in pbrt's words.
const BOX: &str = r#"
# Mitsuba's axis to the left, by a mirror.
Scale -1 1 1
LookAt 278 273 -800  278 273 0  0 1 0
Film "rgb" "integer xresolution" [ 40 ] "integer yresolution" 30 "string filename" "box.exr"
PixelFilter "box"
Sampler "halton" "integer pixelsamples" [ 8 ]
Integrator "volpath" "integer maxdepth" [ 7 ] "string lightsampler" "power"
Camera "perspective" "float fov" [ 39.3076 ]
WorldBegin
MakeNamedMaterial "white" "string type" "diffuse" "rgb reflectance" [ 0.725 0.71 0.68 ]
MakeNamedMaterial "red" "string type" [ "diffuse" ] "rgb reflectance" [ 0.63 0.065 0.05 ]
NamedMaterial "white"
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ]
    "point3 P" [ 552.8 0 0  0 0 0  0 0 559.2  549.6 0 559.2 ]
NamedMaterial "red"
Shape "trianglemesh" "point3 P" [ 552.8 0 0  549.6 0 559.2  556 548.8 559.2  556 548.8 0 ]
    "integer indices" [ 0 1 2 0 2 3 ]
AttributeBegin
    AreaLightSource "diffuse" "rgb L" [ 17 12 4 ]
    Material "diffuse" "rgb reflectance" [ 0 0 0 ]
    Translate 278 548.25 279.5
    Rotate 90 1 0 0
    Shape "trianglemesh" "point3 P" [ -65 -52.5 0  65 -52.5 0  65 52.5 0  -65 52.5 0 ]
        "integer indices" [ 0 1 2 0 2 3 ]
AttributeEnd
AttributeBegin
    NamedMaterial "white"
    Translate 180 90 170
    Shape "sphere" "float radius" 90
AttributeEnd
"#;

/// Box of [`BOX`] in the words of Mitsuba.
const XML_BOX: &str = r#"<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="8"/></integrator>
<sensor type="perspective"><float name="fov" value="39.3076"/><string name="fov_axis" value="smaller"/>
<float name="near_clip" value="1e-6"/><float name="far_clip" value="1e10"/>
<transform name="to_world"><lookat origin="278, 273, -800" target="278, 273, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/><rfilter type="box"/></film>
<sampler type="independent"><integer name="sample_count" value="8"/></sampler></sensor>
<bsdf type="twosided" id="white"><bsdf type="diffuse"><rgb name="reflectance" value="0.725 0.71 0.68"/></bsdf></bsdf>
<bsdf type="twosided" id="red"><bsdf type="diffuse"><rgb name="reflectance" value="0.63 0.065 0.05"/></bsdf></bsdf>
<bsdf type="twosided" id="black"><bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf></bsdf>
<shape type="obj"><string name="filename" value="floor.obj"/><boolean name="face_normals" value="true"/><ref id="white"/></shape>
<shape type="obj"><string name="filename" value="left.obj"/><boolean name="face_normals" value="true"/><ref id="red"/></shape>
<shape type="obj"><string name="filename" value="light.obj"/><boolean name="face_normals" value="true"/><ref id="black"/>
<transform name="to_world"><rotate x="1" angle="90"/><translate x="278" y="548.25" z="279.5"/></transform>
<emitter type="area"><rgb name="radiance" value="17 12 4"/></emitter></shape>
<shape type="sphere"><float name="radius" value="90"/><transform name="to_world"><translate x="180" y="90" z="170"/></transform>
<ref id="white"/></shape>
</scene>"#;

const SQUARE: &str = "f 1 2 3\nf 1 3 4\n";

/// Both readings have one fingerprint, so they render the same bits. A wall that is turned over has another.
#[test]
fn a_box_is_that_of_xml() {
    let vertices = [
        ("floor.obj", "v 552.8 0 0\nv 0 0 0\nv 0 0 559.2\nv 549.6 0 559.2\n"),
        ("left.obj", "v 552.8 0 0\nv 549.6 0 559.2\nv 556 548.8 559.2\nv 556 548.8 0\n"),
        ("light.obj", "v -65 -52.5 0\nv 65 -52.5 0\nv 65 52.5 0\nv -65 52.5 0\n"),
    ];
    let folder = Folder::new(&[("scene.xml", XML_BOX)]);
    for (name, text) in vertices {
        folder.write(name, format!("{text}{SQUARE}").as_bytes());
    }
    let expected = folder.load(&[]).unwrap();
    let scene = load_text(BOX).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.camera, expected.camera);
    assert_eq!(scene.primitives, expected.primitives);
    assert_eq!(fingerprint(&scene).unwrap(), fingerprint(&expected).unwrap());
    let turned = load_text(&BOX.replace("Rotate 90", "ReverseOrientation Rotate 90")).unwrap();
    assert_ne!(fingerprint(&turned).unwrap(), fingerprint(&expected).unwrap());
}
