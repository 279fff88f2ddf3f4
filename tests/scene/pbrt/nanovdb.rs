//! Media of files of NanoVDB.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::{IVec3, UVec3, Vec3};
use lodestar::scene::Scene;
use proptest::test_runner::{Config as ProptestConfig, TestRunner};

use super::{assert_close, load_in};
use crate::Folder;
use crate::fuzz::{check, fuzz, mangled};

/// Leaf: its lowest voxel, and its numbers, z fastest.
type Leaf = (IVec3, Vec<f32>);

/// Leaf with a number that depends on the voxel.
fn leaf(corner: IVec3, value: impl Fn(IVec3) -> f32) -> Leaf {
    let voxel = |index: i32| IVec3::new(index >> 6, index >> 3 & 7, index & 7);
    (corner, (0..512).map(|index| value(corner + voxel(index))).collect())
}

fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

/// Grid of version 32 with a background of 0, as bytes. `steps` is the side of a voxel along each axis. The box is from `low` to `high`.
fn grid(leaves: &[Leaf], low: IVec3, high: IVec3, steps: [f64; 3], tile: Option<(IVec3, f32)>) -> Vec<u8> {
    let mut bytes = vec![0; 672 + 64];
    let root = bytes.len();
    let all = leaves.iter().map(|leaf| leaf.0).chain(tile.map(|tile| tile.0));
    let mut cubes: Vec<IVec3> = all.map(|corner| corner >> 12).collect();
    cubes.dedup();
    bytes.resize(root + 64 + 32 * cubes.len(), 0);
    put(&mut bytes, root, bytemuck::cast_slice(&[low.to_array(), high.to_array()]));
    put(&mut bytes, root + 24, &(cubes.len() as u32).to_le_bytes());
    let offset = |from: usize, to: usize| ((to - from) as u64).to_le_bytes();
    for (index, cube) in cubes.into_iter().enumerate() {
        let upper = bytes.len();
        let bits = cube.to_array().map(|axis| u64::from((axis as u32) & 0xf_ffff));
        let entry = root + 64 + 32 * index;
        put(&mut bytes, entry, &(bits[2] | bits[1] << 21 | bits[0] << 42).to_le_bytes());
        put(&mut bytes, entry + 8, &offset(root, upper));
        bytes.resize(upper + 270_400, 0);
        if let Some((corner, value)) = tile.filter(|tile| tile.0 >> 12 == cube) {
            let child: IVec3 = (corner >> 7) & 31;
            let index = (child.x << 10 | child.y << 5 | child.z) as usize;
            put(&mut bytes, upper + 8256 + 8 * index, &value.to_le_bytes());
        }
        let mut lowers: Vec<IVec3> =
            leaves.iter().map(|leaf| leaf.0 >> 7).filter(|corner| *corner >> 5 == cube).collect();
        lowers.dedup();
        for lower_corner in lowers {
            let lower = bytes.len();
            let child: IVec3 = lower_corner & 31;
            let index = (child.x << 10 | child.y << 5 | child.z) as usize;
            bytes[upper + 4128 + index / 8] |= 1 << (index % 8);
            put(&mut bytes, upper + 8256 + 8 * index, &offset(upper, lower));
            bytes.resize(lower + 33_856, 0);
            for (corner, values) in leaves.iter().filter(|leaf| leaf.0 >> 7 == lower_corner) {
                let leaf = bytes.len();
                let child: IVec3 = (*corner >> 3) & 15;
                let index = (child.x << 8 | child.y << 4 | child.z) as usize;
                bytes[lower + 544 + index / 8] |= 1 << (index % 8);
                put(&mut bytes, lower + 1088 + 8 * index, &offset(lower, leaf));
                bytes.resize(leaf + 2144, 0);
                put(&mut bytes, leaf + 96, bytemuck::cast_slice(values));
            }
        }
    }
    // Where the root lies, from the tree on, and the map from voxels to space.
    put(&mut bytes, 672 + 24, &64_u64.to_le_bytes());
    for (axis, step) in steps.into_iter().enumerate() {
        put(&mut bytes, 296 + 88 + 32 * axis, &step.to_le_bytes());
    }
    put(&mut bytes, 296 + 232, &10_f64.to_le_bytes());
    bytes
}

