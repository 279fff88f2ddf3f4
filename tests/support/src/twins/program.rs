//! Twin of `glsl/include/texture/program.glsl` and `noise.glsl`, in double precision: facts of pbrt-v4's textures.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, DVec4};
pub use lodestar::math::perlin::noise;
use lodestar::scene::program::{Instruction, Operation, Place, Program};
use lodestar::scene::texture::{Image, Texture};
use lodestar::scene::texture_lookup::sample;

use super::hashed;
use super::voronoi::Voronoi;

/// Point at which a program is run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Point {
    pub uv: DVec2,
    pub position: DVec3,
    pub normal: DVec3,
    pub shading_normal: DVec3,
    pub incoming: DVec3,
}

/// Sum of octaves of noise, or of their absolute values.
fn octaves(p: DVec3, count: u32, roughness: f64, absolute: bool) -> f64 {
    let each = |octave: u32| {
        let value = noise(f64::from(1.99_f32).powi(octave as i32) * p);
        roughness.powi(octave as i32) * if absolute { value.abs() } else { value }
    };
    (0..count).map(each).sum::<f64>() + if absolute { 0.2 * roughness.powi(count as i32) } else { 0.0 }
}

fn is_in_dot(st: DVec2) -> bool {
    let cell = (st + 0.5).floor();
    let noise_at = |offset: DVec2| noise((cell + offset).extend(0.5));
    let center = cell + 0.15 * DVec2::new(noise_at(DVec2::new(1.5, 2.8)), noise_at(DVec2::new(4.5, 9.8)));
    noise_at(DVec2::splat(0.5)) > 0.0 && (st - center).length() < 0.35
}

fn marble(height: f64) -> DVec3 {
    let light = DVec3::new(0.58, 0.58, 0.6);
    let mut colors = [light; 9];
    (colors[3], colors[4], colors[7]) = (DVec3::splat(0.5), DVec3::new(0.6, 0.59, 0.58), DVec3::new(0.2, 0.2, 0.33));
    let place = 6.0 * height.clamp(0.0, 1.0);
    let first = place.floor().min(5.0);
    let t = place - first;
    let bernstein = [(1.0 - t).powi(3), 3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t), t.powi(3)];
    1.5 * bernstein.iter().zip(&colors[first as usize..]).map(|(weight, color)| *weight * *color).sum::<DVec3>()
}

fn float(bits: u32) -> f64 {
    f64::from(f32::from_bits(bits))
}

/// Value of an operation.
pub fn value(operation: Operation, [a, b, c]: [DVec3; 3], numbers: &[u32], scene: (&[Texture], &[Image])) -> DVec3 {
    let each = |function: &dyn Fn(f64, f64) -> f64| DVec3::from_array([0, 1, 2].map(|axis| function(a[axis], b[axis])));
    let turns = |x: f64, y: f64| y.atan2(x).rem_euclid(TAU) / TAU;
    match operation {
        Operation::Transform => {
            let row = |row: usize| {
                let numbers = &numbers[4 * row..4 * row + 4];
                (0..3).map(|axis| float(numbers[axis]) * a[axis]).sum::<f64>() + float(numbers[3])
            };
            DVec3::new(row(0), row(1), row(2))
        }
        Operation::Spherical => {
            let direction = a.normalize_or_zero();
            DVec3::new(direction.z.clamp(-1.0, 1.0).acos() / PI, turns(a.x, a.y), 0.0)
        }
        Operation::Cylindrical => DVec3::new((PI + a.y.atan2(a.x)) / TAU, a.z, 0.0),
        Operation::Component => DVec3::splat(a[numbers[0] as usize]),
        Operation::Add => a + b,
        Operation::Subtract => a - b,
        Operation::Multiply => a * b,
        Operation::Divide => each(&|a, b| if b == 0.0 { 0.0 } else { a / b }),
        Operation::Minimum => a.min(b),
        Operation::Maximum => a.max(b),
        Operation::Power => each(&|a, b| {
            let power = a.powf(b);
            if b != 0.0 && (a == 0.0 || power.is_nan()) { 0.0 } else { power }
        }),
        Operation::Absolute => a.abs(),
        Operation::Sine => each(&|a, _| a.sin()),
        Operation::SquareRoot => each(&|a, _| a.max(0.0).sqrt()),
        Operation::Mix => a + (b - a) * c,
        Operation::Dot => DVec3::splat(a.dot(b)),
        Operation::Luminance => DVec3::splat(a.dot(DVec3::new(0.212671, 0.715160, 0.072169))),
        Operation::Image => sample(&scene.0[numbers[0] as usize], scene.1, a.truncate()).truncate(),
        Operation::Checker => {
            let sum: f64 = a.to_array().iter().map(|coordinate| coordinate.floor()).sum();
            DVec3::splat(sum.rem_euclid(2.0))
        }
        Operation::Dots => DVec3::splat(f64::from(u8::from(is_in_dot(a.truncate())))),
        Operation::Fbm | Operation::Wrinkled => {
            DVec3::splat(octaves(a, numbers[0], float(numbers[1]), operation == Operation::Wrinkled))
        }
        Operation::Marble => marble(a.x),
        Operation::Floor => a.floor(),
        Operation::Less => each(&|a, b| f64::from(u8::from(a < b))),
        Operation::Exponential => each(&|a, _| a.exp()),
        Operation::Logarithm => each(&|a, _| if a > 0.0 { a.ln() } else { 0.0 }),
        Operation::Arctangent => each(&|a, b| a.atan2(b)),
        Operation::Combine => DVec3::new(a.x, b.x, c.x),
        Operation::HsvFromRgb => hashed::hsv(a),
        Operation::RgbFromHsv => hashed::from_hsv(a),
        Operation::HslFromRgb => hashed::hsl(a),
        Operation::RgbFromHsl => hashed::from_hsl(a),
        Operation::Table => {
            let entries = &numbers[2..];
            let channel = |at: usize| entries.iter().skip(at).step_by(3).map(|&bits| float(bits)).collect::<Vec<_>>();
            let look_up = |at: usize| hashed::table(&channel(at), a[at], numbers[1] != 0, numbers[0] != 0);
            DVec3::new(look_up(0), look_up(1), look_up(2))
        }
        Operation::WhiteNoise => hashed::white_noise(&coordinates(numbers[0] as usize, a, b.x)),
        Operation::Noise1d | Operation::Noise2d | Operation::Noise3d | Operation::Noise4d => {
            let point = coordinates(dimensions(operation), a, b.x);
            DVec3::splat(hashed::fractal(numbers[0], numbers[1] != 0, &point, [b.y, b.z, c.x, c.y, c.z]))
        }
        Operation::Voronoi1d | Operation::Voronoi2d | Operation::Voronoi3d | Operation::Voronoi4d => {
            voronoi(dimensions(operation), [a, b, c], numbers)
        }
        Operation::Bricks => {
            let sizes = [b.x, b.y, b.z, c.x, c.y];
            let rows = [numbers[2], numbers[3]].map(i64::from);
            hashed::bricks(a.truncate(), sizes, [float(numbers[0]), float(numbers[1])], rows).extend(0.0)
        }
    }
}

