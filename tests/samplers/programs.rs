//! Programs of `glsl/include/texture/program.glsl`, against their twin.

use std::fmt::Write as _;

use glam::{DVec2, DVec3, Mat3, Vec3};
use lodestar::scene::program::graph::{Graph, Operand};
use lodestar::scene::program::operation::{Parameter, Takes};
use lodestar::scene::program::schedule::schedule;
use lodestar::scene::program::{Operation, Program};
use lodestar::scene::texture::{Image, Pattern, TexelFilter, Texels, Texture, WrapMode};
use support::statistics::Numbers;
use support::twins::program::{Point, gradient, run};

use crate::looked_up::{TextureInput, TextureOutput, look_up};

/// Points at which each operation is compared.
const POINTS: usize = 10_000;
/// Largest difference, as a share of the range of an operation's values.
const TOLERANCE: f64 = 1.0e-4;
/// No limit on a program's values.
const OPEN: [f32; 2] = [f32::MIN, f32::MAX];

fn of(program: Program) -> Texture {
    Texture { name: "program".into(), pattern: Pattern::Program(program), to_uv: Mat3::IDENTITY }
}

/// Image that a program looks up; it is the second texture.
fn scene() -> ([Texture; 1], Image) {
    let mut numbers = Numbers::new(3);
    let mut byte = || (numbers.unit() * 256.0) as u8;
    let data = (0..35).map(|_| [byte(), byte(), byte(), 255]).collect();
    let image = Image { name: "image".into(), width: 7, height: 5, texels: Texels::Bytes { srgb: false, data } };
    let pattern = Pattern::Bitmap { image: 0, filter: TexelFilter::Bilinear, wrap: WrapMode::Repeat };
    ([Texture { name: "bitmap".into(), pattern, to_uv: Mat3::IDENTITY }], image)
}

/// Numbers of an operation's parameters.
fn parameters(operation: Operation, numbers: &mut Numbers) -> Vec<u32> {
    let mut words = Vec::new();
    for parameter in operation.row().parameters {
        match *parameter {
            Parameter::Whole(_, default, most) => words.push(default.max(1).min(most)),
            Parameter::Number(_, default) => words.push(default.to_bits()),
            Parameter::Matrix(_) => words.extend((0..12).map(|_| (2.0 * numbers.unit() as f32 - 1.0).to_bits())),
            Parameter::Choice(..) => words.push(0),
            Parameter::Table(_) => words.extend((0..30).map(|_| (numbers.unit() as f32).to_bits())),
            Parameter::Texture => words.push(1),
        }
    }
    words
}

/// Program of one operation on the position, the normal and the coordinates, or on what has a range of values.
fn single(operation: Operation) -> Program {
    let mut graph = Graph::default();
    let mut inputs = [Operand::Position, Operand::Normal, Operand::Uv];
    let constant = |x: f32, y: f32, z: f32| Operand::Constant(Vec3::new(x, y, z));
    match operation.row().plugin {
        "bricks" => inputs = [Operand::Position, constant(0.05, 0.6, -0.1), constant(0.5, 0.25, 0.0)],
        plugin if plugin.starts_with("voronoi") || plugin.starts_with("noise") => {
            inputs[2] = constant(2.1, 0.7, 0.9);
            // In one dimension, the fourth coordinate is the only one.
            if plugin.ends_with("_1d") {
                let [detail, roughness] = [1.5, 0.6].map(|value| Operand::Constant(Vec3::splat(value)));
                inputs[1] = graph.add(Operation::Combine, &[Operand::Position, detail, roughness], &[]);
            }
        }
        plugin if plugin.starts_with("hs") || plugin.starts_with("rgb") => {
            let half = constant(0.5, 0.5, 0.5);
            let wave = graph.add(Operation::Sine, &[Operand::Position], &[]);
            let scaled = graph.add(Operation::Multiply, &[wave, half], &[]);
            inputs[0] = graph.add(Operation::Add, &[scaled, half], &[]);
        }
        _ => {}
    }
    let count = operation.row().inputs.len().min(3);
    let root = graph.add(operation, &inputs[..count], &parameters(operation, &mut Numbers::new(8)));
    schedule(&graph, root, OPEN).expect("a program")
}

