//! Traversal of `glsl/include/geometry/traverse.glsl` and intersection of `glsl/include/geometry/intersect.glsl`,
//! against a twin that tests every primitive.

use std::iter::once;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3, vec3};
use lodestar::encode::bvh::{Bvh, NODE_WORDS};
use lodestar::generated::kernels::{NONE, Variant, test};
use lodestar::gpu::BufferKind;
use lodestar::scene::{Primitive, PrimitiveShape};
use support::device::Device;
use support::primitives::primitive;
use support::statistics::Numbers;
use support::twins::intersect::{Ray, crossings, traverse};

/// Distance from an outline, as a share of the primitive, or from grazing incidence, beyond which rounding cannot
/// decide.
const CLEAR: f64 = 1.0e-3;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct TraceInput {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    pub t_max: f32,
    pub any_hit: u32,
}

impl TraceInput {
    /// Ray without an end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin: origin.into(), direction: direction.into(), t_max: 3.0e38, any_hit: 0 }
    }

    fn ray(&self) -> Ray {
        let [origin, direction] = [self.origin, self.direction].map(|v| Vec3::from(v).as_dvec3());
        Ray { origin, direction, t_max: f64::from(self.t_max) }
    }
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct TraceOutput {
    pub t: f32,
    pub uv: [f32; 2],
    pub primitive: u32,
    pub instance: u32,
    overrun: u32,
}

pub const SHAPES: [PrimitiveShape; 4] =
    [PrimitiveShape::Triangle, PrimitiveShape::Parallelogram, PrimitiveShape::Disk, PrimitiveShape::Sphere];

/// Primitives of the given shapes and very different sizes around the origin.
pub fn primitives(shapes: &[PrimitiveShape], count: usize, seed: u32) -> Vec<Primitive> {
    let mut numbers = Numbers::new(seed);
    let mut one = |index: usize| {
        let shape = shapes[index % shapes.len()];
        let size = 10_f64.powf(numbers.between(-2.0, -0.3));
        let [origin, edge_u, other] = [(); 3].map(|()| numbers.unit_vector());
        let origin = origin * numbers.between(0.0, 2.0);
        let edge_v = match shape {
            PrimitiveShape::Disk | PrimitiveShape::Sphere => edge_u.cross(other).normalize(),
            _ => other * numbers.between(0.3, 1.5),
        };
        primitive(shape, origin.as_vec3(), (size * edge_u).as_vec3(), (size * edge_v).as_vec3())
    };
    (0..count).map(&mut one).collect()
}

/// Rays from everywhere. Most go towards the middle, some along the axes, and some are short.
pub fn rays(count: usize, any_hit: bool) -> Vec<TraceInput> {
    let mut numbers = Numbers::new(55);
    let mut ray = |index: usize| {
        let origin = numbers.unit_vector() * numbers.between(0.0, 4.0);
        let towards = (numbers.unit_vector() * numbers.between(0.0, 1.5) - origin).normalize_or(DVec3::Z);
        let axis = DVec3::AXES[index % 3] * if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let direction = if index.is_multiple_of(8) { axis } else { towards };
        let t_max = if index.is_multiple_of(5) { numbers.between(0.1, 3.0) as f32 } else { 3.0e38 };
        let [origin, direction] = [origin, direction].map(|v| v.as_vec3().into());
        TraceInput { origin, direction, t_max, any_hit: u32::from(any_hit) }
    };
    (0..count).map(&mut ray).collect()
}

/// Hierarchy of the primitives. Each primitive's material is its place in the list.
pub fn build(primitives: &[Primitive]) -> Bvh {
    let numbered: Vec<_> = (0..).zip(primitives).map(|(material, &p)| Primitive { material, ..p }).collect();
    Bvh::build(&numbered)
}

/// Hits that the device finds, with primitives numbered as in `primitives`.
fn trace(primitives: &[Primitive], rays: &[TraceInput]) -> Vec<TraceOutput> {
    let bvh = build(primitives);
    trace_with_stack(&bvh, bvh.depth, rays)
}

/// Hits that the device finds in a hierarchy of [`build`], with a stack of `stack_size` entries.
pub fn trace_with_stack(bvh: &Bvh, stack_size: u32, rays: &[TraceInput]) -> Vec<TraceOutput> {
    let mut found = trace_raw(bvh, stack_size, rays);
    // Leaves have another order than the list. The material gives the place in the list.
    for output in found.iter_mut().filter(|output| output.primitive != NONE) {
        output.primitive = bvh.attributes[output.primitive as usize].material;
    }
    found
}

