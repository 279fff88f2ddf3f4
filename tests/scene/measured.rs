//! Measured materials: what is read, and the sentences about other files.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use lodestar::scene::measured::Measured;
use lodestar::scene::{Bsdf, MaterialKind, fingerprint};

use super::Folder;

/// A file of `tests/data/measured`.
pub fn file(name: &str) -> Vec<u8> {
    fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/measured").join(name)).unwrap()
}

/// Tensor file of these fields: name, type, dimensions and bytes.
fn tensors(fields: &[(&str, u8, &[u64], Vec<u8>)]) -> Vec<u8> {
    let header: usize = fields.iter().map(|(name, _, shape, _)| 13 + name.len() + 8 * shape.len()).sum::<usize>() + 18;
    let mut bytes = b"tensor_file\0\x01\x00".to_vec();
    bytes.extend((fields.len() as u32).to_le_bytes());
    let mut place = header;
    for (name, kind, shape, content) in fields {
        bytes.extend((name.len() as u16).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.extend((shape.len() as u16).to_le_bytes());
        bytes.push(*kind);
        bytes.extend((place as u64).to_le_bytes());
        bytes.extend(shape.iter().flat_map(|side| side.to_le_bytes()));
        place += content.len();
    }
    bytes.extend(fields.iter().flat_map(|(.., content)| content.clone()));
    bytes
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

type Field = (&'static str, u8, &'static [u64], Vec<u8>);

/// Fields of a material that reflects light of all wavelengths alike, at two elevations.
fn fields() -> Vec<Field> {
    vec![
        ("theta_i", 10, &[2], floats(&[0.0, 1.5])),
        ("phi_i", 10, &[1], floats(&[0.0])),
        ("ndf", 10, &[2, 2], floats(&[0.3; 4])),
        ("sigma", 10, &[2, 2], floats(&[0.5; 4])),
        ("vndf", 10, &[1, 2, 2, 2], floats(&[1.0; 8])),
        ("luminance", 10, &[1, 2, 2, 2], floats(&[0.25; 8])),
        ("spectra", 10, &[1, 2, 3, 2, 2], floats(&[0.25; 24])),
        ("wavelengths", 10, &[3], floats(&[400.0, 500.0, 650.0])),
        ("jacobian", 1, &[1], vec![1]),
    ]
}

/// The fields with another one in the place of that of its name.
fn with(field: Field) -> Vec<u8> {
    let fields = fields().into_iter().map(|old| if old.0 == field.0 { field.clone() } else { old });
    tensors(&fields.collect::<Vec<_>>())
}

#[test]
fn files_of_colors_and_of_spectra_are_read() {
    let isotropic = Measured::read(&file("isotropic.bsdf")).unwrap();
    assert_eq!((isotropic.phi.len(), isotropic.theta.len(), isotropic.parts()), (1, 4, 0));
    assert_eq!((isotropic.vndf.size, isotropic.luminance.size), ([16; 2], [8; 2]));
    assert_eq!(isotropic.colors[2].values.len(), 4 * 64);
    let anisotropic = Measured::read(&file("anisotropic.bsdf")).unwrap();
    assert_eq!((anisotropic.is_isotropic(), anisotropic.parts()), (false, 4));
    for measured in [&isotropic, &anisotropic] {
        assert_eq!(lodestar::encode::measured::words(measured).len() as u64, measured.word_count());
    }
    // A spectrum that is the same everywhere is gray, within and beyond its wavelengths.
    let gray = Measured::read(&tensors(&fields())).unwrap();
    assert!(gray.colors.iter().flat_map(|grids| &grids.values).all(|value| (value - 0.25).abs() < 1.0e-6), "{gray:?}");
    let red: Vec<f32> = [0.0, 0.0, 1.0].into_iter().flat_map(|value| [value; 4]).collect();
    let red = Measured::read(&with(("spectra", 10, &[1, 2, 3, 2, 2], floats(&[&red[..], &red].concat())))).unwrap();
    let [r, g, b] = [0, 1, 2].map(|channel| red.colors[channel].values[0]);
    assert!(r > 0.8 && r > 2.0 * g && b == 0.0, "{r} {g} {b}");
    // Without the factor of facets, the colors are values of the whole function.
    let whole = Measured::read(&with(("jacobian", 1, &[1], vec![0]))).unwrap();
    assert_eq!((whole.ndf.values[0], whole.sigma.values[0]), (1.0, 0.25));
    // What reflects light is drawn, and noise below 0 counts as 0.
    let dark = Measured::read(&with(("luminance", 10, &[1, 2, 2, 2], floats(&[0.0; 8])))).unwrap();
    assert!(dark.luminance.values.iter().all(|value| (value - 0.25).abs() < 1.0e-6));
    let noisy = Measured::read(&with(("ndf", 10, &[2, 2], floats(&[0.3, 0.3, -1.0e-5, 0.3])))).unwrap();
    assert_eq!(noisy.ndf.values[2], 0.0);
}

#[test]
fn bad_files_get_a_sentence() {
    let good = tensors(&fields());
    let refused = |bytes: &[u8], says: &str| {
        let message = Measured::read(bytes).map(drop).expect_err(says);
        assert!(message.contains(says) && message.lines().count() == 1, "{message}");
    };
    refused(b"PNG", "is no tensor file");
    refused(b"", "is no tensor file");
    refused(&good[..15], "is cut off within its header");
    refused(&good[..40], "is cut off within its header");
    refused(&good[..good.len() - 1], "does not lie within it");
    let at = |place: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[place] = byte;
        bytes
    };
    refused(&at(12, 2), "has version 2.0");
    refused(&at(17, 255), "fields; at most 256");
    refused(&with(("theta_i", 77, &[2], floats(&[0.0, 1.5]))), "of type 77, which is none of the format's");
    refused(&with(("theta_i", 5, &[2], floats(&[0.0, 1.5]))), "of type 5; it should have numbers in single precision");
    refused(&with(("theta_i", 10, &[u64::MAX, 2], floats(&[0.0, 1.5]))), "does not lie within it");
    refused(&with(("theta_i", 10, &[1 << 62, 16], floats(&[0.0, 1.5]))), "does not lie within it");
    refused(&with(("theta_i", 10, &[0], vec![])), "does not lie within it");
    refused(&with(("theta_i", 10, &[2], floats(&[1.5, 0.0]))), "not radians in increasing order");
    refused(&with(("theta_i", 10, &[2], floats(&[0.0, 90.0]))), "not radians in increasing order");
    refused(&with(("theta_i", 10, &[2, 1], floats(&[0.0, 1.5]))), "is no list");
    refused(&with(("theta_i", 10, &[1], floats(&[0.0]))), "it should have 1 x 1 x grids of 2 to");
    refused(&with(("ndf", 10, &[4, 1], floats(&[0.3; 4]))), "has a field `ndf` of 4 x 1 numbers");
    refused(&with(("ndf", 10, &[2, 2], floats(&[0.3, f32::NAN, 0.3, 0.3]))), "not finite in its field `ndf`");
    refused(&with(("sigma", 10, &[2, 2], floats(&[0.3, -0.3, 0.3, 0.3]))), "has the number -0.3 in its field `sigma`");
    refused(&with(("sigma", 10, &[2, 2], floats(&[0.3, 1.0e20, 0.3, 0.3]))), "in its field `sigma`; it should lie in");
    refused(&with(("vndf", 10, &[1, 2, 2, 2], floats(&[0.0; 8]))), "from which nothing is seen");
    refused(&with(("luminance", 10, &[1, 2, 2, 1], floats(&[1.0; 4]))), "has a field `luminance`");
    refused(&with(("spectra", 10, &[1, 2, 3, 2, 3], floats(&[0.25; 36]))), "have not the 2 x 2 numbers of `luminance`");
    refused(&with(("spectra", 10, &[1, 2, 2, 2, 2], floats(&[0.25; 16]))), "it should have 1 x 2 x 3 x grids");
    refused(&with(("wavelengths", 10, &[3], floats(&[400.0, 400.0, 650.0]))), "nanometers in increasing order");
    for field in fields() {
        let others: Vec<_> = fields().into_iter().filter(|other| other.0 != field.0).collect();
        // Without wavelengths the field of spectra has colors.
        let says = if field.0 == "wavelengths" { String::new() } else { format!("has no field `{}`", field.0) };
        match Measured::read(&tensors(&others)) {
            Ok(_) => assert_eq!(field.0, "wavelengths"),
            Err(message) => assert!(message.contains(&says), "{message}"),
        }
    }
    let twice: Vec<_> = fields().into_iter().chain([("ndf", 10, &[2, 2][..], floats(&[0.3; 4]))]).collect();
    refused(&tensors(&twice), "has two fields `ndf`");
}

const SCENE: &str = r#"<scene version="3.0.0"><sensor type="perspective"/>
<bsdf type="measured" id="a"><string name="filename" value="metal.bsdf"/></bsdf>
<bsdf type="twosided" id="b"><bsdf type="measured"><string name="filename" value="./metal.bsdf"/></bsdf></bsdf>
<shape type="sphere"><ref id="a"/></shape><shape type="disk"><ref id="b"/></shape><emitter type="constant"/></scene>"#;

#[test]
fn materials_of_one_file_share_it_and_its_content_counts() {
    let folder = Folder::new(&[("scene.xml", SCENE)]);
    folder.write("metal.bsdf", &file("isotropic.bsdf"));
    let scene = folder.load(&[]).unwrap();
    let tables: Vec<_> = scene
        .materials
        .iter()
        .map(|material| match &material.kind {
            MaterialKind::Surface(surface) => match &surface.bsdf {
                Bsdf::Measured(measured) => (Arc::clone(&measured.tables), surface.two_sided),
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(Arc::ptr_eq(&tables[0].0, &tables[1].0) && !tables[0].1 && tables[1].1);
    let before = fingerprint(&scene).unwrap();
    let mut changed = file("isotropic.bsdf");
    let last = changed.len() - 40;
    changed[last] ^= 1;
    folder.write("metal.bsdf", &changed);
    assert_ne!(fingerprint(&folder.load(&[]).unwrap()).unwrap(), before);
}

#[test]
fn a_file_that_is_none_is_named() {
    let folder = Folder::new(&[("scene.xml", SCENE)]);
    let error = folder.load(&[]).map(drop).unwrap_err().to_string();
    assert!(error.contains("scene.xml:2: ") && error.contains("`metal.bsdf` does not exist"), "{error}");
    folder.write("metal.bsdf", b"no tensors");
    let error = folder.load(&[]).map(drop).unwrap_err().to_string();
    assert!(error.contains("scene.xml:2: ") && error.contains("`metal.bsdf` is no tensor file"), "{error}");
    folder.write("scene.xml", SCENE.replace("<string name=\"filename\" value=\"metal.bsdf\"/>", "").as_bytes());
    let error = folder.load(&[]).map(drop).unwrap_err().to_string();
    assert!(error.contains("bsdf plugin `measured` needs its parameter `filename`"), "{error}");
}

/// The albedo is the mean of Mitsuba's at the directions of the tables.
#[test]
fn the_albedo_is_that_of_the_tables() {
    let mean = |name: &str| lodestar::encode::measured::mean(&Measured::read(&file(name)).unwrap());
    let metal = mean("isotropic.bsdf");
    assert!(metal.albedo.abs_diff_eq(Vec3::new(0.802, 0.554, 0.307), 0.008), "{metal:?}");
    // Half of GGX facets lie within the angle whose tangent is their roughness. Those that send light below the surface do not count.
    assert!((metal.roughness - 0.29).abs() < 0.02, "{metal:?}");
    let rougher = mean("spectral.bsdf");
    assert!((rougher.roughness - 0.36).abs() < 0.02, "{rougher:?}");
}
