//! Pictures at every scale, far from the origin, and with small things on huge ones, against closed forms.
//!
//! A white floor under a uniform sky of radiance 1 beside a black ball of radius r that lies on it: the ball hides the
//! share r^3 / (d^2 + r^2)^(3/2) of the light at the distance d from the contact, because its form factor there is
//! (r / D)^2 times the cosine of the angle to its center, whose distance D is sqrt(d^2 + r^2). A ray that starts too
//! far off the floor passes below the ball; one that starts below the floor brings nothing.

use glam::{DMat3, DMat4, DVec3, Quat, Vec3};
use lodestar::scene::{
    Bsdf, Camera, Environment, Primitive, PrimitiveShape, Scene, Surface, SurfaceMaterial, Textured,
};
use lodestar::settings::{Sampler, Settings};
use support::scenes::settings;
use support::significance::{ALPHA, sidak, two_sided};

use crate::device::Device;

const SIDE: u32 = 24;
const SPP: u32 = 256;
/// Samples of a pixel's area in each direction, for the closed form.
const PARTS: u32 = 8;

#[derive(Debug, Clone, Copy)]
enum Floor {
    Rectangle,
    Triangles,
    Disk,
    Sphere,
    /// A unit square that an instance shows.
    Instance,
}

const FLOORS: [Floor; 4] = [Floor::Rectangle, Floor::Triangles, Floor::Disk, Floor::Sphere];

/// A ball of `radius` that lies near `at` on a floor whose half side or radius is `extent`. The floor is around `at`, too,
/// or around the origin.
#[derive(Debug, Clone, Copy)]
struct Case {
    radius: f64,
    floor: Floor,
    extent: f64,
    at: DVec3,
    around_origin: bool,
    tilted: bool,
}

impl Case {
    fn new(radius: f64, floor: Floor, extent: f64) -> Self {
        Self { radius, floor, extent, at: DVec3::ZERO, around_origin: false, tilted: false }
    }

    fn at(self, x: f64, y: f64, z: f64) -> Self {
        Self { at: DVec3::new(x, y, z), ..self }
    }

    fn around_origin(self) -> Self {
        Self { around_origin: true, ..self }
    }

    fn tilted(self) -> Self {
        Self { tilted: true, ..self }
    }
}

/// A scene, and the ball and the plane of its floor as they are after rounding.
struct Contact {
    scene: Scene,
    center: DVec3,
    radius: f64,
    touched: DVec3,
    normal: DVec3,
}

fn contact(case: &Case) -> Contact {
    let turn = if case.tilted { Quat::from_rotation_z(0.7) * Quat::from_rotation_x(0.4) } else { Quat::IDENTITY };
    let [x, up, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turn * axis);
    let (extent, place) = (case.extent as f32, case.at.as_vec3());
    let middle = if case.around_origin { Vec3::ZERO } else { place };
    let mut scene = Scene::new(Camera::look_at([0.0; 3], [0.0, 0.0, 1.0], 40.0), SIDE, SIDE);
    let white = scene.add_diffuse([1.0; 3]);
    let black = scene.add_diffuse([0.0; 3]);
    match case.floor {
        Floor::Rectangle | Floor::Disk | Floor::Instance => {
            scene.add_parallelogram(middle, extent * z, extent * x, white)
        }
        Floor::Triangles => {
            let corner = |u: f32, v: f32| (middle + extent * (u * x + v * z)).to_array();
            let corners = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
            scene.add_mesh(&corners, &[[0, 1, 2], [0, 2, 3]], white);
        }
        Floor::Sphere => scene.add_sphere(middle - extent * up, extent, white),
    }
    if let Floor::Disk = case.floor {
        scene.primitives[0].shape = PrimitiveShape::Disk;
    }
    // Where the ball touches the floor as it is rounded.
    let Primitive { origin, edge_u, edge_v, .. } = scene.primitives[0];
    let [origin, edge_u, edge_v] = [origin, edge_u, edge_v].map(Vec3::as_dvec3);
    let (touched, normal) = match case.floor {
        Floor::Sphere => {
            let normal = (place.as_dvec3() - origin).normalize();
            (origin + edge_u.length() * normal, normal)
        }
        _ => {
            let normal = edge_u.cross(edge_v).normalize();
            let normal = normal * normal.dot(up.as_dvec3()).signum();
            (place.as_dvec3() - (place.as_dvec3() - origin).dot(normal) * normal, normal)
        }
    };
    let ball = (touched + case.radius * normal).as_vec3();
    scene.add_sphere(ball, case.radius as f32, black);
    let forward = (turn * Vec3::new(0.2, 0.0, -1.0)).as_dvec3().normalize();
    let eye = touched + case.radius * (1.5 * normal - 4.5 * forward);
    let target = touched - 0.8 * case.radius * forward;
    scene.camera = Camera {
        near_clip: (1.0e-3 * case.radius) as f32,
        far_clip: 3.0e37,
        ..Camera::look_at(eye.as_vec3(), target.as_vec3(), 40.0)
    };
    if let Floor::Instance = case.floor {
        // The ball stays in the world.
        let ball = scene.primitives.split_off(1);
        let Primitive { origin, edge_u, edge_v, .. } = scene.primitives[0];
        scene.primitives[0] = Primitive { origin: Vec3::ZERO, edge_u: Vec3::Z, edge_v: Vec3::X, ..scene.primitives[0] };
        let columns = [edge_v, extent * up, edge_u].map(|axis| axis.extend(0.0).as_dvec4());
        let group = scene.group_from(0);
        let [x, y, z] = columns;
        scene.add_instance(group, &DMat4::from_cols(x, y, z, origin.extend(1.0).as_dvec4()));
        scene.primitives = ball;
    }
    scene.environment = Some(Environment::constant(Vec3::ONE));
    Contact { scene, center: ball.as_dvec3(), radius: f64::from(case.radius as f32), touched, normal }
}