/// Hits that the device finds in a hierarchy, with the indices that its primitives have there.
pub fn trace_raw(bvh: &Bvh, stack_size: u32, rays: &[TraceInput]) -> Vec<TraceOutput> {
    let device = Device::new();
    let nodes = device.buffer("nodes", size_of_val(&bvh.nodes[..]), BufferKind::TexelUint);
    nodes.upload(0, &bvh.nodes).expect("uploaded");
    let records = device.buffer("primitives", size_of_val(&bvh.primitives[..]), BufferKind::TexelUint);
    records.upload(0, &bvh.primitives).expect("uploaded");
    let (has_spheres, has_front_only) = (bvh.has_spheres(), bvh.has_front_only());
    let has_instances = bvh.has_instances();
    let variant = Variant { has_spheres, has_front_only, has_instances, stack_size, ..Variant::default() };
    let attributes = device.buffer("attributes", size_of_val(&bvh.attributes[..]), BufferKind::TexelUint);
    attributes.upload(0, &bvh.attributes).expect("uploaded");
    device.map_with(&test::TRAVERSE, &variant, rays, &[&nodes, &records, &attributes])
}

/// Error in an answer of the device that rounding cannot explain, if there is one.
pub fn fault(primitives: &[Primitive], input: &TraceInput, output: &TraceOutput) -> Option<String> {
    let ray = input.ray();
    let tolerance = 1.0e-5 * (1.0 + ray.origin.length());
    // A clear hit is one that no rounding can lose.
    let clear = |c: &support::twins::intersect::Crossing| {
        c.inside > CLEAR && c.steepness > CLEAR && c.t > tolerance && c.t < ray.t_max - tolerance
    };
    let clear_hits = primitives.iter().flat_map(|p| crossings(&ray, p)).filter(clear);
    let nearest = clear_hits.map(|c| c.t).fold(f64::INFINITY, f64::min);
    if output.overrun != 0 {
        return Some("overrun".into());
    }
    if output.primitive == NONE {
        return nearest.is_finite().then(|| format!("missed a hit at {nearest}"));
    }
    let t = f64::from(output.t);
    let own = crossings(&ray, &primitives[output.primitive as usize]);
    let is_real = own.iter().any(|c| c.inside > -CLEAR && (c.t - t).abs() < tolerance / c.steepness.clamp(CLEAR, 1.0));
    if !is_real {
        return Some(format!("no hit of primitive {} at {t}: {own:?}", output.primitive));
    }
    (input.any_hit == 0 && t > nearest + tolerance / CLEAR).then(|| format!("{t} lies behind the hit at {nearest}"))
}

fn assert_all_right(primitives: &[Primitive], rays: &[TraceInput]) -> Vec<TraceOutput> {
    let outputs = trace(primitives, rays);
    for (input, output) in rays.iter().zip(&outputs) {
        if let Some(fault) = fault(primitives, input, output) {
            panic!("{fault}: {input:?} {output:?}");
        }
    }
    outputs
}

/// Share of rays for which the device and the twin find the same primitive.
pub fn agreement(primitives: &[Primitive], rays: &[TraceInput], outputs: &[TraceOutput]) -> f64 {
    let agree = rays.iter().zip(outputs).filter(|(input, output)| match traverse(&input.ray(), primitives) {
        None => output.primitive == NONE,
        Some((t, index)) => output.primitive == index as u32 && (f64::from(output.t) - t).abs() < 1.0e-4 * t.max(0.1),
    });
    agree.count() as f64 / rays.len() as f64
}

#[test]
fn nearest_hits_are_those_of_the_twin() {
    let mixed: &[PrimitiveShape] = &SHAPES;
    for (shapes, seed) in SHAPES.iter().map(std::slice::from_ref).chain([mixed]).zip(61..) {
        let (primitives, rays) = (primitives(shapes, 400, seed), rays(4096, false));
        let outputs = assert_all_right(&primitives, &rays);
        let share = agreement(&primitives, &rays, &outputs);
        assert!(share > 0.999, "{shapes:?}: {share}");
        let hits = outputs.iter().filter(|o| o.primitive != NONE).count();
        assert!(hits > 300 && hits < rays.len() - 100, "{shapes:?}: {hits} hits");
    }
}

