//! Rays of the three kinds that a path tracer traces, created on the host, and the kernels that trace them.

use std::f64::consts::PI;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Mat4, Vec3, dvec2};
use lodestar::encode::bvh::Bvh;
use lodestar::generated::kernels::{
    CAMERA_ORTHOGRAPHIC, CAMERA_PERSPECTIVE, CAMERA_THINLENS, NONE, PRIMITIVE_SHAPE_MASK, SHAPE_SPHERE, Variant, test,
};
use lodestar::generated::layout::SceneConstants;
use lodestar::gpu::{Buffer, BufferKind, DeviceKind, Kernel, KernelSource, Submission};
use lodestar::math::equal_area::square_to_sphere;
use lodestar::scene::{Primitive, PrimitiveShape, Projection, Scene};

use crate::device::{Device, GROUP};
use crate::twins::camera::camera_ray;
use crate::twins::random::{RandomKey, RandomStream, SampleSet, next_random, random_stream};

/// Ray: `TraceInput` of `glsl/test/traverse.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Ray {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    pub t_max: f32,
    /// Flag: 1 if any hit suffices.
    pub any_hit: u32,
}

/// Hit: `TraceOutput` of `glsl/test/traverse.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Found {
    t: f32,
    uv: [f32; 2],
    primitive: u32,
    instance: u32,
    overrun: u32,
}

/// Counts of fetches: `TraceCounts` of `glsl/test/traverse_counts.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Counts {
    pub nodes: u32,
    pub primitives: u32,
    pub overrun: u32,
}

/// Names of the three kinds of rays, and whether any hit suffices.
pub const KINDS: [(&str, bool); 3] = [("primary", false), ("bounce", false), ("shadow", true)];
/// Distance at which rays start off surfaces, as a share of the scene's largest coordinate.
const OFFSET: f32 = 1.0e-4;
/// Distance at which shadow rays end before the light, as a share of their length.
const SHORT_OF_LIGHT: f64 = 1.0e-3;
const ENDLESS: f64 = 1.0e30;

/// Hierarchy of a scene on the device, and a kernel that traces [`Ray`]s through it.
pub struct Tracer {
    device: Arc<Device>,
    kernel: Kernel,
    nodes: Arc<Buffer>,
    primitives: Arc<Buffer>,
    attributes: Arc<Buffer>,
}

/// Rays on the device, and memory for their results.
pub struct Batch {
    pub rays: Vec<Ray>,
    input: Arc<Buffer>,
    output: Arc<Buffer>,
}

impl Batch {
    pub fn new(device: &Device, rays: Vec<Ray>) -> Self {
        let input = device.uploaded("rays", &rays);
        let output = device.storage("hits", rays.len() * size_of::<Found>().max(size_of::<Counts>()));
        Self { rays, input, output }
    }
}

/// Specialization constants with which rays are traced in a hierarchy.
pub fn variant_of(bvh: &Bvh) -> Variant {
    Variant {
        has_spheres: bvh.has_spheres(),
        has_front_only: bvh.has_front_only(),
        has_instances: bvh.has_instances(),
        stack_size: bvh.depth,
        ..Variant::default()
    }
}

impl Tracer {
    /// Creates a tracer. `source` is a kernel with the interface of `glsl/test/traverse.comp`.
    pub fn new(device: &Arc<Device>, bvh: &Bvh, source: &KernelSource) -> Self {
        let texels = |name: &str, bytes: &[u8]| {
            let buffer = device.buffer(name, bytes.len(), BufferKind::TexelUint);
            buffer.upload(0, bytes).expect("uploaded");
            buffer
        };
        Self {
            kernel: device.kernel(source, &variant_of(bvh)),
            nodes: texels("nodes", bytemuck::cast_slice(&bvh.nodes)),
            primitives: texels("primitives", bytemuck::cast_slice(&bvh.primitives)),
            attributes: texels("attributes", bytemuck::cast_slice(&bvh.attributes)),
            device: Arc::clone(device),
        }
    }

    /// Buffer of the nodes on the device.
    pub fn nodes(&self) -> &Arc<Buffer> {
        &self.nodes
    }

    /// Whether the device can read a hierarchy of this size through texels, as the test kernels do.
    pub fn fits(device: &Device, bvh: &Bvh) -> bool {
        let bytes = [size_of_val(&bvh.nodes[..]), size_of_val(&bvh.primitives[..]), size_of_val(&bvh.attributes[..])];
        let bytes = bytes.into_iter().max().unwrap_or(0);
        device.has_room("a hierarchy", bytes, 16)
    }