impl Contact {
    /// Probability that a camera ray brings light, and whether it meets the floor close to the ball. A path of two edges
    /// from a white floor brings 1 or nothing.
    fn expected(&self, [x, y]: [f64; 2]) -> (f64, bool) {
        let camera = &self.scene.camera;
        let eye = camera.world_from_camera.w_axis.truncate().as_dvec3();
        let axes = camera.world_from_camera.to_cols_array_2d();
        let axes = DMat3::from_cols_array_2d(&[0, 1, 2].map(|i| [0, 1, 2].map(|j| f64::from(axes[i][j]))));
        let tangent = (0.5 * f64::from(camera.fov).to_radians()).tan();
        let direction = (axes * DVec3::new((1.0 - 2.0 * x) * tangent, (1.0 - 2.0 * y) * tangent, 1.0)).normalize();
        let towards = self.center - eye;
        let along = towards.dot(direction);
        if along > 0.0 && (towards - along * direction).length() < self.radius {
            return (0.0, false);
        }
        let t = (self.touched - eye).dot(self.normal) / direction.dot(self.normal);
        if t < 0.0 {
            return (1.0, false);
        }
        let squared = (eye + t * direction - self.touched).length_squared();
        let hidden = self.radius.powi(3) / (squared + self.radius * self.radius).powf(1.5);
        (1.0 - hidden, squared < self.radius * self.radius)
    }

    /// Deviations from the closed form in standard errors: of the whole picture, and of the pixels where the ball hides
    /// most.
    fn deviations(&self, device: &Device, seed: u32) -> [f64; 2] {
        let settings =
            Settings { max_depth: 2, rr_depth: u32::MAX, ..settings(&self.scene, [SIDE, SIDE], Sampler::Bsdf, seed) };
        let picture = device.render(&self.scene, &settings, SPP);
        let mut sums = [[0.0; 2]; 2];
        for (index, color) in (0..).zip(&picture.radiance) {
            let mut sum = [0.0; 2];
            for part in 0..PARTS * PARTS {
                let inside = |pixel: u32, part: u32| {
                    (f64::from(pixel) + (f64::from(part) + 0.5) / f64::from(PARTS)) / f64::from(SIDE)
                };
                let at = [inside(index % SIDE, part % PARTS), inside(index / SIDE, part / PARTS)];
                let (light, is_close) = self.expected(at);
                sum = [sum[0] + light, sum[1] + f64::from(is_close)];
            }
            let [light, close] = sum.map(|sum| sum / f64::from(PARTS * PARTS));
            let parts = [(0, true), (1, close == 1.0)];
            for (part, _) in parts.into_iter().filter(|(_, counts)| *counts) {
                sums[part][0] += f64::from(color[0]) - light;
                sums[part][1] += light * (1.0 - light) / f64::from(SPP);
            }
        }
        assert!(sums[1][1] > 0.0, "no pixel is close to the ball");
        sums.map(|[difference, variance]| difference / variance.sqrt())
    }
}