#[test]
fn any_hit_is_some_hit() {
    let (primitives, rays) = (primitives(&SHAPES, 400, 70), rays(4096, true));
    assert_all_right(&primitives, &rays);
}

/// Asserts that rays meet the fronts of the primitives, and that each wrong list of primitives gives answers at fault.
fn assert_fronts(primitives: &[Primitive], wrong: &[Vec<Primitive>]) {
    assert_all_right(primitives, &rays(4096, true));
    let rays = rays(4096, false);
    let share = agreement(primitives, &rays, &assert_all_right(primitives, &rays));
    assert!(share > 0.999, "{share}");
    for wrong in wrong {
        let outputs = trace(wrong, &rays);
        let faults = rays.iter().zip(&outputs).filter(|(ray, output)| fault(primitives, ray, output).is_some());
        assert!(faults.count() > 50);
    }
}

/// Rays that meet a flat shape from behind pass where only its front is solid. Twins whose backs are solid, or whose normals point
/// to the other side, are found.
#[test]
fn only_fronts_are_solid_where_the_primitive_says_so() {
    let mut primitives = primitives(&SHAPES, 400, 72);
    for (index, p) in primitives.iter_mut().enumerate() {
        (p.front_only, p.flip_normal) = (index.is_multiple_of(3), (index / SHAPES.len()).is_multiple_of(2));
    }
    let solid = primitives.iter().map(|&p| Primitive { front_only: false, ..p }).collect();
    let turned = primitives.iter().map(|&p| Primitive { flip_normal: !p.flip_normal, ..p }).collect();
    assert_fronts(&primitives, &[solid, turned]);
}

/// Normals at the vertices tell the front. Here they lean away from the geometric normal and differ from vertex to vertex. A twin
/// that ignores them is found.
#[test]
fn fronts_face_along_the_normals_at_the_vertices() {
    let mut primitives = primitives(&[PrimitiveShape::Triangle], 400, 73);
    let mut numbers = Numbers::new(74);
    for p in &mut primitives {
        let normal = p.edge_u.cross(p.edge_v).normalize().as_dvec3();
        p.front_only = true;
        p.normals = Some([(); 3].map(|()| (normal + 1.5 * numbers.unit_vector()).normalize().as_vec3()));
    }
    let flat = primitives.iter().map(|&p| Primitive { normals: None, ..p }).collect();
    assert_fronts(&primitives, &[flat]);
}

#[test]
fn wrong_answers_are_noticed() {
    let (primitives, rays) = (primitives(&SHAPES, 400, 71), rays(4096, false));
    let outputs = trace(&primitives, &rays);
    let hits: Vec<_> = rays.iter().zip(&outputs).filter(|(_, o)| o.primitive != NONE).collect();
    let noticed = |tamper: &dyn Fn(TraceOutput) -> TraceOutput| {
        let faults = hits.iter().filter(|(input, output)| fault(&primitives, input, &tamper(**output)).is_some());
        faults.count() as f64 / hits.len() as f64
    };
    assert_eq!(noticed(&|o| o), 0.0);
    for (what, share) in [
        ("a distance 1 % off", noticed(&|o| TraceOutput { t: 1.01 * o.t, ..o })),
        ("another primitive", noticed(&|o| TraceOutput { primitive: (o.primitive + 1) % 400, ..o })),
        ("a hit dropped", noticed(&|o| TraceOutput { primitive: NONE, ..o })),
        ("an overrun", noticed(&|o| TraceOutput { overrun: 1, ..o })),
    ] {
        assert!(share > 0.95, "{what}: noticed in {share}");
    }
}

#[test]
fn an_empty_scene_is_missed_and_one_primitive_is_enough() {
    for any_hit in [false, true] {
        let rays = rays(512, any_hit);
        assert!(trace(&[], &rays).iter().all(|o| o.primitive == NONE && o.overrun == 0));
        for shape in SHAPES {
            let one = [primitive(shape, vec3(0.1, 0.2, 0.3), Vec3::X, Vec3::Y)];
            let outputs = assert_all_right(&one, &rays);
            assert!(
                outputs.iter().any(|o| o.primitive == 0) && outputs.iter().any(|o| o.primitive == NONE),
                "{shape:?}"
            );
        }
    }
}

