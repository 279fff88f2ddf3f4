//! Files with arbitrary content give a scene or an error, never a panic.

use std::time::{Duration, Instant};

use lodestar::scene::Scene;
use lodestar::scene::measured::Measured;
use lodestar::scene::texture::{Image, Pattern, Texels};
use proptest::prelude::*;
use proptest::strategy::Union;
use proptest::test_runner::{RngSeed, TestRunner};

use super::Folder;
use super::meshes::{ascii_ply, binary_ply, compressed, load_bytes, serialized, serialized_content};
use super::textures::image_files;

const SCENE: &str = r#"<scene version="3.0.0">
<default name="w" value="16"/>
<integrator type="path"><integer name="max_depth" value="5"/></integrator>
<sensor type="perspective"><float name="fov" value="40"/>
<transform name="to_world"><lookat origin="0, 0, -4" target="0, 0, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="$w"/><rfilter type="box"/></film></sensor>
<bsdf type="twosided" id="a"><bsdf type="diffuse"><rgb name="reflectance" value="0.1, 0.2, 0.3"/></bsdf></bsdf>
<shape type="obj"><string name="filename" value="mesh.obj"/><ref id="a"/></shape>
<shape type="sphere"><point name="center" x="1" y="2" z="3"/><float name="radius" value="2"/></shape>
<shape type="cube"><transform name="to_world"><scale x="2"/><rotate y="1" angle="30"/></transform>
<emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>
</scene>"#;

const MATERIALS: &str = r#"<scene version="3.0.0"><sensor type="perspective"/>
<texture type="bitmap" id="t"><string name="filename" value="a.png"/><string name="wrap_mode" value="mirror"/>
<transform name="to_uv"><scale x="2"/></transform></texture>
<texture type="scale" id="u"><float name="scale" value="0.5"/><ref id="t"/></texture>
<bsdf type="blendbsdf" id="a"><float name="weight" value="0.3"/><bsdf type="mask"><ref name="opacity" id="t"/>
<bsdf type="roughplastic"><float name="alpha" value="0.2"/><ref name="diffuse_reflectance" id="u"/></bsdf></bsdf>
<bsdf type="bumpmap"><ref id="t"/><bsdf type="twosided" id="b"><bsdf type="roughconductor"><string name="material"
value="Au"/><float name="alpha_u" value="0.1"/><float name="alpha_v" value="0.2"/></bsdf></bsdf></bsdf></bsdf>
<bsdf type="principled" id="c"><float name="specular" value="0.4"/><texture name="sheen" type="checkerboard"/></bsdf>
<bsdf type="coating" id="d"><spectrum name="sigma_a" value="400:0.1, 700:0.2"/><bsdf type="conductor"><rgb name="eta"
value="1, 2, 3"/></bsdf></bsdf><bsdf type="roughdielectric" id="e"><string name="int_ior" value="water"/></bsdf>
<shape type="disk"><ref id="a"/></shape><shape type="disk"><ref id="c"/></shape><shape type="disk"><ref id="d"/></shape>
<bsdf type="phong" id="f"><float name="exponent" value="8"/><ref name="diffuseReflectance" id="u"/></bsdf>
<bsdf type="ward" id="g"><string name="variant" value="ward-duer"/><float name="alphaU" value="0.2"/></bsdf>
<bsdf type="pplastic" id="h"><float name="alpha" value="0.2"/></bsdf><bsdf type="principledthin" id="i"><float
name="diff_trans" value="1.5"/><float name="spec_trans" value="0.5"/><ref name="roughness" id="t"/></bsdf>
<emitter type="projector"><ref name="irradiance" id="u"/><float name="fov" value="40"/><string name="fov_axis"
value="y"/></emitter><emitter type="spot"><ref name="texture" id="t"/><float name="cutoff_angle" value="30"/></emitter>
<shape type="disk"><ref id="e"/></shape><shape type="disk"><ref id="b"/></shape><shape type="disk"><ref id="f"/></shape>
<shape type="disk"><ref id="g"/></shape><shape type="disk"><ref id="h"/></shape><shape type="disk"><ref id="i"/></shape>
</scene>"#;

/// Scene of what is read as something else, without a sensor.
const MAPPED: &str = r#"<scene version="2.1.0"><path value="more"/>
<integrator type="aov"><string name="aovs" value="d:depth"/><integrator type="direct"/></integrator>
<emitter type="area" id="l"><spectrum type="d65" name="radiance"><float name="scale" value="2"/></spectrum></emitter>
<bsdf type="mixturebsdf" id="a"><string name="weights" value="0.2, 0.3, 0.4"/><bsdf type="null"/><bsdf type="diffuse">
<texture type="mesh_attribute" name="diffuse_reflectance"><string name="name" value="vertex_color"/></texture></bsdf>
<bsdf type="roughconductorGGX"><float name="ext_eta" value="1.5"/></bsdf></bsdf><alias id="a" as="b"/>
<sampler type="independent"/><integer name="n" value="3"/>
<shape type="ply"><string name="filename" value="mesh.ply"/><ref id="b"/><transform name="to_world">
<rotate x="1" y="1" angle="30"/></transform></shape>
<shape type="sphere"><ref id="l"/><bsdf type="diffuse"><texture type="rawconstant" name="reflectance">
<vector name="value" value="0.5, 1, 0.3"/></texture></bsdf></shape>
</scene>"#;