fn cases() -> Vec<Case> {
    let mut all = Vec::new();
    // Whole scenes, from tiny to huge.
    for scale in [1.0e-6, 1.0e-3, 1.0, 1.0e3, 1.0e6] {
        all.extend(FLOORS.map(|floor| Case::new(scale, floor, 1.0e4 * scale)));
        all.push(Case::new(scale, Floor::Rectangle, 1.0e4 * scale).tilted());
    }
    // Small things on huge floors.
    all.extend(FLOORS.map(|floor| Case::new(1.0e-4, floor, 1.0e5)));
    all.extend(FLOORS.map(|floor| Case::new(1.0e-2, floor, 1.0e6)));
    all.push(Case::new(1.0e-4, Floor::Rectangle, 1.0e5).tilted());
    all.push(Case::new(1.0e-4, Floor::Disk, 1.0e5).tilted());
    all.push(Case::new(1.0e-4, Floor::Sphere, 1.0e5).tilted());
    all.push(Case::new(1.0, Floor::Triangles, 1.0e5).tilted());
    // Beside the middle of a huge floor.
    for floor in [Floor::Rectangle, Floor::Triangles, Floor::Disk] {
        all.push(Case::new(1.0e-3, floor, 1.0e5).at(3.0, 0.0, -2.0).around_origin());
    }
    // Far from the origin. A float's spacing there is the 1.6-thousandth part of the ball's radius.
    for floor in FLOORS {
        all.push(Case::new(0.1, floor, 50.0).at(1000.0, -300.0, 500.0));
        all.push(Case::new(100.0, floor, 5.0e4).at(1.0e6, 3.0e5, -5.0e5));
    }
    all.push(Case::new(0.1, Floor::Rectangle, 50.0).at(1000.0, -300.0, 500.0).tilted());
    all.push(Case::new(0.1, Floor::Triangles, 50.0).at(1000.0, -300.0, 500.0).tilted());
    all
}

/// Floors that instances show. The unit square becomes as large as the extent.
fn cases_of_instances() -> Vec<Case> {
    let case = |radius, extent| Case::new(radius, Floor::Instance, extent);
    vec![
        case(1.0, 1.0e4),
        case(1.0e-4, 1.0),
        case(1.0e-4, 1.0e4).tilted(),
        case(1.0e-4, 1.0e-4 * 50.0).tilted(),
        case(1.0e-3, 1.0e4).at(3.0, 0.0, -2.0).around_origin(),
        case(0.1, 50.0).at(1000.0, -300.0, 500.0),
        case(0.1, 50.0).at(1000.0, -300.0, 500.0).tilted(),
        case(100.0, 1.0e4).at(1.0e6, 3.0e5, -5.0e5),
    ]
}

#[test]
fn contact_shadows_are_right_at_every_scale() {
    Device::of_each_traversal().iter().for_each(|device| check_contact_shadows(device, &cases()));
}

#[test]
fn contact_shadows_are_right_on_floors_that_instances_show() {
    check_contact_shadows(&Device::new(), &cases_of_instances());
}

fn check_contact_shadows(device: &Device, cases: &[Case]) {
    let mut failures = Vec::new();
    for (seed, case) in (1..).zip(cases) {
        let z = contact(case).deviations(device, seed);
        println!("{case:?}: {z:.2?}");
        let is_right = |&z: &f64| sidak(two_sided(z), 2 * cases.len()) > ALPHA;
        if !z.iter().all(is_right) {
            failures.push(format!("{case:?}: {z:.2?}"));
        }
    }
    assert!(failures.is_empty(), "{}: {failures:#?}", device.traversal());
}

/// The twin must fail: a ball that floats a twentieth of its radius above the floor, as if rays began that far off it.
#[test]
fn a_shadow_that_has_come_off_is_found() {
    Device::of_each_traversal().iter().for_each(find_a_shadow_that_has_come_off);
}

fn find_a_shadow_that_has_come_off(device: &Device) {
    let mut contact = contact(&Case::new(1.0e-4, Floor::Rectangle, 1.0e5));
    contact.touched -= 0.05 * contact.radius * contact.normal;
    let [_, close] = contact.deviations(device, 3);
    assert!(sidak(two_sided(close), 200) < ALPHA, "{close}");
}

/// A mirror ball under a layer of glass, in a sky of radiance 1. Nothing absorbs light, so all that is seen has radiance 1.
/// A ray that starts beyond the layer gets into the ball, whose inside is black.
fn coated_mirror(radius: f32, gap: f32, place: Vec3) -> Scene {
    let mut scene = Scene::new(Camera::look_at([0.0; 3], [0.0, 0.0, 1.0], 40.0), 16, 16);
    let mirror = scene.add_material(SurfaceMaterial::plain(Bsdf::Conductor {
        eta: Vec3::ZERO,
        k: Vec3::ONE,
        specular_reflectance: Textured::constant(Vec3::ONE),
    }));
    let glass = scene.add_material(SurfaceMaterial::plain(Bsdf::Dielectric {
        eta: 1.5,
        specular_reflectance: Textured::constant(Vec3::ONE),
        specular_transmittance: Textured::constant(Vec3::ONE),
    }));
    scene.add_sphere(place, radius, mirror);
    scene.add_sphere(place, radius + gap, glass);
    scene.environment = Some(Environment::constant(Vec3::ONE));
    let eye = place + radius * Vec3::new(0.5, 1.0, 3.0);
    scene.camera = Camera { near_clip: 0.01 * radius, far_clip: 3.0e37, ..Camera::look_at(eye, place, 40.0) };
    scene
}