#[test]
fn degenerate_primitives_are_never_hit_and_hide_nothing() {
    let mut primitives = primitives(&SHAPES, 100, 80);
    for index in 0..60 {
        let p = primitives[index];
        let (edge_u, edge_v) = match index % 3 {
            0 => (Vec3::ZERO, Vec3::ZERO),
            1 => (p.edge_u, Vec3::ZERO),
            _ => (p.edge_u, 2.0 * p.edge_u),
        };
        let shape = SHAPES[index / 3 % 3];
        primitives.push(primitive(shape, p.origin, edge_u, edge_v));
    }
    primitives.push(primitive(PrimitiveShape::Sphere, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO));
    let outputs = assert_all_right(&primitives, &rays(4096, false));
    assert!(outputs.iter().all(|o| o.primitive == NONE || o.primitive < 100));
    // Degenerate primitives alone are hit by no ray.
    let only = &primitives[100..];
    assert!(trace(only, &rays(512, false)).iter().all(|o| o.primitive == NONE));
}

/// Nodes of a chain with two inner nodes on every level. One is the chain's next node. The other holds a single
/// primitive and is visited after everything below the first. All boxes are [0, 1]^3. A ray with a positive direction
/// leaves one group on the stack at every level except the last, which has only its primitive.
fn chain(primitive_count: u32) -> Vec<[u32; NODE_WORDS]> {
    // Cells have side 2^-7, so that 128 of them make up the box.
    let mut node = [0; NODE_WORDS];
    node[3] = u32::from_le_bytes([120, 120, 120, 0]);
    let inner = |child_base: u32| {
        let mut node = node;
        node[3] |= 0b11 << 24;
        node[4] = child_base;
        node[6] = u32::from_le_bytes([0b001_11000, 0b001_11001, 0, 0]);
        (2..5).for_each(|axis| node[4 * axis + 2] = 128 | 128 << 8);
        node
    };
    let leaf = |primitive: u32| {
        let mut node = node;
        node[5] = primitive;
        node[6] = 0b001_00000;
        (2..5).for_each(|axis| node[4 * axis + 2] = 128);
        node
    };
    let last = primitive_count - 2;
    let next = |level: u32| if level == last { leaf(level + 1) } else { inner(2 * level + 3) };
    once(inner(1)).chain((0..=last).flat_map(|level| [next(level), leaf(level)])).collect()
}

/// A stack can be filled to its last entry, and an entry too many is an overrun. The nearest primitive hangs at the
/// root and is found last, so no entry of the stack may be lost.
#[test]
fn a_stack_is_filled_to_its_last_entry_and_what_does_not_fit_is_an_overrun() {
    const LEVELS: u32 = 24;
    let plane = |index: u32| {
        let height = (index as f32 + 1.0) / (LEVELS as f32 + 2.0);
        primitive(PrimitiveShape::Parallelogram, height * Vec3::Z, Vec3::X, Vec3::Y)
    };
    let primitives: Vec<_> = (0..LEVELS).map(plane).collect();
    let mut bvh = build(&primitives);
    bvh.nodes = chain(LEVELS);
    // Sorts the primitives in the order of the list, which is the order of the chain's leaves.
    let Bvh { primitives: records, attributes, .. } = &mut bvh;
    records.sort_by(|a, b| a.origin[2].total_cmp(&b.origin[2]));
    attributes.sort_by_key(|attributes| attributes.material);
    let mut numbers = Numbers::new(90);
    let mut ray = |_| {
        let mut pair = |least, most| [(); 2].map(|()| numbers.between(least, most) as f32);
        let ([x, y], [dx, dy]) = (pair(0.0, 0.5), pair(0.01, 0.1));
        TraceInput::new(vec3(x, y, -0.01), vec3(dx, dy, 1.0).normalize())
    };
    let rays: Vec<_> = (0..512).map(&mut ray).collect();
    for any_hit in [0, 1] {
        let rays: Vec<_> = rays.iter().map(|&ray| TraceInput { any_hit, ..ray }).collect();
        // One group waits on every level except the last.
        let outputs = trace_with_stack(&bvh, LEVELS - 1, &rays);
        for (input, output) in rays.iter().zip(&outputs) {
            assert_eq!(fault(&primitives, input, output), None, "{input:?} {output:?}");
            assert_eq!(output.primitive, if any_hit == 1 { LEVELS - 1 } else { 0 }, "{input:?}");
        }
        let outputs = trace_with_stack(&bvh, LEVELS - 2, &rays);
        assert!(outputs.iter().all(|output| output.overrun == 1));
    }
}