fn inputs(count: usize, seed: u32) -> Vec<TextureInput> {
    let mut numbers = Numbers::new(seed);
    let mut within = |size: f64| (size * (2.0 * numbers.unit() - 1.0)) as f32;
    (0..count)
        .map(|_| TextureInput {
            index: 0,
            uv: [(); 2].map(|()| within(2.0)),
            position: [(); 3].map(|()| within(8.0)),
            normal: [(); 3].map(|()| within(2.0)),
            shading_normal: [(); 3].map(|()| within(1.0)),
            incoming: [(); 3].map(|()| within(1.0)),
            dp_du: [(); 3].map(|()| within(1.0)),
            dp_dv: [(); 3].map(|()| within(1.0)),
        })
        .collect()
}

fn point(input: &TextureInput) -> Point {
    let three = |value: [f32; 3]| Vec3::from(value).as_dvec3();
    let uv = DVec2::from_array(input.uv.map(f64::from));
    Point {
        uv,
        position: three(input.position),
        normal: three(input.normal),
        shading_normal: three(input.shading_normal),
        incoming: three(input.incoming),
    }
}

/// Largest difference between the kernel and the twin, as a share of the range of values. A point on whose edges a value jumps is
/// compared with the values around it, too. `tamper` is added to the twin's position.
fn difference(program: &Program, inputs: &[TextureInput], tamper: f64) -> f64 {
    let ([image_texture], image) = scene();
    let (textures, images) = ([of(program.clone()), image_texture], [image]);
    let outputs = look_up(&textures, &images, inputs);
    let expected = |input: &TextureInput, shift: f64| {
        let mut at = point(input);
        at.position += DVec3::splat(tamper + shift);
        at.uv += shift;
        run(program, at, (&textures, &images))
    };
    let (mut low, mut high, mut worst) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    for (input, output) in inputs.iter().zip(&outputs) {
        let found = DVec3::from_array([0, 1, 2].map(|channel| f64::from(output.color[channel])));
        let value = expected(input, 0.0);
        (low, high) = (low.min(value.min_element()), high.max(value.max_element()));
        let of = |shift: f64| (found - expected(input, shift)).abs().max_element();
        worst = worst.max([0.0, 1.0e-6, -1.0e-6].map(of).into_iter().fold(f64::INFINITY, f64::min));
    }
    worst / (high - low).max(1.0e-9)
}

/// Each operation has its twin's values; a shifted twin has others.
#[test]
fn every_operation_is_its_twin() {
    let inputs = inputs(POINTS, 5);
    let (mut table, mut faults) = (String::new(), String::new());
    for &operation in Operation::ALL {
        let program = single(operation);
        let found = difference(&program, &inputs, 0.0);
        let _ = writeln!(table, "| `{}` | {found:.1e} |", operation.row().plugin);
        // Quotients by numbers near 0 have no range.
        let bound = if operation == Operation::Divide { 1.0e-6 } else { TOLERANCE };
        if found > bound {
            let _ = writeln!(faults, "{}: {found}", operation.row().plugin);
        }
        let takes_position = operation.row().inputs.first().is_some_and(|input| input.takes != Takes::Number);
        if takes_position && operation != Operation::Divide {
            let shifted = difference(&program, &inputs[..1000], 0.05);
            assert!(shifted > 10.0 * TOLERANCE, "a shifted twin of {}: {shifted}", operation.row().plugin);
        }
    }
    println!("{table}");
    assert!(faults.is_empty(), "{faults}");
}