/// File of grids with their names.
fn file(grids: &[(&str, &[u8])], is_packed: bool) -> Vec<u8> {
    let version = 32_u32 << 21 | 3 << 10;
    let mut bytes = b"NanoVDB0".to_vec();
    bytes.extend(version.to_le_bytes());
    bytes.extend((grids.len() as u16).to_le_bytes());
    bytes.extend(u16::from(is_packed).to_le_bytes());
    let stored = grids.iter().map(|(_, grid)| match is_packed {
        false => grid.to_vec(),
        true => {
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
            encoder.write_all(grid).unwrap();
            let packed = encoder.finish().unwrap();
            [&(packed.len() as u64).to_le_bytes()[..], &packed].concat()
        }
    });
    let stored: Vec<_> = stored.collect();
    for ((name, grid), stored) in grids.iter().zip(&stored) {
        let mut about = vec![0; 176];
        put(&mut about, 0, &(grid.len() as u64).to_le_bytes());
        put(&mut about, 8, &(stored.len() as u64).to_le_bytes());
        put(&mut about, 32, &1_u32.to_le_bytes());
        put(&mut about, 36, &2_u32.to_le_bytes());
        put(&mut about, 136, &(name.len() as u32 + 1).to_le_bytes());
        put(&mut about, 168, &u16::from(is_packed).to_le_bytes());
        put(&mut about, 172, &version.to_le_bytes());
        bytes.extend(about);
        bytes.extend(name.bytes().chain([0]));
    }
    bytes.extend(stored.concat());
    bytes
}

/// The medium of a file, with more parameters.
fn read(file: &[u8], parameters: &str) -> Result<Scene, String> {
    let medium = "Camera \"perspective\" WorldBegin\nScale 2 2 2 MakeNamedMedium \"smoke\" \"string type\" \"nanovdb\" \"string filename\" \"smoke.nvdb\"";
    let text = format!("{medium} {parameters}\nMediumInterface \"smoke\" \"\" Material \"interface\" Shape \"sphere\"");
    let folder = Folder::new(&[("scene.pbrt", &text)]);
    folder.write("smoke.nvdb", file);
    load_in(&folder)
}

fn density(voxel: IVec3) -> f32 {
    (3 * voxel.x + 5 * voxel.y + 7 * voxel.z).rem_euclid(64) as f32
}

/// Two leaves on both sides of 0, and a cube of one value, in a file that is packed or not.
#[test]
fn voxels_lie_where_they_should() {
    let corners = [IVec3::new(-8, 0, 0), IVec3::new(0, 0, 0)];
    let leaves = corners.map(|corner| leaf(corner, density));
    let (low, high) = (IVec3::new(-6, 0, 1), IVec3::new(129, 7, 5));
    let bytes = grid(&leaves, low, high, [1.0, 2.0, 3.0], Some((IVec3::new(128, 0, 0), 2.5)));
    for is_packed in [false, true] {
        let whole = file(&[("other", &grid(&[], low, high, [1.0; 3], None)), ("density", &bytes)], is_packed);
        let scene = read(&whole, "\"rgb sigma_s\" [ 3 1 1 ] \"float scale\" 2 \"float g\" 0.5").unwrap();
        assert!(!scene.warnings.iter().any(|warning| warning.contains("coarse")), "{:?}", scene.warnings);
        let medium = &scene.media.all[0];
        assert_eq!((medium.extinction, medium.albedo), (Vec3::new(8.0, 4.0, 4.0), Vec3::new(0.75, 0.5, 0.5)));
        let volume = &medium.volumes.as_ref().expect("volumes").extinction;
        // One layer more is the background.
        assert_eq!(volume.size, UVec3::new(137, 9, 6));
        for (z, y, x) in (0..6).flat_map(|z| (0..9).flat_map(move |y| (0..137).map(move |x| (z, y, x)))) {
            let voxel = low + IVec3::new(x, y, z);
            let expected = match voxel.x {
                _ if voxel.cmpgt(high).any() => 0.0,
                -6..8 => density(voxel),
                128..=129 => 2.5,
                _ => 0.0,
            };
            let found = volume.values[((z * 9 + y) * 137 + x) as usize];
            assert_eq!(found, expected, "{voxel}");
        }
        // The scene scales by 2, and the grid's map moves it by 10 along x. A voxel's number holds at its own place.
        let (from, to) = volume.bounds();
        assert_close(&from.as_vec3().to_array(), &[2.0 * (10.0 - 6.5), -2.0, 2.0 * 3.0 * 0.5]);
        assert_close(&to.as_vec3().to_array(), &[2.0 * (10.0 + 130.5), 4.0 * 8.5, 6.0 * 6.5]);
    }
}

