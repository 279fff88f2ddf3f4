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

/// Bound of the offset of leaving rays, relative to the largest of a hit's coordinates and its primitive's longest edge.
const RAY_EPSILON: f64 = 1.0 / 131_072.0;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct SurfaceOutput {
    pub position: [f32; 3],
    pub epsilon: f32,
    pub size: f32,
    pub geometric_normal: [f32; 3],
    pub shading_normal: [f32; 3],
    pub material: u32,
    emitter: u32,
    pub uv: [f32; 2],
    pub dp_du: [f32; 3],
    pub dp_dv: [f32; 3],
    pub frame: [[f32; 3]; 3],
    pub leaving_origin: [f32; 3],
    leaving_direction: [f32; 3],
    leaving_t_max: f32,
    pub t: f32,
    hit_uv: [f32; 2],
    pub primitive: u32,
    pub instance: u32,
}

pub fn d3(v: [f32; 3]) -> DVec3 {
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
    find_in(&Bvh::build(primitives), rays, features)
}

/// Surfaces that rays hit in a hierarchy.
pub fn find_in(bvh: &Bvh, rays: &[TraceInput], features: u32) -> Vec<SurfaceOutput> {
    let device = Device::new();
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
    let variant = Variant {
        has_spheres: true,
        has_front_only: bvh.has_front_only(),
        has_instances: bvh.has_instances(),
        stack_size: bvh.depth,
        surface_features: features,
        ..Variant::default()
    };
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
        let most = RAY_EPSILON * position.abs().max_element().max(longest(p));
        let epsilon = f64::from(o.epsilon);
        assert!(epsilon < most, "{most}: {o:?}");
        assert!((f64::from(o.size) / longest(p) - 1.0).abs() < 1.0e-6, "{o:?}");
        // The position is drawn in from edges by roundings of the coordinates, or a few more where edges meet at a sharp
        // angle.
        let moved = (position - (d3(input.origin) + t * direction)).length();
        let smallest = f64::from(p.edge_u.length().min(p.edge_v.length()));
        assert!(moved < 10.0 * most, "moved by {moved}, of {smallest}: {o:?}");
        // A line along the normal through the position crosses the primitive there, well inside, and nearer than the
        // offset.
        let through = Ray { origin: position - geometric, direction: geometric, t_max: 2.0 };
        let crossed = crossings(&through, p).iter().any(|c| c.inside > 0.0 && (c.t - 1.0).abs() < epsilon);
        assert!(crossed, "{:?}: {o:?}", crossings(&through, p));
        // The leaving ray starts on the side of its direction.
        let side = geometric.dot(-direction);
        let off = (d3(o.leaving_origin) - position).dot(geometric) * side.signum();
        assert!(side.abs() < 1.0e-5 || (off - epsilon).abs() < 5.0e-7, "left by {off}: {o:?}");
        assert_eq!(d3(o.leaving_direction), -direction);
    }
    assert!(interpolated > 30, "{interpolated}");
}

/// Surfaces of rays towards primitives of all shapes, at a scale and away from the origin by `apart` of their scene's size.
fn placed(scale: f32, apart: Vec3) -> (Vec<Primitive>, Vec<TraceInput>) {
    let mut all = primitives(&SHAPES, 400, 92);
    for (index, p) in all.iter_mut().enumerate() {
        p.material = index as u32;
        (p.origin, p.edge_u, p.edge_v) = (scale * (p.origin + apart), scale * p.edge_u, scale * p.edge_v);
    }
    let place = |ray: &TraceInput| TraceInput::new(scale * (Vec3::from(ray.origin) + apart), Vec3::from(ray.direction));
    (all, rays(4096, false).iter().map(place).collect())
}

/// Rays that leave what a ray has hit: back along the ray, reflected, and nearly along the surface.
pub fn leaving(input: &TraceInput, o: &SurfaceOutput) -> [TraceInput; 3] {
    let (back, n) = (-d3(input.direction), d3(o.geometric_normal));
    let mirrored = 2.0 * back.dot(n) * n - back;
    let side = n * back.dot(n).signum();
    let grazing = (mirrored - 0.999 * mirrored.dot(side) * side).normalize_or(side);
    let origin = Vec3::from(o.leaving_origin);
    [back, mirrored, grazing].map(|d| TraceInput::new(origin, d.normalize().as_vec3()))
}

/// A ray that leaves a flat primitive never meets that primitive again, and one that leaves a sphere does so on the
/// other side only: at every scale, and far from the origin.
#[test]
fn rays_do_not_meet_what_they_leave() {
    let cases = [
        (1.0e-6, Vec3::ZERO),
        (1.0e-3, Vec3::ZERO),
        (1.0, Vec3::ZERO),
        (1.0e3, Vec3::ZERO),
        (1.0e6, Vec3::ZERO),
        (1.0, Vec3::new(300.0, -200.0, 100.0)),
        (1.0e-3, Vec3::new(2000.0, 3000.0, -1000.0)),
        (1.0e3, Vec3::new(1000.0, 300.0, -500.0)),
    ];
    for (scale, apart) in cases {
        let (primitives, rays) = placed(scale, apart);
        let surfaces = find(&primitives, &rays, 0);
        let hits: Vec<_> = rays.iter().zip(&surfaces).filter(|(_, o)| o.primitive != NONE).collect();
        assert!(hits.len() > 1000, "{} hits at {scale:e}", hits.len());
        let leaving: Vec<_> = hits.iter().flat_map(|(input, o)| leaving(input, o)).collect();
        for (ray, (index, again)) in leaving.iter().zip((0..).zip(find(&primitives, &leaving, 0))) {
            let (_, left) = hits[index / 3];
            let size = f64::from(left.size);
            let is_same = again.primitive != NONE && again.material == left.material;
            let (d, n) = (d3(ray.direction), d3(left.geometric_normal));
            // Inside a sphere, the ray meets it again after its chord.
            let chord = 2.0 * size * d.dot(n).abs();
            let is_chord = d.dot(n) < 0.0 && f64::from(again.t) > 0.5 * chord;
            let is_sphere = primitives[left.material as usize].shape == PrimitiveShape::Sphere;
            assert!(!is_same || (is_sphere && is_chord), "{scale:e} {apart}: {ray:?} leaves {left:?}, meets {again:?}");
        }
    }
}