const COLORED: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                       property float red\nproperty uchar green\nproperty double blue\nelement face 2\n\
                       property list uchar int vertex_indices\nend_header\n0 0 0 1 255 0.5\n1 0 0 0 128 1\n\
                       1 1 0 0.25 0 0\n0 1 0 1 1 1\n3 0 1 2\n3 0 2 3\n";

const MESH: &str = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1.5\nvt 0 0\nvt 1 0.5\nvn 0 0 1\n\
                    f 1/1/1 2/2/1 3/1/1\nf -3/1/1 -2//1 4/1/1 1/1/1\n";

/// Bytes with some overwritten, some runs repeated or left out, and a cut. They are overwritten with anything, or with
/// text that has a meaning in one of the formats.
pub fn mangled(bytes: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let length = bytes.len();
    let byte = prop_oneof![any::<u8>(), prop::sample::select(&b"-0123456789.e/$<>\"' \nfvn\0\xff"[..])];
    let edits = prop::collection::vec((0..length, byte), 0..6);
    let runs = prop::collection::vec((0..length, 0..40_usize, 0..3_usize), 0..2);
    (prop_oneof![Just(usize::MAX), 0..=length], edits, runs).prop_map(move |(cut, edits, runs)| {
        let mut bytes = bytes.clone();
        edits.into_iter().for_each(|(at, byte)| bytes[at] = byte);
        for (at, run, times) in runs {
            let at = at.min(bytes.len());
            let run = bytes.drain(at..(at + run).min(bytes.len())).collect::<Vec<_>>().repeat(times);
            bytes.splice(at..at, run);
        }
        bytes.truncate(cut);
        bytes
    })
}

/// Checks the invariants of a loaded scene.
pub fn check(scene: &Scene) -> Result<(), TestCaseError> {
    for primitive in &scene.primitives {
        prop_assert!(primitive.bounds().0.is_finite() && primitive.bounds().1.is_finite());
        prop_assert!(primitive.normals.iter().flatten().all(|n| (n.length() - 1.0).abs() < 1e-3));
        prop_assert!(primitive.uvs.iter().all(|uv| uv.is_finite()));
        prop_assert!((primitive.material as usize) < scene.materials.len());
    }
    for texture in &scene.textures {
        prop_assert!(texture.to_uv.is_finite());
        if let Pattern::Bitmap { image, .. } = texture.pattern {
            check_image(&scene.images[image as usize])?;
        }
    }
    Ok(())
}

fn check_image(image: &Image) -> Result<(), TestCaseError> {
    let count = image.width as usize * image.height as usize;
    match &image.texels {
        Texels::Bytes { data, .. } => prop_assert_eq!(data.len(), count),
        Texels::Heights(data) => {
            prop_assert_eq!(data.len(), count);
            prop_assert!(data.iter().all(|height| height.is_finite()));
        }
        Texels::Floats(data) => {
            prop_assert_eq!(data.len(), count);
            prop_assert!(data.iter().all(|[r, g, b, _]| [r, g, b].iter().all(|value| value.is_finite())));
        }
    }
    Ok(())
}

/// Tests 2,000 inputs, which are the same in every run, or as many new ones as `LODESTAR_FUZZ_SECONDS` allows.
pub fn fuzz<T: std::fmt::Debug>(inputs: impl Strategy<Value = T>, test: impl Fn(T) -> Result<(), TestCaseError>) {
    let seconds: Option<u64> = std::env::var("LODESTAR_FUZZ_SECONDS").ok().and_then(|text| text.parse().ok());
    let limit = Duration::from_secs(seconds.unwrap_or(0));
    let rng_seed = seconds.map_or(RngSeed::Fixed(1), |_| RngSeed::Random);
    let (begin, mut rounds) = (Instant::now(), 0);
    while rounds == 0 || begin.elapsed() < limit {
        let config = ProptestConfig { cases: 2000, failure_persistence: None, rng_seed, ..Default::default() };
        TestRunner::new(config).run(&inputs, &test).unwrap_or_else(|error| panic!("{error}"));
        rounds += 1;
    }
    println!("{} inputs in {:.0} s", 2000 * rounds, begin.elapsed().as_secs_f64());
}

#[test]
fn scenes() {
    let scene = prop_oneof![Just(SCENE.as_bytes().to_vec()), mangled(SCENE.into())];
    fuzz((scene, mangled(MESH.into())), |(scene, mesh)| {
        let folder = Folder::new(&[]);
        folder.write("scene.xml", &scene);
        folder.write("mesh.obj", &mesh);
        folder.load(&[]).map_or(Ok(()), |scene| check(&scene))
    });
}