    pub fn trace(&self, batch: &Batch) -> Submission {
        let buffers = [&batch.input, &batch.output, &self.nodes, &self.primitives, &self.attributes];
        self.device.dispatch(&self.kernel, &buffers, &[], batch.rays.len() as u32 / GROUP)
    }

    /// Results that the kernel has written for each ray.
    pub fn outputs<T: Pod>(&self, batch: &Batch) -> Vec<T> {
        self.trace(batch);
        batch.output.read(0, batch.rays.len()).expect("read")
    }
}

/// Size of the picture for which rays are created. It has enough pixels to keep the device busy.
pub fn picture(device: &Device) -> [u32; 2] {
    if device.context.device().kind == DeviceKind::Cpu { [512; 2] } else { [1024; 2] }
}

/// Rays of all [`KINDS`] for a picture of the given size. Camera rays are in the order of tiles. Bounce rays start
/// where camera rays hit, with cosine-weighted directions. Shadow rays go from there to points of area lights, or in
/// any direction if there are none. Rays that miss, or that would start downwards, are replaced by others.
pub fn make(device: &Arc<Device>, scene: &Scene, bvh: &Bvh, [width, height]: [u32; 2]) -> [Vec<Ray>; 3] {
    let mut random = random_stream(RandomKey { pixel: 0, sample_index: 0, set: SampleSet::Alone, seed: 7 }, 0, 0);
    let primary = primary_rays(scene, [width, height], &mut random);
    let tracer = Tracer::new(device, bvh, &test::TRAVERSE);
    let batch = Batch::new(device, primary);
    let found: Vec<Found> = tracer.outputs(&batch);
    let offset = OFFSET * bvh.largest_coordinate();
    let hits: Vec<_> = batch.rays.iter().zip(&found).filter_map(|(ray, found)| surface_hit(bvh, ray, found)).collect();
    assert!(!hits.is_empty(), "the camera sees nothing");
    let lights = Lights::new(scene);
    let [mut bounce, mut shadow] = [Vec::new(), Vec::new()];
    for &(position, normal) in hits.iter().cycle().take(4 * batch.rays.len()) {
        let origin = (position + normal * f64::from(offset)).as_vec3();
        bounce.push(ray(origin, cosine_direction(normal, &mut random), ENDLESS, false));
        let (direction, t_max) = lights.towards(origin.as_dvec3(), &mut random);
        if direction.dot(normal) > 0.0 {
            shadow.push(ray(origin, direction, t_max, true));
        }
        if shadow.len() == batch.rays.len() {
            break;
        }
    }
    let count = batch.rays.len();
    let filled =
        |rays: Vec<Ray>| if rays.is_empty() { rays } else { rays.iter().copied().cycle().take(count).collect() };
    [batch.rays, filled(bounce), filled(shadow)]
}

fn ray(origin: Vec3, direction: DVec3, t_max: f64, any_hit: bool) -> Ray {
    let direction = direction.as_vec3().into();
    Ray { origin: origin.into(), direction, t_max: t_max as f32, any_hit: u32::from(any_hit) }
}

/// Camera rays through a point of each pixel, in tiles of 8 x 8.
fn primary_rays(scene: &Scene, [width, height]: [u32; 2], random: &mut RandomStream) -> Vec<Ray> {
    let (kind, constants) = camera(scene, [width, height]);
    let mut rays = Vec::new();
    for tile in 0..(width / 8) * (height / 8) {
        for within in 0..64 {
            let corner = dvec2(f64::from(tile % (width / 8) * 8), f64::from(tile / (width / 8) * 8));
            let pixel = corner + dvec2(f64::from(within % 8), f64::from(within / 8));
            let [a, b, c, d] = [(); 4].map(|()| next_random(random));
            let of_camera = camera_ray(kind, &constants, pixel + dvec2(a, b), dvec2(c, d));
            rays.push(ray(of_camera.origin.as_vec3(), of_camera.direction, of_camera.t_max, false));
        }
    }
    rays
}