/// The light of a voxel is that of a black body whose spectrum has 1 as its largest value.
#[test]
fn temperatures_glow() {
    let place = (IVec3::ZERO, IVec3::splat(7));
    let of = |value: f32| grid(&[leaf(IVec3::ZERO, |_| value)], place.0, place.1, [1.0; 3], None);
    let emission = |temperature: f32, parameters: &str| {
        let whole = file(&[("density", &of(1.0)), ("temperature", &of(temperature))], false);
        let medium = read(&whole, parameters).unwrap().media.all[0].clone();
        let volume = medium.volumes.unwrap().emission.expect("a grid of emission");
        Vec3::from_slice(&volume.values[..3]) * medium.emission
    };
    let luminance = |color: Vec3| color.dot(Vec3::new(0.212671, 0.715160, 0.072169));
    // At 5174 K the largest value lies at 560 nm, near the middle of what is seen; means of Planck's law by the CIE's curves of 1931.
    let found = luminance(emission(5174.0, ""));
    assert!((found - 0.986).abs() < 0.004, "{found}");
    let scaled = emission(62.74, "\"float temperatureoffset\" 11 \"float temperaturescale\" 100 \"float Lescale\" 2");
    assert!((luminance(scaled) - 2.0 * found).abs() < 0.01, "{scaled}");
    // A light of the same temperature has the same color.
    let text = "Camera \"perspective\" WorldBegin LightSource \"point\" \"blackbody I\" 2000";
    let scene = load_in(&Folder::new(&[("scene.pbrt", text)])).unwrap();
    let lodestar::scene::DeltaKind::Point { intensity, .. } = scene.delta_emitters[0].kind else { panic!("a point") };
    let cool = emission(2000.0, "");
    assert!((cool / luminance(cool) - intensity).length() < 2e-3, "{cool} is not {intensity}");
    assert_eq!(emission(100.0, "\"float temperaturecutoff\" 1"), Vec3::ZERO);
    // A grid in the text, too.
    let text = "Camera \"perspective\" WorldBegin MakeNamedMedium \"fire\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \
                \"float density\" [ 1 1 ] \"float temperature\" [ 0 2000 ] \"float Lescale\" [ 1 3 ]\n\
                MediumInterface \"fire\" \"\" Shape \"sphere\"";
    let scene = load_in(&Folder::new(&[("scene.pbrt", text)])).unwrap();
    let volume = scene.media.all[0].volumes.as_ref().unwrap().emission.as_ref().expect("a grid of emission");
    assert_close(&volume.values[..], &[[0.0; 3], (3.0 * cool).to_array()].concat());
    let both = text.replace("\"float Lescale\" [ 1 3 ]", "\"rgb Le\" [ 1 1 1 ]");
    let error = load_in(&Folder::new(&[("scene.pbrt", &both)])).unwrap_err();
    assert!(error.contains("cannot stand beside `Le`"), "{error}");
}

/// Where a grid is larger than a device can hold, each number is a mean, and the sum stays.
#[test]
fn large_grids_are_read_coarser() {
    let leaves = [leaf(IVec3::ZERO, density), leaf(IVec3::new(1016, 504, 200), |_| 3.0)];
    let bytes = grid(&leaves, IVec3::ZERO, IVec3::new(1023, 511, 207), [1.0; 3], None);
    let scene = read(&file(&[("density", &bytes)], false), "").unwrap();
    let volume = &scene.media.all[0].volumes.as_ref().unwrap().extinction;
    assert_eq!(volume.size, UVec3::new(513, 257, 105));
    let sum: f64 = volume.values.iter().map(|value| f64::from(*value)).sum::<f64>() * 8.0;
    let expected: f64 = leaves.iter().flat_map(|leaf| &leaf.1).map(|value| f64::from(*value)).sum();
    assert!((sum - expected).abs() < 1e-3 * expected, "{sum} is not {expected}");
    let sentence = "the grid `density` of 1024 x 512 x 208 voxels is read 2 times as coarse";
    assert!(scene.warnings.iter().any(|warning| warning.contains(sentence)), "{:?}", scene.warnings);
}