/// A program of many operations: constants, registers and sources in all places.
fn random_program(seed: u32) -> Program {
    let mut numbers = Numbers::new(seed);
    let mut graph = Graph::default();
    let bounded = [
        Operation::Add,
        Operation::Subtract,
        Operation::Multiply,
        Operation::Minimum,
        Operation::Maximum,
        Operation::Absolute,
        Operation::Sine,
        Operation::Mix,
        Operation::Dot,
        Operation::Luminance,
        Operation::Component,
        Operation::Transform,
        Operation::Fbm,
    ];
    let mut operands = vec![Operand::Uv, Operand::Position, Operand::Normal];
    for _ in 0..24 {
        let mut index = |count: usize| ((numbers.unit() * count as f64) as usize).min(count - 1);
        let operation = bounded[index(bounded.len())];
        let inputs: Vec<Operand> = operation
            .row()
            .inputs
            .iter()
            .map(|_| match index(4) {
                0 => Operand::Constant(Vec3::new(0.25, -0.5, 0.125) * index(4) as f32),
                _ => operands[index(operands.len())],
            })
            .collect();
        let words = match operation {
            Operation::Fbm => vec![2, 0.5f32.to_bits()],
            _ => parameters(operation, &mut numbers),
        };
        let node = graph.add(operation, &inputs, &words);
        // A sine keeps values in bounds.
        operands.push(graph.add(Operation::Sine, &[node], &[]));
    }
    let mut sum = Operand::Constant(Vec3::ZERO);
    for &operand in operands.iter().rev().take(5) {
        sum = graph.add(Operation::Add, &[sum, operand], &[]);
    }
    schedule(&graph, sum, OPEN).expect("a program")
}

#[test]
fn programs_of_many_operations() {
    let inputs = inputs(500, 6);
    for seed in 0..12 {
        let program = random_program(seed);
        let found = difference(&program, &inputs, 0.0);
        assert!(found <= TOLERANCE, "{seed}: {found}: {program:?}");
    }
    assert!(difference(&random_program(1), &inputs, 0.05) > TOLERANCE, "a shifted twin");
}

/// Limits hold, and values that are not finite become 0.
#[test]
fn values_are_bounded() {
    let mut graph = Graph::default();
    let huge = Operand::Constant(Vec3::splat(1.0e38));
    let product = graph.add(Operation::Multiply, &[Operand::Position, huge], &[]);
    let square = graph.add(Operation::Multiply, &[product, product], &[]);
    let nothing = graph.add(Operation::Subtract, &[square, square], &[]);
    let inputs = inputs(256, 7);
    for (root, expected) in [(product, [0.0, 1.0]), (square, [0.0, 0.0]), (nothing, [0.0, 0.0])] {
        let program = schedule(&graph, root, [0.0, 1.0]).expect("a program");
        for output in look_up(&[of(program)], &[], &inputs) {
            assert!(output.color[..3].iter().all(|value| expected.contains(value)), "{output:?}");
        }
    }
}

/// Slopes of heights are the twin's. A slope of the other sign is seen.
#[test]
fn slopes_of_heights() {
    let mut graph = Graph::default();
    let noise = graph.add(Operation::Fbm, &[Operand::Position], &[2, 0.5f32.to_bits()]);
    let across = graph.add(Operation::Dot, &[Operand::Uv, Operand::Constant(Vec3::new(0.7, -0.4, 0.0))], &[]);
    let height = graph.add(Operation::Add, &[noise, across], &[]);
    let program = schedule(&graph, height, OPEN).expect("a program");
    let inputs = inputs(2000, 9);
    let outputs = look_up(&[of(program.clone())], &[], &inputs);
    let worst = |sign: f64| {
        let of = |(input, output): (&TextureInput, &TextureOutput)| {
            let tangents = [input.dp_du, input.dp_dv].map(|axis| Vec3::from(axis).as_dvec3());
            let expected = sign * gradient(&program, point(input), tangents);
            (DVec2::from_array(output.gradient.map(f64::from)) - expected).length()
        };
        inputs.iter().zip(&outputs).map(of).fold(0.0, f64::max)
    };
    // Heights are rounded to some 1e-6, which the step of 0.0005 divides.
    assert!(worst(1.0) < 2.0e-2, "{}", worst(1.0));
    assert!(worst(-1.0) > 1.0, "{}", worst(-1.0));
}