fn dimensions(operation: Operation) -> usize {
    match operation {
        Operation::Noise1d | Operation::Voronoi1d => 1,
        Operation::Noise2d | Operation::Voronoi2d => 2,
        Operation::Noise3d | Operation::Voronoi3d => 3,
        _ => 4,
    }
}

/// Point in one to four dimensions; in one it is the fourth coordinate.
fn coordinates(count: usize, p: DVec3, w: f64) -> Vec<f64> {
    match count {
        1 => vec![w],
        _ => [p.x, p.y, p.z, w][..count].to_vec(),
    }
}

fn voronoi(count: usize, [a, b, c]: [DVec3; 3], numbers: &[u32]) -> DVec3 {
    let mut point = coordinates(count, a, b.x);
    point.resize(4, 0.0);
    let diagram = Voronoi {
        dimensions: count,
        feature: numbers[0],
        metric: if count == 1 { 0 } else { numbers[1] },
        normalized: numbers[3] != 0,
        exponent: float(numbers[4]),
        detail: b.y,
        roughness: b.z,
        lacunarity: c.x,
        smoothness: c.y,
        randomness: c.z,
    };
    let (distance, color, position) = diagram.value(DVec4::from_slice(&point));
    let position = if count == 1 { DVec4::new(0.0, 0.0, 0.0, position.x) } else { position };
    match numbers[2] {
        0 => DVec3::splat(distance),
        1 => color,
        2 => position.truncate(),
        _ => DVec3::splat(position.w),
    }
}

/// Result of a program.
pub fn run(program: &Program, at: Point, scene: (&[Texture], &[Image])) -> DVec3 {
    let mut registers = [DVec3::NAN; 16];
    let mut result = DVec3::ZERO;
    for Instruction { operation, operands, numbers, output } in &program.instructions {
        let mut inputs = [DVec3::ZERO; 3];
        for (input, operand) in inputs.iter_mut().zip(operands) {
            *input = match operand {
                Place::Register(register) => registers[usize::from(*register)],
                Place::Constant(value) => value.as_dvec3(),
                Place::Uv => at.uv.extend(0.0),
                Place::Position => at.position,
                Place::Normal => at.normal,
                Place::ShadingNormal => at.shading_normal,
                Place::Incoming => at.incoming,
            };
        }
        result = value(*operation, inputs, numbers, scene);
        registers[usize::from(*output)] = result;
    }
    let [low, high] = program.limits.map(f64::from);
    if result.is_finite() { result.clamp(DVec3::splat(low), DVec3::splat(high)) } else { DVec3::ZERO }
}

/// Differences of a program's number along `u` and `v`, whose steps move the position by `dp_du` and `dp_dv` times as much.
pub fn gradient(program: &Program, at: Point, [dp_du, dp_dv]: [DVec3; 2]) -> DVec2 {
    let height = |by: DVec2| {
        let position = at.position + by.x * dp_du + by.y * dp_dv;
        run(program, Point { uv: at.uv + by, position, ..at }, (&[], &[])).x
    };
    let reach = if program.reads_position() { at.position.abs().max_element() / 65536.0 } else { 0.0 };
    let slope = |axis: DVec2, tangent: DVec3| {
        let step = 0.0005_f64.max(reach / tangent.length());
        (height(step * axis) - height(DVec2::ZERO)) / step
    };
    DVec2::new(slope(DVec2::X, dp_du), slope(DVec2::Y, dp_dv))
}