/// Kind and constants of the camera, in the form that kernels use.
fn camera(scene: &Scene, [width, height]: [u32; 2]) -> (u32, SceneConstants) {
    let camera = &scene.camera;
    let (kind, [aperture_radius, focus_distance]) = match camera.projection {
        Projection::Perspective => (CAMERA_PERSPECTIVE, [0.0, 1.0]),
        Projection::ThinLens { aperture_radius, focus_distance } => {
            (CAMERA_THINLENS, [aperture_radius, focus_distance])
        }
        Projection::Orthographic => (CAMERA_ORTHOGRAPHIC, [0.0, 1.0]),
        panorama => panic!("{panorama:?} is not measured"),
    };
    let matrix: Mat4 = camera.world_from_camera;
    let constants = SceneConstants {
        world_from_camera: [0, 1, 2].map(|row| matrix.row(row).into()),
        film_size: [width as f32, height as f32],
        raster_scale: camera.half_extent(width, height).into(),
        principal_point: camera.principal_point.into(),
        near_clip: camera.near_clip,
        far_clip: camera.far_clip,
        aperture_radius,
        focus_distance,
        ..SceneConstants::zeroed()
    };
    (kind, constants)
}

/// Position of a ray's hit, and the geometric normal on the ray's side.
fn surface_hit(bvh: &Bvh, ray: &Ray, found: &Found) -> Option<(DVec3, DVec3)> {
    if found.primitive == NONE {
        return None;
    }
    let [origin, direction] = [ray.origin, ray.direction].map(|v| Vec3::from(v).as_dvec3());
    let position = origin + f64::from(found.t) * direction;
    let record = &bvh.primitives[found.primitive as usize];
    let [corner, edge_u, edge_v] = [record.origin, record.edge_u, record.edge_v].map(|v| Vec3::from(v).as_dvec3());
    let normal =
        if record.flags & PRIMITIVE_SHAPE_MASK == SHAPE_SPHERE { position - corner } else { edge_u.cross(edge_v) };
    let normal = normal.normalize();
    normal.is_finite().then_some((position, if normal.dot(direction) > 0.0 { -normal } else { normal }))
}

fn uniform_direction(random: &mut RandomStream) -> DVec3 {
    let [x, y] = [(); 2].map(|()| 2.0 * next_random(random) - 1.0);
    square_to_sphere(dvec2(x, y))
}

/// Cosine-weighted direction: the normalized sum of the normal and a random unit vector.
fn cosine_direction(normal: DVec3, random: &mut RandomStream) -> DVec3 {
    (normal + uniform_direction(random)).normalize_or(normal)
}

/// Area lights of a scene, to be chosen in proportion to their area.
struct Lights<'a> {
    lights: Vec<&'a Primitive>,
    /// Cumulative areas of the lights.
    ends: Vec<f64>,
}

impl<'a> Lights<'a> {
    fn new(scene: &'a Scene) -> Self {
        let lights: Vec<_> = scene.primitives.iter().filter(|primitive| primitive.emitter.is_some()).collect();
        let mut sum = 0.0;
        let ends = lights.iter().map(|light| {
            sum += area(light);
            sum
        });
        Self { ends: ends.collect(), lights }
    }

    /// Direction and length of a ray towards a light.
    fn towards(&self, from: DVec3, random: &mut RandomStream) -> (DVec3, f64) {
        let Some(&all) = self.ends.last() else { return (uniform_direction(random), ENDLESS) };
        let at = all * next_random(random);
        let light = self.ends.partition_point(|&end| end <= at).min(self.lights.len() - 1);
        let way = point_on(self.lights[light], random) - from;
        (way.normalize(), way.length() * (1.0 - SHORT_OF_LIGHT))
    }
}

fn area(light: &Primitive) -> f64 {
    let product = f64::from(light.edge_u.cross(light.edge_v).length());
    match light.shape {
        PrimitiveShape::Triangle => 0.5 * product,
        PrimitiveShape::Parallelogram => 4.0 * product,
        PrimitiveShape::Disk => PI * product,
        PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => 4.0 * PI * f64::from(light.edge_u.length_squared()),
    }
}

/// Point of a light, uniform over its area.
fn point_on(light: &Primitive, random: &mut RandomStream) -> DVec3 {
    let [origin, edge_u, edge_v] = [light.origin, light.edge_u, light.edge_v].map(|v| v.as_dvec3());
    let [a, b] = [(); 2].map(|()| next_random(random));
    let (u, v) = match light.shape {
        PrimitiveShape::Triangle if a + b > 1.0 => (1.0 - a, 1.0 - b),
        PrimitiveShape::Triangle => (a, b),
        PrimitiveShape::Parallelogram => (2.0 * a - 1.0, 2.0 * b - 1.0),
        PrimitiveShape::Disk => (a.sqrt() * (2.0 * PI * b).cos(), a.sqrt() * (2.0 * PI * b).sin()),
        PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => {
            return origin + uniform_direction(random) * edge_u.length();
        }
    };
    origin + u * edge_u + v * edge_v
}
