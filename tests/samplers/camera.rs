//! `camera_ray` of `glsl/include/camera.glsl`

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3, vec2, vec3};
use lodestar::gpu::BufferKind;
use lodestar::kernels::{Variant, test};
use lodestar::layout::SceneConstants;
use lodestar::reference::camera::camera_ray;

use crate::device::{Device, GROUP};

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct CameraRay {
    origin: [f32; 3],
    direction: [f32; 3],
    t_max: f32,
}

const FILM: Vec2 = vec2(640.0, 400.0);

fn scene() -> SceneConstants {
    let (eye, forward) = (vec3(3.0, -2.0, 5.0), vec3(-2.5, 2.7, -6.0).normalize());
    let left = Vec3::Y.cross(forward).normalize();
    let matrix =
        Mat4::from_cols(left.extend(0.0), forward.cross(left).extend(0.0), forward.extend(0.0), eye.extend(1.0));
    SceneConstants {
        world_from_camera: [0, 1, 2].map(|row| matrix.row(row).into()),
        film_size: FILM.into(),
        raster_scale: [0.7, 0.7 * FILM.y / FILM.x],
        principal_point: [0.05, -0.1],
        near_clip: 0.5,
        far_clip: 100.0,
        ..SceneConstants::zeroed()
    }
}

#[test]
fn rays_are_those_of_the_twin() {
    let (device, scene) = (Device::new(), scene());
    let at = |i: u32| vec2((i % 64) as f32 / 63.0, (i / 64) as f32 / 63.0) * FILM;
    let positions: Vec<Vec2> = (0..64 * 64).map(at).collect();
    let constants = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
    constants.upload(0, &[scene]).expect("uploaded");
    let input = device.uploaded("positions", &positions);
    let output = device.storage("rays", positions.len() * size_of::<CameraRay>());
    let kernel = device.kernel(&test::CAMERA, &Variant::default());
    device.dispatch(&kernel, &[&constants, &input, &output], &[], positions.len() as u32 / GROUP);
    let rays: Vec<CameraRay> = output.read(0, positions.len()).expect("read");
    let error = |ray: &CameraRay, position: Vec2| {
        let twin = camera_ray(&scene, position.as_dvec2());
        let origin = (Vec3::from(ray.origin).as_dvec3() - twin.origin).length();
        let direction = (Vec3::from(ray.direction).as_dvec3() - twin.direction).length();
        origin.max(direction).max((f64::from(ray.t_max) / twin.t_max - 1.0).abs())
    };
    for (ray, &position) in rays.iter().zip(&positions) {
        assert!(error(ray, position) < 2.0e-6, "{position}: {ray:?}");
        assert!(error(ray, position + 0.01) > 2.0e-6, "{position}: a hundredth of a pixel off");
    }
    // The center of projection lies where the principal point says.
    let center = camera_ray(&scene, ((0.5 - Vec2::from(scene.principal_point)) * FILM).as_dvec2());
    assert!((center.direction - vec3(-2.5, 2.7, -6.0).normalize().as_dvec3()).length() < 1.0e-6);
}