#[test]
fn what_is_mapped() {
    let scene = prop_oneof![Just(MAPPED.as_bytes().to_vec()), mangled(MAPPED.into())];
    fuzz((scene, mangled(COLORED.into())), |(scene, mesh)| {
        let folder = Folder::new(&[]);
        folder.write("scene.xml", &scene);
        folder.write("mesh.ply", &mesh);
        folder.load(&[]).map_or(Ok(()), |scene| check(&scene))
    });
}

#[test]
fn materials() {
    let png = image_files().remove(0);
    fuzz(mangled(MATERIALS.into()), |scene| {
        let folder = Folder::new(&[]);
        folder.write("scene.xml", &scene);
        folder.write("a.png", &png);
        folder.load(&[]).map_or(Ok(()), |scene| check(&scene))
    });
}

/// Images of every format are fuzzed under one name, because the content determines the format.
#[test]
fn images() {
    let files = Union::new(image_files().into_iter().map(|file| mangled(file).boxed()));
    fuzz(files, |bytes| {
        let folder = Folder::new(&[("scene.xml", MATERIALS)]);
        folder.write("a.png", &bytes);
        folder.load(&[]).map_or(Ok(()), |scene| check(&scene))
    });
}

/// Files of measured materials of both kinds.
#[test]
fn measured_materials() {
    let files = ["isotropic.bsdf", "spectral.bsdf"].map(|name| mangled(super::measured::file(name)).boxed());
    fuzz(Union::new(files), |bytes| {
        match Measured::read(&bytes) {
            Ok(measured) => {
                let words = lodestar::encode::measured::words(&measured);
                prop_assert_eq!(words.len() as u64, measured.word_count());
            }
            Err(message) => prop_assert_eq!(message.lines().count(), 1, "{}", message),
        }
        Ok(())
    });
}

/// Fuzzes a mesh reader with mangled files, and with noise after the valid beginning of a file.
fn meshes(plugin: &str, files: Vec<Vec<u8>>, begin: &[u8]) {
    let noise = prop::collection::vec(any::<u8>(), 0..200);
    let begin = begin.to_vec();
    let noise = noise.prop_map(move |noise| [&begin[..], &noise].concat());
    let mangled = Union::new(files.into_iter().map(|file| mangled(file).boxed()));
    fuzz(prop_oneof![4 => mangled, 1 => noise], |bytes| {
        load_bytes(plugin, &bytes, "").map_or(Ok(()), |scene| check(&scene))
    });
}

#[test]
fn obj() {
    meshes("obj", vec![MESH.into()], b"v 0 0 0\nf ");
}

#[test]
fn ply() {
    meshes("ply", vec![ascii_ply(), binary_ply(false), binary_ply(true)], b"ply\nformat ascii 1.0\n");
}

#[test]
fn curves() {
    let text = "0 0 0 0.5\n1 0.5 0 0.25\n1 1 2 0.1\n-1 1.5 2 0\n\n0 2 0 1\n0 2 1 1e-1\n0 2 2 1\n0 3 2 1\n0 3 3 1\n";
    for plugin in ["linearcurve", "bsplinecurve"] {
        meshes(plugin, vec![text.into()], b"0 0 0 1\n0 0 1 1\n0 0 2 1\n");
    }
}

#[test]
fn serialized_as_it_is() {
    let file = |version, flags| serialized(version, &[compressed(version, &serialized_content(version, flags))]);
    meshes("serialized", vec![file(3, 0x1003), file(4, 0x200b)], b"\x1c\x04\x04\x00\x78\x9c");
}

/// Serialized content is mangled before it is compressed: most faults in compressed data are found by its checksum.
#[test]
fn serialized_content_of_any_kind() {
    let contents = [(3, 0x1003), (4, 0x1000), (4, 0x200b)].map(|(version, flags)| {
        mangled(serialized_content(version, flags)).prop_map(move |content| compressed(version, &content)).boxed()
    });
    fuzz(Union::new(contents), |bytes| load_bytes("serialized", &bytes, "").map_or(Ok(()), |scene| check(&scene)));
}

#[test]
fn the_unmangled_files_are_fine() {
    for file in image_files() {
        let folder = Folder::new(&[("scene.xml", MATERIALS)]);
        folder.write("a.png", &file);
        let scene = folder.load(&[]).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        // Heights are a texture of their own, and of floats an image of their own.
        let is_bytes = matches!(scene.images[0].texels, Texels::Bytes { .. });
        assert_eq!((scene.textures.len(), scene.images.len()), (3, if is_bytes { 1 } else { 2 }));
    }
    let scene = Folder::new(&[("scene.xml", SCENE), ("mesh.obj", MESH)]).load(&[]).unwrap();
    assert_eq!(scene.primitives.len(), 3 + 1 + 6);
    let scene = Folder::new(&[("scene.xml", MAPPED), ("mesh.ply", COLORED)]).load(&[]).unwrap();
    assert_eq!((scene.primitives.len(), scene.images.len()), (2 + 1, 1));
}