/// Mean radiance of the coated mirror.
fn seen(device: &Device, scene: &Scene) -> f64 {
    let settings = Settings {
        max_depth: 256,
        rr_depth: u32::MAX,
        samples_per_dispatch: 2,
        ..settings(scene, [16, 16], Sampler::Bsdf, 9)
    };
    let picture = device.render(scene, &settings, 64);
    picture.radiance.iter().map(|color| f64::from(color[0])).sum::<f64>() / picture.radiance.len() as f64
}

#[test]
fn no_ray_jumps_a_thin_gap() {
    Device::of_each_traversal().iter().for_each(check_thin_gaps);
}

fn check_thin_gaps(device: &Device) {
    for scale in [1.0e-6, 1.0e-3, 1.0, 1.0e3, 1.0e6] {
        for gap in [1.0e-4, 1.0e-6] {
            let mean = seen(device, &coated_mirror(0.07 * scale, gap * scale, Vec3::ZERO));
            println!("scale {scale:e}, gap {gap:e}: {mean:.6}");
            assert!((mean - 1.0).abs() < 2.0e-4, "scale {scale:e}, gap {gap:e}: {mean}");
        }
    }
    let mean = seen(device, &coated_mirror(0.07, 1.0e-4, Vec3::new(3.0, -1.0, 2.0)));
    assert!((mean - 1.0).abs() < 2.0e-4, "beside the origin: {mean}");
}

/// Radiance of a white floor below a lamp: its radiance times its projected solid angle over pi.
fn lamp_over_floor(shape: PrimitiveShape, size: f32, height: f32) -> (Scene, f64) {
    let camera = Camera::look_at([0.0, 0.01 * height, 0.01 * height], [0.0; 3], 10.0);
    let mut scene = Scene::new(Camera { near_clip: 1.0e-4 * height, far_clip: 3.0e37, ..camera }, 16, 16);
    let white = scene.add_diffuse([1.0; 3]);
    scene.add_parallelogram([0.0; 3], height * Vec3::Z, height * Vec3::X, white);
    // Off the axis by a tenth, so that no coordinate is 0.
    let [size64, height64] = [size, height].map(f64::from);
    let radiance = Vec3::splat((height64 / size64).powi(2) as f32);
    let lamp = scene.add_light(radiance);
    let center = Vec3::new(0.1 * height, height, 0.1 * height);
    let add_flat = |scene: &mut Scene, lamp: Surface| {
        scene.add_parallelogram(center, size * Vec3::X, size * Vec3::Z, lamp);
        scene.primitives[1].shape = shape;
    };
    match shape {
        PrimitiveShape::Sphere => scene.add_sphere(center, size, lamp),
        PrimitiveShape::FacingDisk => scene.add_facing_disk(center, size, radiance),
        _ => add_flat(&mut scene, lamp),
    }
    let squared = 1.02;
    let cosine = 1.0 / f64::sqrt(squared);
    let area = match shape {
        PrimitiveShape::Parallelogram => 4.0 / std::f64::consts::PI * cosine,
        PrimitiveShape::Disk => cosine,
        // The disk is as wide as the sphere from everywhere, but not far.
        PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => 1.0,
        PrimitiveShape::Triangle => 0.5 / std::f64::consts::PI * cosine,
    };
    (scene, area * cosine / squared)
}

#[test]
fn small_far_lamps_are_as_bright_as_they_are() {
    Device::of_each_traversal().iter().for_each(check_small_far_lamps);
}

fn check_small_far_lamps(device: &Device) {
    let facing = PrimitiveShape::FacingDisk;
    let flat = [PrimitiveShape::Disk, PrimitiveShape::Parallelogram, PrimitiveShape::Triangle];
    for shape in [PrimitiveShape::Sphere, facing].into_iter().chain(flat) {
        for (size, height) in [(0.5, 1122.0), (1.0e-4, 10.0), (1.0e-4, 1.0e3), (1.0e-6, 1.0e-3), (10.0, 1.0e6)] {
            let (scene, expected) = lamp_over_floor(shape, size, height);
            let settings = Settings {
                max_depth: 2,
                nee: true,
                rr_depth: u32::MAX,
                ..settings(&scene, [16, 16], Sampler::Bsdf, 5)
            };
            let picture = device.render(&scene, &settings, 16);
            let mean = picture.radiance.iter().map(|c| f64::from(c[0])).sum::<f64>() / picture.radiance.len() as f64;
            println!("{shape:?} of {size:e} at {height:e}: {mean:.6}, expected {expected:.6}");
            assert!(
                (mean / expected - 1.0).abs() < 2.0e-3,
                "{shape:?} of {size:e} at {height:e}: {mean}, not {expected}"
            );
        }
    }
}
