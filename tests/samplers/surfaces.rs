//! Surfaces of `glsl/include/geometry/surface.glsl`, and normals of `glsl/include/math/octahedral.glsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use lodestar::encode::bvh::Bvh;
use lodestar::generated::kernels::{NONE, Variant, test};
use lodestar::gpu::BufferKind;
use lodestar::scene::{Primitive, PrimitiveShape};
use support::device::{Device, GROUP};
use support::statistics::Numbers;
use support::twins::intersect::{Ray, crossings};

use crate::intersections::{SHAPES, TraceInput, primitives, rays};

/// Offset of leaving rays, relative to the largest of a hit's coordinates and its primitive's longest edge.
const RAY_EPSILON: f64 = 1.0 / 131_072.0;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct SurfaceOutput {
    pub position: [f32; 3],
    pub epsilon: f32,
    geometric_normal: [f32; 3],
    shading_normal: [f32; 3],
    material: u32,
    emitter: u32,
    pub uv: [f32; 2],
    pub dp_du: [f32; 3],
    pub dp_dv: [f32; 3],
    pub frame: [[f32; 3]; 3],
    leaving_origin: [f32; 3],
    leaving_direction: [f32; 3],
    leaving_t_max: f32,
    t: f32,
    hit_uv: [f32; 2],
    pub primitive: u32,
}

fn d3(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Primitives of all shapes. Each one's material is its index. Some are flipped, emit, or have vertex normals.
fn numbered_primitives() -> Vec<Primitive> {
    let mut numbers = Numbers::new(91);
    let mut all = primitives(&SHAPES, 400, 90);
    for (index, p) in all.iter_mut().enumerate() {
        p.material = index as u32;
        p.emitter = index.is_multiple_of(3).then_some(1000 + index as u32);
        p.flip_normal = index.is_multiple_of(5);
        if p.shape == PrimitiveShape::Triangle && index.is_multiple_of(8) {
            let geometric = p.edge_u.cross(p.edge_v).normalize();
            p.normals = Some([(); 3].map(|()| (geometric + 0.7 * numbers.unit_vector().as_vec3()).normalize()));
        }
    }
    all
}

/// Surfaces that rays hit, and the rays that leave there, on a device with the given `FEATURE_*` bits.
pub fn find(primitives: &[Primitive], rays: &[TraceInput], features: u32) -> Vec<SurfaceOutput> {
    let device = Device::new();
    let bvh = Bvh::build(primitives);
    let buffer = |name: &str, bytes: &[u8], kind| {
        let buffer = device.buffer(name, bytes.len(), kind);
        buffer.upload(0, bytes).expect("uploaded");
        buffer
    };
    let nodes = buffer("nodes", bytemuck::cast_slice(&bvh.nodes), BufferKind::TexelUint);
    let records = buffer("primitives", bytemuck::cast_slice(&bvh.primitives), BufferKind::TexelUint);
    let attributes = buffer("attributes", bytemuck::cast_slice(&bvh.attributes), BufferKind::TexelUint);
    let padded = rays.len().next_multiple_of(GROUP as usize);
    let input = device.storage("rays", size_of::<TraceInput>() * padded);
    input.upload(0, rays).expect("uploaded");
    let output = device.storage("surfaces", size_of::<SurfaceOutput>() * padded);
    let variant =
        Variant { has_spheres: true, stack_size: bvh.depth, surface_features: features, ..Variant::default() };
    let buffers = [&input, &output, &nodes, &records, &attributes];
    let kernel = device.kernel(&test::SURFACE, &variant);
    device.dispatch(&kernel, &buffers, &[], padded as u32 / GROUP);
    output.read(0, rays.len()).expect("read")
}

/// Geometric and shading normal by the scene's definition. The primitive is the original, before its first vertex was
/// changed.
fn normals(p: &Primitive, position: DVec3, hit: DVec3) -> (DVec3, DVec3) {
    let outward = match p.shape {
        PrimitiveShape::Sphere => (position - p.origin.as_dvec3()).normalize(),
        _ => p.edge_u.as_dvec3().cross(p.edge_v.as_dvec3()).normalize(),
    };
    let geometric = if p.flip_normal { -outward } else { outward };
    let (edge_u, edge_v, at) = (p.edge_u.as_dvec3(), p.edge_v.as_dvec3(), hit - p.origin.as_dvec3());
    let area = edge_u.cross(edge_v);
    let [u, v] = [at.cross(edge_v), edge_u.cross(at)].map(|part| part.dot(area) / area.length_squared());
    let shading = p.normals.map_or(geometric, |[a, b, c]| {
        ((1.0 - u - v) * a.as_dvec3() + u * b.as_dvec3() + v * c.as_dvec3()).normalize()
    });
    (geometric, shading)
}

fn longest(p: &Primitive) -> f64 {
    let flat = p.edge_u.length().max(p.edge_v.length()).max((p.edge_u - p.edge_v).length());
    f64::from(if p.shape == PrimitiveShape::Sphere { p.edge_u.length() } else { flat })
}

#[test]
fn surfaces_are_what_the_scene_says() {
    let (primitives, rays) = (numbered_primitives(), rays(4096, false));
    let mut interpolated = 0;
    for (input, o) in rays.iter().zip(find(&primitives, &rays, 0)).filter(|(_, o)| o.primitive != NONE) {
        let p = &primitives[o.material as usize];
        assert_eq!(o.emitter, p.emitter.unwrap_or(NONE));
        let (position, t) = (d3(o.position), f64::from(o.t));
        let direction = d3(input.direction);
        let (geometric, shading) = normals(p, position, d3(input.origin) + t * direction);
        assert!((d3(o.geometric_normal) - geometric).length() < 1.0e-4, "{o:?}, not {geometric}");
        // Octahedral normals have 16 bits per coordinate. Flattened normals amplify their error.
        assert!((d3(o.shading_normal) - shading).length() < 5.0e-4, "{o:?}, not {shading}");
        assert!((d3(o.shading_normal).length() - 1.0).abs() < 1.0e-5, "{o:?}");
        interpolated += u32::from(p.normals.is_some());
        let epsilon = RAY_EPSILON * position.abs().max_element().max(longest(p));
        assert!((f64::from(o.epsilon) / epsilon - 1.0).abs() < 1.0e-4, "{epsilon}: {o:?}");
        // The position is drawn in from edges by an epsilon at most, or a few where edges meet at a sharp angle.
        let moved = (position - (d3(input.origin) + t * direction)).length();
        let smallest = f64::from(p.edge_u.length().min(p.edge_v.length()));
        assert!(moved < 10.0 * epsilon, "moved by {moved}, of {smallest}: {o:?}");
        // A line along the normal through the position crosses the primitive there, well inside.
        let through = Ray { origin: position - geometric, direction: geometric, t_max: 2.0 };
        let crossed = crossings(&through, p).iter().any(|c| c.inside > 0.0 && (c.t - 1.0).abs() < 1.0e-6);
        assert!(crossed, "{:?}: {o:?}", crossings(&through, p));
        // The leaving ray starts on the side of its direction.
        let side = geometric.dot(-direction);
        let off = (d3(o.leaving_origin) - position).dot(geometric) * side.signum();
        assert!(side.abs() < 1.0e-5 || (off - epsilon).abs() < 1.0e-6, "left by {off}: {o:?}");
        assert_eq!(d3(o.leaving_direction), -direction);
    }
    assert!(interpolated > 30, "{interpolated}");
}