#[test]
fn broken_files_are_refused_in_a_sentence() {
    let bytes = grid(&[leaf(IVec3::ZERO, density)], IVec3::ZERO, IVec3::splat(7), [1.0; 3], None);
    let whole = file(&[("density", &bytes)], false);
    let changed = |at: usize, value: &[u8]| {
        let mut bytes = whole.clone();
        put(&mut bytes, at, value);
        bytes
    };
    // The grid begins after the header, what is said of it, and its name.
    let at = 16 + 176 + 8;
    let lower = at + 672 + 64 + 64 + 32 + 270_400;
    for (file, parameters, says) in [
        (b"ply\nformat ascii 1.0\n".to_vec(), "", "is no file of NanoVDB"),
        (whole[..whole.len() - 1].to_vec(), "", "ends before its grids do"),
        (changed(11, &[8]), "", "has the version 64 of NanoVDB; write it with version 32"),
        (changed(16 + 32, &[2]), "", "not of single-precision numbers"),
        (changed(16 + 36, &[1]), "", "no fog volume"),
        (changed(16 + 168, &[2]), "", "compressed by Blosc"),
        (changed(at + 672 + 64 + 12, &[0xff; 12]), "", "has a grid without voxels"),
        (changed(lower + 1088, &[0xff; 8]), "", "ends before its grids do"),
        (changed(lower + 33_856 + 96, &(-1_f32).to_le_bytes()), "", "has the negative value -1"),
        (changed(lower + 544, &[0xff; 512]), "", "the same nodes in several places"),
        (whole.clone(), "\"string gridname\" \"soot\"", "has no grid `soot`; give a `gridname`"),
    ] {
        let error = read(&file, parameters).expect_err(says);
        assert!(
            error.contains(says) && error.contains("scene.pbrt:2: ") && !error.contains('\n'),
            "{error} lacks {says}"
        );
    }
    // All children of a node are the same one.
    let mut same = whole.clone();
    same[lower + 544..lower + 544 + 512].fill(0xff);
    for child in 0..4096 {
        put(&mut same, lower + 1088 + 8 * child, &33_856_u64.to_le_bytes());
    }
    let error = read(&same, "").unwrap_err();
    assert!(error.contains("the same nodes in several places"), "{error}");
}

/// Most bytes of a file are zeros of empty tables, so only the others are changed.
#[test]
fn any_bytes() {
    let bytes = grid(&[leaf(IVec3::ZERO, density)], IVec3::ZERO, IVec3::splat(7), [1.0; 3], None);
    let whole = file(&[("density", &bytes)], false);
    let places: Vec<usize> = (0..whole.len()).filter(|at| whole[*at] != 0 || *at < 16 + 184 + 900).collect();
    let kept: Vec<u8> = places.iter().map(|at| whole[*at]).collect();
    let outcome = |changed: Vec<u8>| {
        let mut bytes = whole.clone();
        places.iter().zip(&changed).for_each(|(at, byte)| bytes[*at] = *byte);
        bytes.truncate(whole.len() - places.len().saturating_sub(changed.len()));
        match read(&bytes, "") {
            Ok(scene) => check(&scene),
            Err(error) => {
                proptest::prop_assert!(!error.is_empty());
                Ok(())
            }
        }
    };
    if std::env::var("LODESTAR_FUZZ_SECONDS").is_ok() {
        return fuzz(mangled(kept), outcome);
    }
    // The tables are large.
    let config = ProptestConfig { cases: 100, failure_persistence: None, ..Default::default() };
    TestRunner::new(config).run(&mangled(kept), outcome).unwrap_or_else(|error| panic!("{error}"));
}
