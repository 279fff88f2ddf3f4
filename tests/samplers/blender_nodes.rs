//! Blender's nodes, as the add-on says them, against the values that Cycles gives them at points of a plane.
//! `addons/blender/tests/compare_nodes.py` writes the programs and the values.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use lodestar::scene::texture::Pattern;
use lodestar::scene::{Bsdf, MaterialKind, Scene};
use support::twins::program::{Point, run};

use crate::looked_up::{TextureInput, look_up};

/// Largest difference, as a share of the range of a node's values.
const TOLERANCE: f32 = 1.0e-4;
/// Share of the points of a case that may differ because they lie within rounding of an edge at which the value jumps.
const ON_EDGES: f32 = 0.002;
/// Numbers of a point: position, texture coordinates, normal and incoming direction.
const NUMBERS_OF_A_POINT: usize = 11;

struct Case {
    name: String,
    texture: u32,
    values: Vec<[f32; 3]>,
}

/// Points and cases of a folder, with the textures of its scene.
fn read(folder: &Path) -> (Scene, Vec<[f32; NUMBERS_OF_A_POINT]>, Vec<Case>) {
    let mut scene = Scene::load(folder.join("nodes.xml")).expect("a scene");
    let bytes = std::fs::read(folder.join("values.bin")).expect("values");
    let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let (head, rest) = numbers.split_at(2);
    let (count, cases) = (head[0] as usize, head[1] as usize);
    let (points, values) = rest.split_at(NUMBERS_OF_A_POINT * count);
    let points = points.as_chunks::<NUMBERS_OF_A_POINT>().0.to_vec();
    for texture in &mut scene.textures {
        if let Pattern::Program(program) = &mut texture.pattern {
            program.limits = [f32::MIN, f32::MAX];
        }
    }
    assert_eq!(values.len(), 3 * count * cases);
    let names = names(&std::fs::read_to_string(folder.join("nodes.xml")).expect("text"));
    assert_eq!(names.len(), cases);
    let shapes = scene.primitives.iter().map(|primitive| primitive.material).collect::<Vec<_>>();
    let case = |(at, (name, values)): (usize, (String, &[f32]))| {
        let MaterialKind::Surface(surface) = &scene.materials[shapes[at] as usize].kind else { panic!("{name}") };
        let Bsdf::Diffuse { reflectance } = &surface.bsdf else { panic!("{name}") };
        let texture = reflectance.texture.unwrap_or_else(|| panic!("{name} is no texture"));
        Case { name, texture, values: values.as_chunks::<3>().0.to_vec() }
    };
    let cases = names.into_iter().zip(values.chunks(3 * count)).enumerate().map(case).collect();
    (scene, points, cases)
}

/// Names of the cases, in their order.
fn names(text: &str) -> Vec<String> {
    let of = |line: &str| Some(line.trim().strip_prefix(r#"<bsdf type="diffuse" id=""#)?.split('"').next()?.to_owned());
    text.lines().filter_map(of).collect()
}

/// The case's range of values, and the share of points at which the difference is above the tolerance, with the largest other one.
fn compare(case: &Case, found: &[[f32; 3]], shift: f32) -> (f32, f32) {
    let all = case.values.iter().flatten();
    let (low, high) = all.fold((f32::MAX, f32::MIN), |(low, high), &value| (low.min(value), high.max(value)));
    let range = (high - low).max(1.0e-3);
    let differences: Vec<f32> = case
        .values
        .iter()
        .zip(found)
        .map(|(expected, found)| {
            (0..3).map(|at| (expected[at] - found[at] + shift * range).abs()).fold(0.0, f32::max) / range
        })
        .collect();
    let within: Vec<f32> = differences.iter().copied().filter(|difference| *difference <= TOLERANCE).collect();
    let beyond = differences.len() - within.len();
    (beyond as f32 / differences.len() as f32, within.into_iter().fold(0.0, f32::max))
}

fn point_of_twin(point: &[f32; NUMBERS_OF_A_POINT]) -> Point {
    let numbers = point.map(f64::from);
    let normal = DVec3::from_slice(&numbers[5..8]);
    Point {
        uv: [numbers[3], numbers[4]].into(),
        position: DVec3::from_slice(&numbers[0..3]),
        normal,
        shading_normal: normal,
        incoming: DVec3::from_slice(&numbers[8..11]),
    }
}

fn compare_folder(folder: &Path, on_edges: f32) {
    let (scene, points, cases) = read(folder);
    let three = |numbers: &[f32]| [numbers[0], numbers[1], numbers[2]];
    let input = |texture: u32, point: &[f32; NUMBERS_OF_A_POINT]| TextureInput {
        position: three(&point[0..3]),
        normal: three(&point[5..8]),
        shading_normal: three(&point[5..8]),
        incoming: three(&point[8..11]),
        ..TextureInput::new(texture, [point[3], point[4]])
    };
    // Neighbors run different programs, as on real surfaces.
    let inputs: Vec<TextureInput> =
        points.iter().flat_map(|point| cases.iter().map(|case| input(case.texture, point))).collect();
    let outputs = look_up(&scene.textures, &scene.images, &inputs);
    let mut table = String::new();
    let mut faults = String::new();
    for (at, case) in cases.iter().enumerate() {
        let of_case = outputs.iter().skip(at).step_by(cases.len());
        let found: Vec<[f32; 3]> = of_case.map(|output| three(&output.color)).collect();
        let (beyond, within) = compare(case, &found, 0.0);
        let _ = writeln!(table, "| {} | {within:.1e} | {beyond:.4} |", case.name);
        if beyond > on_edges {
            let _ = writeln!(faults, "{}: {beyond}, {:?} is not {:?}", case.name, found[0], case.values[0]);
        }
        let Pattern::Program(program) = &scene.textures[case.texture as usize].pattern else { panic!("{}", case.name) };
        let twins: Vec<[f32; 3]> = points
            .iter()
            .map(|point| run(program, point_of_twin(point), (&scene.textures, &scene.images)).as_vec3().to_array())
            .collect();
        let (beyond_twin, _) = compare(case, &twins, 0.0);
        if beyond_twin > on_edges {
            let _ = writeln!(faults, "twin of {}: {beyond_twin}", case.name);
        }
        assert!(compare(case, &found, 0.001).0 > 0.9, "a shifted {}", case.name);
    }
    println!("{table}");
    assert!(faults.is_empty(), "{faults}");
}

/// Each setting of each node has the value of Cycles at each point; shifted values have not.
#[test]
fn nodes_are_those_of_blender() {
    compare_folder(&PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/blender_nodes"), 0.0);
    if let Some(folder) = std::env::var_os("LODESTAR_NODES") {
        compare_folder(Path::new(&folder), ON_EDGES);
    }
}
